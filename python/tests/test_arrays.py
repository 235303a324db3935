# SPDX-License-Identifier: Apache-2.0
import copy
import gc
import json
import os
import pickle
import platform
import re
import signal
import subprocess
import sys
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest

import tetune
from meshes import BRACKET, shaken_box, smallest_dihedral, volumes


def test_better_valid_and_input_untouched():
    points, tets = shaken_box()
    kept = points.copy(), tets.copy()
    r = tetune.optimize(points, tets)
    assert np.array_equal(points, kept[0]) and np.array_equal(tets, kept[1])
    assert r.mesh.points.shape == points.shape and r.mesh.tets.shape[1] == 4
    assert volumes(r.mesh.points, r.mesh.tets).min() > 0
    assert volumes(r.mesh.points, r.mesh.tets).sum() == pytest.approx(128)
    assert smallest_dihedral(r.mesh.points, r.mesh.tets).min() > smallest_dihedral(points, tets).min() + 5
    assert tetune.validate(r.mesh) == ""
    assert r.report.stop == "converged" and r.report.tets_after == len(r.mesh.tets)
    assert r.report.energy_after < r.report.energy_before
    assert 0 < sum(r.report.phases.values()) <= r.report.seconds


@pytest.mark.parametrize("index", [np.int32, np.int64, np.uint32, np.uint64])
def test_every_layout_gives_the_same_bits(index):
    points, tets = shaken_box()
    expected = tetune.optimize(points, tets, threads=1)
    for p, t in (
        (points, tets.astype(index)),
        (np.asfortranarray(points), np.asfortranarray(tets.astype(index))),
        (np.repeat(points, 2, axis=0)[::2], np.repeat(tets.astype(index), 2, axis=1)[:, ::2]),
        (points.tolist(), tets.tolist()),
    ):
        r = tetune.optimize(p, t, threads=3)
        assert np.array_equal(r.mesh.points, expected.mesh.points)
        assert np.array_equal(r.mesh.tets, expected.mesh.tets)


def test_maps():
    points, tets = shaken_box(10, 6, 6)
    tags = (points[tets].mean(axis=1)[:, 0] > 5).astype(int) + 3
    r = tetune.optimize(tetune.TetMesh(points, tets, tet_tags=tags), effort="best")
    assert r.report.vertices_inserted + r.report.vertices_removed > 0, "the test needs a case where vertices change"
    assert len(r.mesh.points) - len(points) == r.report.vertices_inserted - r.report.vertices_removed
    assert 0 < (r.vertex_map < 0).sum() <= r.report.vertices_inserted  # some may have been removed again
    assert np.array_equal(r.mesh.tet_tags, tags[r.parent])
    old = r.vertex_map >= 0
    assert r.moved[~old].all()
    assert np.array_equal(r.moved[old], (r.mesh.points[old] != points[r.vertex_map[old]]).any(axis=1))
    assert 0 < r.moved.sum() < len(r.moved)


def test_maps_where_all_vertices_are_kept():
    points, tets = shaken_box()
    r = tetune.optimize(points, tets)
    assert np.array_equal(r.vertex_map, np.arange(len(points)))
    assert np.array_equal(r.moved, (r.mesh.points != points).any(axis=1))


def test_turned_inside_out():
    points, tets = shaken_box()
    r = tetune.optimize(points, tets[:, [0, 1, 3, 2]])
    assert np.array_equal(r.mesh.points, tetune.optimize(points, tets).mesh.points)
    assert volumes(r.mesh.points, r.mesh.tets).min() > 0


def test_some_turned_inside_out():
    points, tets = shaken_box()
    some = np.where(np.arange(len(tets))[:, None] % 5 == 0, tets[:, [0, 1, 3, 2]], tets)
    with pytest.warns(UserWarning, match=f"{len(tets) // 5} tetrahedra were listed inside out"):
        r = tetune.optimize(points, some)
    assert volumes(r.mesh.points, r.mesh.tets).min() > 0


