# SPDX-License-Identifier: Apache-2.0
"""move(): for arrays and for the meshes of other packages."""

from pathlib import Path

import numpy as np
import pytest

import tetune
from meshes import inverted_pyramid, shaken_box, volumes
from tetune._point_data import interpolated


def sides(points):
    """Flags of the vertices of shaken_box() on the sides x = 0 and x = 8."""
    return points[:, 0] == 0, points[:, 0] == 8


def compressed(points):
    """A target: the side x = 8 moves to x = 5, and x = 0 stays."""
    targets = np.full_like(points, np.nan)
    left, right = sides(points)
    targets[left | right] = points[left | right]
    targets[right, 0] = 5
    return targets


def test_arrays():
    points, tets = shaken_box()
    targets = compressed(points)
    r = tetune.move(points, tets, targets)
    assert r.motion.reached and r.motion.fraction == 1 and r.motion.targets_reached == 1
    prescribed = ~np.isnan(targets[:, 0])
    assert r.motion.prescribed == prescribed.sum()
    assert (r.mesh.points[prescribed] == targets[prescribed]).all()
    assert volumes(r.mesh.points, r.mesh.tets).min() > 0
    assert volumes(r.mesh.points, r.mesh.tets).sum() == pytest.approx(5 * 4 * 4)
    assert r.motion.steps[-1].fraction == 1 and r.motion.steps[-1].dihedral_min > 5
    assert r.moved[sides(points)[1]].all() and not r.moved[sides(points)[0]].any()
    assert tetune.validate(r.mesh) == ""
    assert "1 of 1 targets" in repr(r.motion)


def test_several_targets_and_the_surface_alone():
    points, tets = shaken_box()
    turned = []
    for angle in np.radians([10, 20, 30]):
        c, s = np.cos(angle), np.sin(angle)
        turned.append(points @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T)
    r = tetune.move(points, tets, turned, surface=True, threads=2)
    assert r.motion.targets == 3 and r.motion.reached
    inner = np.all((points > 0) & (points < [8, 4, 4]), axis=1)
    assert r.motion.prescribed == (~inner).sum()
    assert (r.mesh.points[~inner] == turned[-1][~inner]).all()
    assert volumes(r.mesh.points, r.mesh.tets).sum() == pytest.approx(128)
    same = tetune.move(tetune.TetMesh(points, tets), to=turned, surface=True, threads=1)
    assert (same.mesh.points == r.mesh.points).all() and (same.mesh.tets == r.mesh.tets).all()


def test_a_target_out_of_reach():
    points, tets = shaken_box(3, 3, 3)
    r = tetune.move(points, tets, points * [-1, 1, 1] + [3, 0, 0])
    assert not r.motion.reached and 0.4 < r.motion.fraction < 0.5
    assert volumes(r.mesh.points, r.mesh.tets).min() > 0
    assert len(r.motion.blocking_tets) > 0 and len(r.motion.blocking_vertices) > 0
    assert r.motion.blocking_tets.max() < len(r.mesh.tets)


def test_inverted_elements_and_frozen_vertices_that_move():
    mesh, to = inverted_pyramid()
    motion = tetune.move(mesh, to=to).motion
    inverted, = motion.inverted_others
    assert isinstance(inverted, tetune.InvertedOthers)
    assert (inverted.kind, inverted.block, inverted.elements.tolist()) == ("Pyramids", 1, [1])
    assert motion.frozen_moved == 0
    motion = tetune.move(mesh, to=to, frozen_vertices=np.arange(len(to)) == len(to) - 1).motion
    assert motion.frozen_moved == 1


def test_patches():
    points, tets = shaken_box(3, 3, 3)
    face = next(t for t in tets if (points[t][:, 2] == 3).sum() == 3)
    triangle = np.array([[v for v in face if points[v, 2] == 3]])
    mesh = tetune.TetMesh(points, tets, triangles=triangle, triangle_tags=[5])
    r = tetune.move(mesh, to=points + [0, 0, 0.1], patches=[5])
    assert r.motion.prescribed == 3 and r.motion.reached
    assert (r.mesh.points[triangle[0]] == (points + [0, 0, 0.1])[triangle[0]]).all()
    with pytest.raises(tetune.OptionError, match="no triangle has the tag 6"):
        tetune.move(mesh, to=points, patches=[6])


def test_meshio():
    meshio = pytest.importorskip("meshio")
    points, tets = shaken_box()
    d = compressed(points) - points
    mesh = meshio.Mesh(points, [("tetra", tets)], point_data={"u": d, "id": np.arange(len(points))})
    r = tetune.move(mesh, to="u")
    assert isinstance(r.mesh, meshio.Mesh) and r.motion.reached
    right = sides(points)[1]
    assert (r.mesh.points[right, 0] == 5).all()
    assert (r.mesh.point_data["id"] == np.arange(len(points))).all()
    with pytest.raises(tetune.OptionError, match="the point data of this mesh are: u, id"):
        tetune.move(mesh, to="v")
    with pytest.raises(tetune.OptionError, match="three numbers per vertex"):
        tetune.move(mesh, to="id")


