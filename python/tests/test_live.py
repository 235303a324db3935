# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

import tetune
from meshes import shaken_box, smallest_dihedral, volumes


def live_box(**options):
    return tetune.LiveMesh(tetune.optimize(*shaken_box()).mesh, **options)


def inner_vertex(points, near):
    low, high = points.min(axis=0), points.max(axis=0)
    inside = np.all((points > low + 0.1) & (points < high - 0.1), axis=1)
    distance = np.linalg.norm(points - near, axis=1)
    return int(np.argmin(np.where(inside, distance, np.inf)))


def test_a_vertex_set_elsewhere_is_improved_around_it():
    live = live_box(neighborhood=1)
    points, tets = live.points, live.tets
    v = inner_vertex(points, points.mean(axis=0))
    live.set_points(v, points[v] + [0.1, 0.05, 0])
    assert live.disturbed == 1
    report = live.optimize()
    assert live.disturbed == 0 and 0 < report.tets_active <= len(tets)
    assert volumes(live.points, live.tets).min() > 0
    assert tetune.validate(live.mesh) == ""


def test_copies_stay_when_the_mesh_changes():
    live = live_box()
    points = live.points
    kept = points.copy()
    v = inner_vertex(points, points.mean(axis=0))
    live.set_points([v], [points[v] + [0.05, 0, 0]])
    live.optimize(everything=True)
    assert np.array_equal(points, kept)
    assert smallest_dihedral(live.points, live.tets).min() > 5


def test_move_ends_at_the_target():
    live = live_box()
    target = np.full_like(live.points, np.nan)
    v = inner_vertex(live.points, live.points.mean(axis=0))
    target[v] = live.points[v] + [0.2, 0.1, 0]
    report = live.move(target)
    assert report.reached and np.array_equal(live.points[v], target[v])
    assert volumes(live.points, live.tets).min() > 0


def test_wrong_arguments_are_refused():
    live = live_box()
    with pytest.raises(tetune.OptionError, match="does not exist"):
        live.set_points(-1, [0.0, 0, 0])
    with pytest.raises(tetune.OptionError, match="positions for|one per vertex|shape"):
        live.move(np.zeros((2, 3)))
    with pytest.raises(tetune.OptionError, match="only_below"):
        live_box(only_below={"min_dihedral_deg": 10})
    with pytest.raises(tetune.OptionError, match="neighborhood"):
        live_box(neighborhood=0)
    with pytest.raises(TypeError, match="vertices must be integers"):
        live.set_points([0.5], [[0.0, 0, 0]])


def test_everything_is_optimized_on_request():
    moved = {}
    for everything in (False, True):
        live = tetune.LiveMesh(*shaken_box(), neighborhood=1)
        points = live.points
        v = inner_vertex(points, points.max(axis=0))
        live.set_points(v, points[v] + [0.02, 0, 0])
        before = live.points
        live.optimize(everything=everything)
        moved[everything] = (live.points != before).any(axis=1)
    inner = ((points > 0.01) & (points < points.max(axis=0) - 0.01)).all(axis=1)
    assert moved[False].sum() < inner.sum() / 2 and moved[True][inner].mean() > 0.95


def test_no_vertex_set_elsewhere():
    live = live_box()
    before = live.points
    for vertices in ([], np.zeros(0), np.zeros(0, np.int64)):
        live.set_points(vertices, np.zeros((0, 3)))
    live.set_points([], [])
    assert live.disturbed == 0 and np.array_equal(live.points, before)
    with pytest.raises(tetune.OptionError, match=r"must be \(0, 3\)"):
        live.set_points([], [[0.0, 0, 0]])