def test_untangle():
    points, tets = shaken_box()
    middle = np.flatnonzero((np.round(points) == [4, 2, 2]).all(axis=1))
    points[middle] += [1.6, 0, 0]
    assert volumes(points, tets).min() < 0
    with pytest.raises(tetune.MeshError, match="inverted"):
        tetune.optimize(points, tets)
    r = tetune.optimize(points, tets, untangle=True)
    assert r.report.tets_untangled == (volumes(points, tets) <= 0).sum()
    assert volumes(r.mesh.points, r.mesh.tets).min() > 0
    assert issubclass(tetune.UntangleError, tetune.MeshError)


def test_listed_entities_follow():
    points, tets = shaken_box(4, 3, 3)
    inside = tets[volumes(points, tets).argmax()][:3]  # an untagged triangle inside: no constraint
    bottom = [[0, 1, 5], [1, 6, 5]]
    patch = tetune.TetMesh(points, tets, triangles=[tets[0][:3], *bottom], triangle_tags=[0, 7, 7])
    frozen = tetune.optimize(patch, frozen_patches=[7]).mesh
    assert np.array_equal(frozen.points[bottom], points[bottom])
    opened = tetune.TetMesh(points, tets, triangles=[inside], triangle_tags=[5])
    assert tetune.optimize(opened).report.triangles_dropped == 0
    assert tetune.optimize(opened, open_boundaries=False).report.triangles_dropped == 1
    mesh = tetune.TetMesh(
        points, tets, triangles=[inside, *bottom], triangle_tags=[0, 7, 7], edges=[[0, 1]], edge_tags=[2],
        required_vertices=[40], others=[("Quadrilaterals", [[0, 1, 6, 5]])],
    )
    r = tetune.optimize(mesh, boundary="fixed")
    assert r.report.triangles_dropped == 1
    assert np.array_equal(r.report.triangle2original, [1, 2])
    assert np.array_equal(r.mesh.triangle_tags, [7, 7]) and np.array_equal(r.mesh.triangles, bottom)
    assert len(r.report.edge2original) == 0 and np.array_equal(r.mesh.edges, [[0, 1]])
    assert not r.moved[40]
    kind, quads = r.mesh.others[0]
    assert kind == "Quadrilaterals" and np.array_equal(quads, [[0, 1, 6, 5]])


def test_options_take_effect():
    points, tets = shaken_box()
    frozen = np.zeros(len(points), dtype=bool)
    frozen[::2] = True
    r = tetune.optimize(points, tets, frozen_vertices=frozen, max_iterations=2, boundary="fixed", max_ring=3)
    assert not r.moved[frozen].any() and r.moved.any()
    r = tetune.optimize(points, tets, frozen_vertices=256 * frozen, max_iterations=2, boundary="fixed")  # any flag other than 0
    assert not r.moved[frozen].any() and r.moved.any()
    r = tetune.optimize(points, tets, frozen_vertices=frozen, max_iterations=2, boundary="fixed", max_ring=3)
    assert len(r.report.sweeps) == 2 and r.report.stop == "iteration limit"
    assert r.report.edge_removals == r.report.face_removals == 0
    tags = (points[tets].mean(axis=1)[:, 0] > 4).astype(int)
    r = tetune.optimize(tetune.TetMesh(points, tets, tet_tags=tags), frozen_regions=[1], max_iterations=np.int64(3))
    assert {tuple(sorted(t)) for t in tets[tags == 1]} == {tuple(sorted(t)) for t in r.mesh.tets[r.mesh.tet_tags == 1]}
    default = tetune.optimize(points, tets).mesh
    for name, value, differs in [
        ("device", "cpu", False), ("boundary", "preserve", False), ("effort", "standard", False),
        ("keep_vertices", True, False), ("feature_angle", 30, False), ("boundary", "slide", True),
        ("energy", "harmonic", True), ("effort", "fast", True), ("relocation", "gradient", True),
        ("termination", "paper", True),
    ]:
        points_now = tetune.optimize(points, tets, **{name: value}).mesh.points
        assert np.array_equal(points_now, default.points) != differs, name
    bracket = tetune.read_mesh(str(BRACKET))
    assert tetune.optimize(bracket).report.boundary_flips > 0
    assert tetune.optimize(bracket, boundary_flips=False).report.boundary_flips == 0
    r = tetune.optimize(points, tets, boundary="slide", max_deviation=1e-3)
    assert r.report.energy_after < r.report.energy_before