def test_pyvista():
    pv = pytest.importorskip("pyvista")
    points, tets = shaken_box()
    grid = pv.UnstructuredGrid({pv.CellType.TETRA: tets}, points)
    grid.point_data["u"] = compressed(points) - points
    r = grid.tetune.move("u")
    assert isinstance(r.mesh, pv.UnstructuredGrid) and r.motion.reached
    assert (r.mesh.points[sides(points)[1], 0] == 5).all()


def test_data_are_interpolated_at_the_new_places():
    meshio = pytest.importorskip("meshio")
    points, tets = shaken_box()
    linear = points @ [1, 2, 3] + 4
    fields = {"a": linear, "v": np.stack([linear, -linear], axis=1).astype(np.float32), "id": np.arange(len(points))}
    mesh = meshio.Mesh(points, [("tetra", tets)], point_data=fields)
    for effort in ("standard", "best"):
        r = tetune.optimize(mesh, data="interpolate", effort=effort)
        new = r.mesh
        assert r.moved.any()
        assert np.abs(new.point_data["a"] - (new.points @ [1, 2, 3] + 4)).max() < 1e-12
        assert new.point_data["v"].dtype == np.float32
        assert np.abs(new.point_data["v"][:, 1] + new.point_data["a"]).max() < 1e-4
        assert r.report.place_vertices.shape == (len(new.points), 4)
        assert np.abs(r.report.place_weights.sum(axis=1) - 1).max() < 1e-14
        nearest = r.report.place_vertices[np.arange(len(new.points)), r.report.place_weights.argmax(axis=1)]
        assert (new.point_data["id"] == nearest).all()
    # Without the option, values stay with their vertex.
    with pytest.warns(UserWarning, match="the values of a, v moved with their vertices"):
        carried = tetune.optimize(mesh)
    assert (carried.mesh.point_data["a"] == linear).all() and len(carried.report.place_weights) == 0


def test_interpolated_values_stay_within_those_of_the_corners():
    """Weights add up to 1 to rounding alone."""
    weights = np.array([[0.7, 0.3, 1e-9, 0], [0.25, 0.25, 0.25, 0.25]])
    places = np.array([[0, 1, 2, 3], [0, 1, 2, 3]])
    assert (interpolated(np.full(4, 0.1), places, weights) == 0.1).all()
    # A corner of no weight does not count.
    assert (interpolated(np.array([0.1, 0.1, 0.1, 5.0]), places[:1], weights[:1]) == 0.1).all()


def test_fields_move_with_the_mesh():
    meshio = pytest.importorskip("meshio")
    points, tets = shaken_box()
    mesh = meshio.Mesh(points, [("tetra", tets)], point_data={"x": points[:, 0], "u": [3.0, 0, 0] + 0 * points})
    r = tetune.move(mesh, to="u", surface=True, data="interpolate")
    assert r.motion.reached
    assert np.abs(r.mesh.point_data["x"] - (r.mesh.points[:, 0] - 3)).max() < 1e-3


def integral(points, tets, values):
    return (volumes(points, tets) * (values[tets].mean(axis=1) if len(values) == len(points) else values)).sum()


def fields_for(points, tets):
    center = points[tets].mean(axis=1)
    return (
        {"a": points @ [1, 2, 3] + 4, "v": np.stack([points[:, 0], np.sign(points[:, 1] - 2)], axis=1),
         "id": np.arange(len(points))},
        {"c": np.where(center[:, 0] < 4, -1.0, 1.0), "number": np.arange(len(tets))},
    )


def check_conserved(old, new_tets, r, point_data, tet_data, cell_data):
    old_points, old_tets = old
    new_points = r.mesh.points
    assert np.abs(point_data["a"] - (new_points @ [1, 2, 3] + 4)).max() < 1e-11
    assert integral(new_points, new_tets, point_data["v"][:, 1]) == pytest.approx(
        integral(old_points, old_tets, np.sign(old_points[:, 1] - 2)), abs=1e-10)
    assert integral(new_points, new_tets, tet_data["c"]) == pytest.approx(
        integral(old_points, old_tets, cell_data["c"]), abs=1e-10)
    assert np.abs(tet_data["c"]).max() == 1 and np.abs(point_data["v"][:, 1]).max() <= 1
    assert tet_data["number"].dtype == np.arange(1).dtype
    assert r.report.uncovered < 1e-12


def test_conserved_data_of_meshio():
    meshio = pytest.importorskip("meshio")
    points, tets = shaken_box()
    of_points, of_tets = fields_for(points, tets)
    half = len(tets) // 2
    mesh = meshio.Mesh(points, [("tetra", tets[:half]), ("tetra", tets[half:])], point_data=of_points,
                       cell_data={name: [v[:half], v[half:]] for name, v in of_tets.items()})
    r = tetune.optimize(mesh, data="conserve", effort="best")
    new = np.concatenate([b.data for b in r.mesh.cells])
    check_conserved((points, tets), new, r, r.mesh.point_data,
                    {name: np.concatenate(v) for name, v in r.mesh.cell_data.items()}, of_tets)


