# SPDX-License-Identifier: Apache-2.0
"""Required entities of meshio and pyvista meshes."""

from pathlib import Path

import numpy as np
import pytest

import tetune
from meshes import two_regions
from tetune._adapters import adapter_of

meshio = pytest.importorskip("meshio")
pv = pytest.importorskip("pyvista")


def mesh_with_required(order=1):
    """Flags of each kind, on a mesh of which the rest moves."""
    points, tets, _ = two_regions()
    inner = np.flatnonzero(((points > 0) & (points < [8, 4, 4])).all(axis=1))
    triangles, lines = np.array([[0, 1, 10], [0, 1, 9]]), np.array([[0, 1], [1, 2], [2, 3]])
    cells = [("line", lines), ("tetra", tets[:100]), ("triangle", triangles), ("tetra", tets[100:])]
    sizes = [len(c) for _, c in cells]
    one = lambda block, *rows: [np.isin(np.arange(n), rows).astype(np.uint8) if i == block else np.zeros(n, np.uint8)
                                for i, n in enumerate(sizes)]
    flags = {"mmg_required_edges": one(0, 1), "mmg_ridge_edges": one(0, 0, 2), "mmg_required_triangles": one(2, 1)}
    flags["mmg_required_tetrahedra"] = one(3, 7, 250)
    of_points = {"mmg_required_vertices": np.isin(np.arange(len(points)), inner[::3]).astype(np.uint8),
                 "mmg_corners": np.isin(np.arange(len(points)), [1]).astype(float)}
    mesh = meshio.Mesh(points, cells, point_data=of_points, cell_data=flags)
    return mesh if order == 1 else tetune.curve(mesh).mesh


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("package", ["meshio", "pyvista"])
def test_required_entities(package, order, tmp_path):
    mesh = mesh_with_required(order)
    vertices = np.flatnonzero(np.isin(np.arange(len(mesh.points)), np.concatenate([b.data[:, : {"line": 2, "tria": 3, "tetr": 4}[b.type[:4]]].ravel() for b in mesh.cells])))
    required = np.flatnonzero(mesh.point_data["mmg_required_vertices"])
    assert len(required) > 10 and np.isin(required, vertices).all()  # mid-side nodes are not required
    given = mesh if package == "meshio" else pv.from_meshio(mesh)
    held = adapter_of(given, None).tet_mesh()
    tetra = np.concatenate([b.data for b in mesh.cells if b.type.startswith("tetra")])
    assert np.array_equal(held.points[held.required_vertices], mesh.points[required])
    assert np.array_equal(held.corners, [1])
    assert np.array_equal(held.required_edges, [1]) and np.array_equal(held.ridges, [0, 2])
    assert np.array_equal(held.required_triangles, [1]) and np.array_equal(held.required_tets, [107, 350])
    r = tetune.optimize(given, effort="best")
    assert r.moved.any() and not r.moved[np.isin(r.vertex_map, required)].any() and np.isin(required, r.vertex_map).all()
    cells = r.mesh.get_cells_type("tetra10" if order == 2 else "tetra") if package == "meshio" else r.mesh.cells_dict[24 if order == 2 else 10]
    after = {tuple(sorted(t)) for t in r.vertex_map[cells[:, :4]].tolist()}
    assert {tuple(sorted(t)) for t in tetra[[107, 350], :4].tolist()} <= after
    assert (r.vertex_map < 0).any(), "the test needs an inserted node"
    flags = np.asarray(r.mesh.point_data["mmg_required_vertices"])
    assert np.array_equal(np.sort(r.vertex_map[flags != 0]), required) and flags.dtype == np.asarray(given.point_data["mmg_required_vertices"]).dtype
    # The file of the same mesh has the same effect.
    if (Path(tetune.__file__).parent / "libexec/tetune/tetune-vtk").is_file():
        mesh.write(tmp_path / "in.vtu")
        file = tetune.read_mesh(tmp_path / "in.vtu")
        for name in ("points", "corners", "required_vertices", "ridges", "required_edges", "required_triangles", "required_tets"):
            assert np.array_equal(getattr(file, name), getattr(held, name)), name


@pytest.mark.parametrize("data", ["carry", "interpolate", "conserve"])
def test_inserted_vertices_are_not_required(data):
    mesh = mesh_with_required()
    mesh.point_data["mmg_corners"][0] = 1
    r = tetune.optimize(mesh, effort="best", data=data)
    assert (r.vertex_map < 0).any(), "the test needs an inserted vertex"
    for name, values in mesh.point_data.items():
        assert np.array_equal(np.sort(r.vertex_map[r.mesh.point_data[name] != 0]), np.flatnonzero(values)), name