def test_the_automatic_device_says_why():
    points, tets = shaken_box(2, 2, 2)
    assert tetune.optimize(points, tets).report.device_reason == ""
    report = tetune.optimize(points, tets, device="auto").report
    assert (report.device, report.device_reason) == ("CPU", "below 500000 tetrahedra")


def test_traced_angles():
    points, tets = shaken_box()
    r = tetune.optimize(points, tets, trace_angles=True)
    last = (r.report.worst_rounds or r.report.sweeps)[-1]
    assert last.dihedral_min == pytest.approx(tetune.quality(r.mesh).dihedral_min, abs=1e-6)
    plain = tetune.optimize(points, tets)
    assert plain.report.sweeps[0].dihedral_min == 0 and np.array_equal(plain.mesh.points, r.mesh.points)


def test_only_below():
    points, tets = shaken_box()
    angles = smallest_dihedral(points, tets)
    limit = float(np.sort(angles)[2:4].mean())
    r = tetune.optimize(points, tets, only_below={"min_dihedral_deg": limit}, rings=0)
    assert r.report.tets_bad == 3 and r.report.tets_active == 3
    rest = angles >= limit
    assert np.array_equal(r.mesh.points[tets[rest]], points[tets[rest]])
    same = tetune.optimize(points, tets, only_below={"min_dihedral_deg": 0.99 * float(angles.min())})
    assert same.report.tets_active == 0 and np.array_equal(same.mesh.tets, tets)


def test_targets():
    points, tets = shaken_box()
    r = tetune.optimize(points, tets, targets={"min_dihedral_deg": 65, "mean_ratio": 1e-3})
    angle, ratio = r.report.targets
    assert not angle.met and angle.measure == "min_dihedral_deg" and angle.value == 65
    assert angle.missed == (smallest_dihedral(r.mesh.points, r.mesh.tets) < 65).sum()
    assert sum(angle.held_by.values()) == angle.missed
    assert angle.worst[0].value == pytest.approx(smallest_dihedral(r.mesh.points, r.mesh.tets).min())
    assert ratio.met


def test_options_without_effect_and_former_names_are_warnings():
    points, tets = shaken_box(2, 2, 2)
    with pytest.warns(UserWarning, match="max_deviation=1 has no effect without boundary=slide"):
        report = tetune.optimize(points, tets, max_deviation=1).report
    assert report.warnings == ["max_deviation=1 has no effect without boundary=slide"]
    with pytest.warns(DeprecationWarning, match="'automatic' is the former name of 'auto'"):
        tetune.optimize(points, tets, device="automatic")
    assert report.sweeps[0].gradient_norm == report.sweeps[0].gradient_norm2


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        ({"max_ring": 9}, tetune.OptionError, "max_ring=9 is out of range: it must be 3 to 7"),
        ({"max_iterations": -1}, tetune.OptionError, "max_iterations=-1 is out of range: it must be 0 or more"),
        ({"max_iterations": 1.5}, tetune.OptionError, "max_iterations is 1.5; it must be an integer"),
        ({"threads": -2}, tetune.OptionError, "threads=-2 is out of range: it must be 0 to 4096"),
        ({"boundary": "Slide"}, tetune.OptionError, "boundary is 'Slide'; it must be one of 'fixed'|boundary is 'Slide'"),
        ({"effort": 3}, tetune.OptionError, "effort is 3; it must be one of 'fast', 'standard', 'best'"),
        ({"frozen_vertices": [1, 0]}, tetune.OptionError, "frozen_vertices has 2 entries"),
        ({"targets": {"minSICN": 1}}, tetune.OptionError, "there is no measure 'minSICN'; the measures are min_dih"),
        ({"targets": 15}, tetune.OptionError, "targets is 15; it must be a dict"),
        ({"device": "cuda"}, tetune.DeviceError, "CUDA"),
        ({"iterations": 3}, TypeError, "optimize() has no option 'iterations'; the options are boundary, feature_angle"),
    ],
)
def test_bad_options(options, kind, message):
    points, tets = shaken_box(2, 2, 2)
    with pytest.raises(kind) as error:
        tetune.optimize(points, tets, **options)
    assert message.split("|")[-1] in str(error.value)


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        (lambda p, t: (p, t[:, :3]), ValueError, "tets has the shape (40, 3); it must be (n, 4)"),
        (lambda p, t: (p[:, :2], t), ValueError, "points has the shape (27, 2); it must be (n, 3)"),
        (lambda p, t: (p, t.astype(float)), TypeError, "tets must be an array of integers"),
        (lambda p, t: (p.astype(str), t), TypeError, "points must be an array of numbers; its type is <U"),
        (lambda p, t: (p, t + 2**33), tetune.MeshError, "tets has 85899345"),
        (lambda p, t: (p, t + 1), tetune.MeshError, "out of range"),
        (lambda p, t: (np.where(p == 1, np.nan, p), t), tetune.MeshError, "finite"),
        (lambda p, t: (np.where(np.arange(27)[:, None] == 13, 3.0, p), t), tetune.MeshError, "inverted"),
    ],
)
def test_bad_meshes(change, kind, message):
    points, tets = shaken_box(2, 2, 2)
    with pytest.raises(kind) as error:
        tetune.optimize(*change(points, tets))
    assert message in str(error.value)