def test_conserved_data_of_pyvista():
    pv = pytest.importorskip("pyvista")
    points, tets = shaken_box()
    of_points, of_tets = fields_for(points, tets)
    grid = pv.UnstructuredGrid({pv.CellType.TETRA: tets}, points)
    for name, values in of_points.items():
        grid.point_data[name] = values
    for name, values in of_tets.items():
        grid.cell_data[name] = values
    r = tetune.optimize(grid, data="conserve")
    check_conserved((points, tets), r.mesh.cells_dict[pv.CellType.TETRA], r, r.mesh.point_data, r.mesh.cell_data, of_tets)


def test_interpolation_of_special_values():
    from tetune._point_data import interpolated

    values = np.array([1.0, 2.0, np.nan, 4.0])
    places = np.array([[0, 1, 3, 2], [0, 1, 2, 3], [2, 0, 1, 3]])
    weights = np.array([[0.5, 0.25, 0.25, 0], [0.5, 0.25, 0.25, 0], [0.4, 0.2, 0.2, 0.2]])
    result = interpolated(values, places, weights)
    assert result[0] == 2 and result[1] == 1 and np.isnan(result[2])


def test_progress_stops():
    points, tets = shaken_box()
    seen = []

    def stop(p):
        seen.append(p.fraction)
        return len(seen) < 4

    r = tetune.move(points, tets, compressed(points), progress=stop)
    assert r.report.stop == "cancelled" and len(seen) == 4
    assert volumes(r.mesh.points, r.mesh.tets).min() > 0


@pytest.mark.parametrize(
    ("targets", "options", "error", "said"),
    [
        (None, {}, TypeError, "needs targets"),
        ("u", {}, TypeError, "a meshio or pyvista mesh"),
        (np.zeros((3, 3)), {}, tetune.OptionError, "target 1 has 3 positions"),
        (np.zeros((3, 2)), {}, ValueError, "targets has the shape"),
        ("points", {"boundary": "slide", "max_deviation": 0.1}, tetune.OptionError, "max_deviation"),
        ("nan", {}, tetune.OptionError, "nothing to move"),
        ([], {}, tetune.OptionError, "to is an empty list; it must be an array of positions"),
        ((), {}, tetune.OptionError, "to is an empty list; it must be an array of positions"),
    ],
)
def test_refusals(targets, options, error, said):
    points, tets = shaken_box(2, 2, 2)
    if isinstance(targets, str) and targets != "u":
        targets = points if targets == "points" else np.full_like(points, np.nan)
    with pytest.raises(error, match=said):
        tetune.move(points, tets, targets, **options)


def test_series(tmp_path):
    steps = [(0.0, str(tmp_path / "a.vtu")), (0.5, str(tmp_path / "b & c.vtu"))]
    path = str(tmp_path / "s.pvd")
    tetune.write_series(path, steps)
    assert tetune.read_series(path) == steps
    with pytest.raises(tetune.FileError, match="s.pvd: the series lists no file"):
        tetune.write_series(path, [])
    assert tetune.read_series(path) == steps
    (tmp_path / "none.pvd").write_text('<VTKFile type="Collection"><Collection></Collection></VTKFile>')
    with pytest.raises(tetune.FileError, match="the collection lists no file"):
        tetune.read_series(tmp_path / "none.pvd")
    # Paths in the place of names.
    tetune.write_series(tmp_path / "s.pvd", [(time, Path(name)) for time, name in steps])
    assert tetune.read_series(tmp_path / "s.pvd") == steps
    with pytest.raises(tetune.FileError, match=r"times\.e: this is not a \.pvd file"):
        tetune.read_series(tmp_path / "times.e")


def test_slides_on_the_input_surface():
    """A piston in a cylinder: the wall is on the input's, 1 - cos(pi / 16) off the circle at most."""
    points, tets = shaken_box(4, 4, 4, amount=0)
    y, z = 2 * points[:, 1] / points[:, 1].max() - 1, 2 * points[:, 2] / points[:, 2].max() - 1
    x = points[:, 0] / points[:, 0].max()
    points = np.stack([x, y * np.sqrt(1 - z**2 / 2), z * np.sqrt(1 - y**2 / 2)], 1)
    wall = np.hypot(points[:, 1], points[:, 2]) > 0.99
    to = np.full_like(points, np.nan)
    to[x == 0] = points[x == 0]
    to[x == 1] = points[x == 1] * [0.5, 1, 1]
    r = tetune.move(points, tets, to, boundary="slide")
    assert r.motion.reached
    assert np.hypot(r.mesh.points[wall, 1], r.mesh.points[wall, 2]).min() > 0.95
    assert (r.mesh.points[x == 1] == to[x == 1]).all()
