# SPDX-License-Identifier: Apache-2.0
import gc

import numpy as np
import pytest

import tetune
from meshes import everything_of, shaken_box, smallest_dihedral, volumes


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


def test_elements_without_vertices_are_refused():
    points, tets = shaken_box(2, 2, 2)
    for shape in ((0, 0), (3, 0)):
        with pytest.raises(ValueError, match="Pyramids must have the shape .*, with at least one vertex"):
            tetune.TetMesh(points, tets, others=[("Pyramids", np.zeros(shape, int))])
    (kind, none), = tetune.TetMesh(points, tets, others=[("Pyramids", np.zeros((0, 5), int))]).others
    assert kind == "Pyramids" and none.shape == (0, 5)


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