def test_errors_share_a_base():
    for kind in (tetune.MeshError, tetune.OptionError, tetune.FileError, tetune.DeviceError):
        assert issubclass(kind, tetune.Error)
    with pytest.raises(tetune.FileError, match="no-such-file"):
        tetune.read_mesh("no-such-file.mesh")


def test_progress_is_reported_and_cancels():
    points, tets = shaken_box()
    events = []
    whole = tetune.optimize(points, tets, progress=lambda p: events.append((p.phase, p.iteration, p.energy)))
    assert {phase for phase, _, _ in events} >= {"flips", "sweep"}
    assert events[-1][2] == pytest.approx(whole.report.energy_after)

    calls = []
    r = tetune.optimize(points, tets, progress=lambda p: calls.append(p) is not None or len(calls) < 3)
    assert len(calls) == 3 and r.report.stop == "cancelled"
    assert tetune.validate(r.mesh) == ""
    assert whole.report.energy_after < r.report.energy_after < r.report.energy_before


def test_what_the_callback_raises_comes_through():
    points, tets = shaken_box(2, 2, 2)

    def fail(_):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        tetune.optimize(points, tets, progress=fail)


def test_interrupt_without_callback():
    points, tets = shaken_box(28, 28, 28)
    mesh = tetune.TetMesh(points, tets)
    timer = threading.Timer(0.15, lambda: os.kill(os.getpid(), signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        timer.start()
        for _ in range(100):
            tetune.optimize(mesh, effort="best")
    timer.join()
    assert np.array_equal(mesh.points, points) and np.array_equal(mesh.tets, tets)


def test_other_threads_run_meanwhile():
    points, tets = shaken_box(20, 20, 20)
    ticks, done = [], threading.Event()

    def tick():
        while not done.wait(0.002):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    before = len(ticks)
    tetune.optimize(points, tets)
    during = len(ticks) - before
    done.set()
    thread.join()
    assert during > 5  # hundreds where nobody disturbs, one or two where the lock is held


def test_arrays_outlive_the_mesh():
    points, tets = shaken_box()
    r = tetune.optimize(points, tets)
    p, t, parent = r.mesh.points, r.mesh.tets, r.parent
    expected = p.copy(), t.copy(), parent.copy()
    del r
    gc.collect()
    trash = [tetune.TetMesh(points, tets) for _ in range(20)]
    assert all(np.array_equal(a, b) for a, b in zip((p, t, parent), expected))
    assert len(trash) == 20


def test_arrays_share_the_mesh_memory():
    points, tets = shaken_box(2, 2, 2)
    mesh = tetune.TetMesh(points, tets)
    assert not np.shares_memory(mesh.points, points) and np.shares_memory(mesh.points, mesh.points)
    mesh.points[0] = [-0.5, 0, 0]
    assert mesh.points[0, 0] == -0.5 and mesh.copy().points[0, 0] == -0.5 and points[0, 0] == 0


def test_quality():
    points, tets = shaken_box()
    q = tetune.quality(points, tets, worst=3)
    angles = smallest_dihedral(points, tets)
    assert q.dihedral_min == pytest.approx(angles.min())
    assert [w.tet for w in q.worst] == np.argsort(angles, kind="stable")[:3].tolist()
    assert q.volume == pytest.approx(128) and sum(q.histogram) == pytest.approx(1)
    each = tetune.measure_each(points, tets)
    assert np.allclose(each["min_dihedral_deg"], angles)
    assert set(each) == set(q.measures)
    assert each["mean_ratio"].mean() == pytest.approx(q.mean_ratio) == pytest.approx(q.measures["mean_ratio"].mean)


def test_compare():
    points, tets = shaken_box()
    r = tetune.optimize(points, tets)
    c = tetune.compare(tetune.TetMesh(points, tets), r.mesh)
    assert abs(c.volume_change) < 1e-12 and c.new_to_old < 1e-12 and c.tet_tags_kept


def test_files(tmp_path):
    points, tets = shaken_box()
    path = tmp_path / "box.meshb"
    tetune.write_mesh(str(path), tetune.TetMesh(points, tets))
    mesh = tetune.read_mesh(str(path))
    assert np.array_equal(mesh.points, points) and np.array_equal(mesh.tets, tets)


def test_paths_and_names_of_files(tmp_path):
    class Named:
        def __fspath__(self):
            return str(tmp_path / "b.mesh")

    mesh = tetune.TetMesh(*shaken_box(2, 2, 2))
    tetune.write_mesh(tmp_path / "a é.mesh", mesh)
    tetune.write_mesh(Named(), mesh)
    for name in (tmp_path / "a é.mesh", str(tmp_path / "a é.mesh"), Named()):
        assert np.array_equal(tetune.read_mesh(name).points, mesh.points)
    with pytest.raises(TypeError):
        tetune.read_mesh(3)
    (tmp_path / "limits.toml").write_text("[mean_ratio]\nfail = 0.9\n")
    assert everything_of(tetune.check(mesh, tmp_path / "limits.toml")) == everything_of(tetune.check(mesh, str(tmp_path / "limits.toml")))
    for function in (tetune.read_mesh, tetune.write_mesh, tetune.read_series, tetune.write_series, tetune.Geometry):
        assert "Raises FileError where " in " ".join(function.__doc__.split()), function


def test_booleans_of_numpy():
    points, tets = shaken_box()
    kept = tetune.optimize(points, tets, effort="best", keep_vertices=np.bool_(True))
    assert len(kept.vertex_map) == len(points) and (kept.vertex_map >= 0).all()
    assert np.array_equal(kept.mesh.points, tetune.optimize(points, tets, effort="best", keep_vertices=True).mesh.points)
    assert tetune.optimize(points, tets, flips=np.bool_(False)).report.flip_passes == []
    assert tetune.optimize(points, tets, flips=np.bool_(True)).report.flip_passes != []
    for value in (np.int64(1), "yes"):
        with pytest.raises(tetune.OptionError, match="it must be a bool"):
            tetune.optimize(points, tets, flips=value)


GROUPS_AND_MORE = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 7 "wall"
3 1 "steel"
3 2 "air"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 1 1 1
$EndNodes
$Elements
4
1 2 2 7 3 1 2 3
2 4 2 1 1 1 2 3 4
3 4 2 2 2 2 3 4 5
4 15 2 0 9 5
$EndElements
$Periodic
1
0 1 2
1
2 1
$EndPeriodic
$NodeData
1
"heat"
1
0.0
3
0
1
5
1 1.5
2 2.5
3 3.5
4 4.5
5 5.5
$EndNodeData
"""


def full_mesh(tmp_path):
    """A mesh with groups, data, tags, periodic links, and more."""
    (tmp_path / "in.msh").write_text(GROUPS_AND_MORE)
    return tetune.read_mesh(tmp_path / "in.msh")


def test_groups(tmp_path):
    groups = full_mesh(tmp_path).groups
    assert sorted(groups) == [("air", 3, [2]), ("steel", 3, [1]), ("wall", 2, [7])]
    assert tetune.TetMesh(*shaken_box(2, 2, 2)).groups == []


def everything_of(value):
    """All that Python shows of an object of the module, as plain values."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tolist()
    if isinstance(value, (list, tuple)):
        return [everything_of(v) for v in value]
    if not type(value).__module__.startswith("tetune"):
        return value
    names = [n for n in dir(value) if not n.startswith("_") and not callable(getattr(value, n))]
    assert len(names) > 1
    return {n: everything_of(getattr(value, n)) for n in names}


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))])
def test_copies_of_meshes(tmp_path, copied):
    mesh = full_mesh(tmp_path)
    assert len(mesh.periodic) == 1 and len(mesh.others) == 1 and len(mesh.groups) == 3
    points, tets = shaken_box(2, 2, 2)
    listed = tetune.TetMesh(
        points, tets, point_tags=np.arange(len(points)), tet_tags=np.arange(len(tets)), triangles=[tets[0][:3]], triangle_tags=[4],
        edges=[[0, 1], [1, 2]], edge_tags=[5, 6], corners=[0], required_vertices=[13], ridges=[1], required_edges=[0],
        required_triangles=[0], required_tets=[3, 4], curved_edges=[[0, 1]], curved_middles=[[0.5, 0.1, 0]])
    for m in (mesh, listed, tetune.TetMesh(points, tets[:, [0, 1, 3, 2]])):
        other = copied(m)
        assert everything_of(other) == everything_of(m) and not np.shares_memory(other.points, m.points)
        # All that a file can hold, as data: each text is the same to the byte.
        for name in ("a.msh", "a.mesh"):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                written = [(tetune.write_mesh(tmp_path / name, x), (tmp_path / name).read_bytes())[1] for x in (m, other)]
            assert written[0] == written[1] and len(written[0]) > 100
    assert b'"heat"' in (tetune.write_mesh(tmp_path / "b.msh", copied(mesh)), (tmp_path / "b.msh").read_bytes())[1]


@pytest.mark.filterwarnings("ignore:max_deviation")
def test_reports_and_results_are_pickled():
    points, tets = shaken_box()
    tags = (points[tets].mean(axis=1)[:, 0] > 4).astype(int)
    mesh = tetune.TetMesh(points, tets, tet_tags=tags)
    corner = np.flatnonzero((tets == 0).any(axis=1))[0]  # the middle of an edge folds a triangle of the bottom
    a, b, c = (v for v in tets[corner] if points[v, 2] == 0)
    folded = tetune.TetMesh(points, tets, curved_edges=[sorted([a, b])], curved_middles=[points[[a, b]].mean(axis=0) * 0.45 + points[c] * 0.55])
    inside = tets[volumes(points, tets).argmax()][:3]
    linked = tetune.TetMesh(points, tets, triangles=[inside, [0, 1, 10]], triangle_tags=[0, 7], edges=[[0, 1], [0, 100]],
                            edge_tags=[0, 0], corners=np.arange(len(points)))
    linked.link_box_faces("x")
    results = [
        tetune.optimize(mesh, effort="best", data="interpolate", targets={"min_dihedral_deg": 60}, trace_angles=True),
        tetune.optimize(mesh, only_below={"min_dihedral_deg": 20}, boundary="slide", max_deviation=0.1),
        tetune.optimize(folded, untangle=True, straighten=True),
        tetune.optimize(mesh, only_below={"min_dihedral_deg": 1}, data="conserve"),
        tetune.optimize(linked, max_deviation=1, device="auto"),
        tetune.move(points, tets, points * [-1, 1, 1] + [8, 0, 0]),
    ]
    for r in results:
        back = pickle.loads(pickle.dumps(r))
        assert type(back) is type(r)
        assert everything_of(back.report) == everything_of(r.report) and everything_of(back.mesh) == everything_of(r.mesh)
        assert np.array_equal(back.moved, r.moved) and np.array_equal(back.parent, r.parent)
    report = results[0].report
    assert len(report.targets[0].worst) > 1 and len(report.place_vertices) > 0 and len(report.worst_rounds) > 0 < len(report.flip_passes)
    listed = results[4].report
    assert listed.periodic_vertices > 0 < listed.triangles_dropped == listed.edges_dropped and listed.warnings and listed.device_reason
    motion = results[5].motion
    assert len(results[2].report.straightened) > 0 and len(motion.blocking_tets) > 0
    assert everything_of(pickle.loads(pickle.dumps(motion))) == everything_of(motion)


def test_what_is_not_pickled(tmp_path):
    (tmp_path / "in.inp").write_text("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n** end\n")
    deck = tetune.read_mesh(tmp_path / "in.inp")
    with pytest.raises(TypeError, match="the text of a deck"):
        pickle.dumps(deck)
    tetune.write_mesh(tmp_path / "out.inp", copy.deepcopy(deck))
    assert (tmp_path / "out.inp").read_text().endswith("** end\n")
    mesh = tetune.TetMesh(*shaken_box(2, 2, 2))
    state = mesh.__getstate__()
    for wrong, said in ((state[:-10], "ends early"), (b"", "ends early"), (state.replace(b"tetune ", b"tetunf "), "not one of tetune")):
        with pytest.raises(ValueError, match=said):
            tetune.TetMesh.__new__(tetune.TetMesh).__setstate__(wrong)


def test_command_line(tmp_path):
    points, tets = shaken_box()
    tetune.write_mesh(str(tmp_path / "in.mesh"), tetune.TetMesh(points, tets))
    run = subprocess.run(
        [sys.executable, "-m", "tetune", "optimize", tmp_path / "in.mesh", "-o", tmp_path / "out.mesh"],
        capture_output=True, text=True, timeout=100,
    )
    assert run.returncode == 0, run.stderr
    out = tetune.read_mesh(str(tmp_path / "out.mesh"))
    r = tetune.optimize(points, tets)
    assert np.array_equal(out.points, r.mesh.points) and np.array_equal(out.tets, r.mesh.tets)


@pytest.mark.skipif(not (Path(tetune.__file__).parent / "lib" / "glibc-hwcaps").exists(), reason="built as one library")
def test_the_processor_decides_which_library_runs(tmp_path):
    points, tets = shaken_box()
    tetune.write_mesh(str(tmp_path / "in.mesh"), tetune.TetMesh(points, tets))

    def run(without=""):
        report = tmp_path / "report.json"
        subprocess.run(
            [sys.executable, "-m", "tetune", "optimize", "in.mesh", "-o", "out.meshb", "--report", report],
            env={**os.environ, "GLIBC_TUNABLES": f"glibc.cpu.hwcaps={without}"}, cwd=tmp_path, check=True, timeout=100,
        )
        return json.loads(report.read_text())["instructions"], (tmp_path / "out.meshb").read_bytes()

    flags = set(re.search(r"^flags\s*:(.*)$", Path("/proc/cpuinfo").read_text(), re.M)[1].split())
    level, result = run()
    if not {"avx2", "bmi2", "fma", "movbe"} <= flags or tuple(map(int, platform.libc_ver()[1].split("."))) < (2, 33):
        assert level == "x86-64"
        return
    has_v4 = (Path(tetune.__file__).parent / "lib" / "glibc-hwcaps" / "x86-64-v4").exists()
    runs_v4 = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"} <= flags
    assert level == ("x86-64-v4" if has_v4 and runs_v4 else "x86-64-v3")
    assert run("-AVX512F") == ("x86-64-v3", result)
    assert run("-AVX2") == ("x86-64", result)


def test_numpy_alone_is_enough():
    code = """
import sys
for name in ("meshio", "pyvista", "vtk", "rich", "plotly"):
    sys.modules[name] = None
sys.path.insert(0, sys.argv[1])
from meshes import shaken_box
import tetune
assert tetune.optimize(*shaken_box(2, 2, 2)).report.tets_after > 0
try:
    tetune.optimize(*shaken_box(2, 2, 2), progress=True)
except ImportError as error:
    assert "pip install rich" in str(error)
else:
    raise AssertionError("no error")
"""
    run = subprocess.run([sys.executable, "-c", code, os.path.dirname(__file__)], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


def test_progress_bar():
    pytest.importorskip("rich")
    points, tets = shaken_box()
    code = "import tetune; from meshes import shaken_box; tetune.optimize(*shaken_box(12, 12, 12), progress=True)"
    run = subprocess.run(
        ["script", "-qec", f'"{sys.executable}" -c "{code}"', "/dev/null"],
        capture_output=True, text=True, cwd=os.path.dirname(__file__), env={**os.environ, "TERM": "xterm"},
    )
    assert run.returncode == 0 and re.search(r"\d+ %  \w+, sweep \d+, \d+\.\d degrees, \d+ s left", run.stdout), run.stdout
    quiet = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=os.path.dirname(__file__))
    assert quiet.returncode == 0 and quiet.stdout == quiet.stderr == ""
