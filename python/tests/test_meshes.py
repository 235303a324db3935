# SPDX-License-Identifier: Apache-2.0
"""meshio.Mesh and pyvista.UnstructuredGrid, with all their data."""

from itertools import combinations

import numpy as np
import pytest

import tetune
from meshes import BRACKET, interface_area, shaken_box, two_regions, volumes

meshio = pytest.importorskip("meshio")
pv = pytest.importorskip("pyvista")


def meshio_mesh(tag="medit:ref"):
    """Two blocks of tetrahedra, triangles inside and on the boundary, lines, vertices, all with data."""
    points, tets, region = two_regions()
    first, second = tets[region == 1], tets[region == 2]
    triangles = np.array([tets[50][:3], [0, 1, 10], [1, 2, 10]])
    cells = [("tetra", first), ("triangle", triangles), ("tetra", second), ("line", [[0, 1], [1, 2]]), ("vertex", [[0]])]
    sizes = [len(c) for _, c in cells]
    tags = [np.full(sizes[0], 1), np.array([0, 9, 9]), np.full(sizes[2], 2), np.array([4, 4]), np.array([3])]
    return meshio.Mesh(
        points, cells,
        point_data={"id": np.arange(len(points)), "field": points * 2},
        cell_data={tag: tags, "row": [np.arange(n) for n in sizes]},
        field_data={"steel": np.array([1, 3])},
        point_sets={"clamped": np.array([0, 5, 7])}, info={"made by": "us"},
        cell_sets={"left": [np.arange(sizes[0]), None, np.array([], int), None, None],
                   "bottom": [None, np.array([2]), None, None, None], "gmsh:bounding_entities": [np.array([-1])] * 5},
    )


def test_blocks_that_lose_all_their_cells():
    points, tets = shaken_box(8, 6, 6)
    edges = lambda of: set(map(tuple, np.sort(np.concatenate([of[:, [i, j]] for j in range(4) for i in range(j)]), axis=1)))
    gone = sorted(edges(tets) - edges(tetune.optimize(tetune.TetMesh(points, tets)).mesh.tets))
    cells = [("line", np.array(gone[:2])), ("tetra", tets), ("line", np.array(gone[2:]))]
    rank = [np.arange(len(block)) for _, block in cells]
    r = tetune.optimize(meshio.Mesh(points, cells, cell_data={"rank": rank}))
    assert r.report.edges_dropped == len(gone) > 2
    assert [len(block.data) for block in r.mesh.cells] == [0, len(r.report.tet2original), 0]
    assert [len(values) for values in r.mesh.cell_data["rank"]] == [0, len(r.report.tet2original), 0]


@pytest.mark.parametrize("effort", ["standard", "best"])
def test_meshio(effort):
    m = meshio_mesh()
    r = tetune.optimize(m, effort=effort)
    out = r.mesh
    assert isinstance(out, meshio.Mesh)
    assert [b.type for b in out.cells] == ["tetra", "triangle", "tetra", "line", "vertex"]
    assert r.report.triangles_dropped == 1 and np.array_equal(r.vertex_map[out.cells[1].data], m.cells[1].data[1:])
    assert np.array_equal(out.cell_data["row"][1], [1, 2]) and np.array_equal(out.cell_data["medit:ref"][1], [9, 9])
    kept = r.vertex_map >= 0
    assert np.array_equal(out.point_data["id"][kept], r.vertex_map[kept])
    assert np.array_equal(out.point_data["field"][kept], 2 * m.points[r.vertex_map[kept]])
    assert out.point_data["id"].min() >= 0
    for b, tag in ((0, 1), (2, 2)):
        assert (out.cell_data["medit:ref"][b] == tag).all()
        assert len(out.cell_data["row"][b]) == len(out.cells[b].data)
        assert (volumes(out.points, out.cells[b].data) > 0).all()
    all_tets = np.concatenate([out.cells[0].data, out.cells[2].data])
    assert volumes(out.points, all_tets).sum() == pytest.approx(128)
    regions = np.repeat([1, 2], [len(out.cells[0].data), len(out.cells[2].data)])
    assert interface_area(out.points, all_tets, regions) == pytest.approx(interface_area(*two_regions()), rel=1e-9)
    assert np.array_equal(out.cell_sets["left"][0], np.arange(len(out.cells[0].data)))
    assert out.cell_sets["left"][2].size == 0 and out.cell_sets["left"][1] is None
    assert np.array_equal(out.cell_sets["bottom"][1], [1])
    assert np.array_equal(r.vertex_map[out.point_sets["clamped"]], [0, 5, 7])
    assert out.cell_sets["gmsh:bounding_entities"] == m.cell_sets["gmsh:bounding_entities"]
    assert out.field_data.keys() == {"steel"} and out.info == {"made by": "us"}
    assert not r.moved[0]


def test_removed_vertices_are_in_no_set():
    b = tetune.read_mesh(str(BRACKET))
    every = np.arange(len(b.points))
    r = tetune.optimize(meshio.Mesh(b.points, [("tetra", b.tets)], point_sets={"all": every}), effort="best")
    kept = r.vertex_map[r.vertex_map >= 0]
    assert len(kept) < len(every), "the test needs a removed vertex"
    assert np.array_equal(np.sort(r.vertex_map[r.mesh.point_sets["all"]]), np.sort(kept))


def test_data_of_inserted_vertices():
    b = tetune.read_mesh(str(BRACKET))
    n = len(b.points)
    slopes = np.array([[1.0, -2, 3], [0.5, 0, -1]])
    data = {
        "id": np.arange(n), "linear": b.points @ slopes.T + 7, "single": b.points[:, 0].astype(np.float32),
        "even": np.arange(n) % 2 == 0, "tensor": np.multiply.outer(b.points[:, 2], np.eye(3)),
    }
    r = tetune.optimize(meshio.Mesh(b.points, [("tetra", b.tets)], point_data=data), effort="best")
    inserted = np.flatnonzero(r.vertex_map < 0)
    assert inserted.size > 0, "the test needs an inserted vertex"
    out, tets = r.mesh.point_data, r.mesh.cells[0].data
    assert {name: values.dtype for name, values in out.items()} == {name: values.dtype for name, values in data.items()}
    for name, values in data.items():
        assert np.array_equal(out[name][r.vertex_map >= 0], values[r.vertex_map[r.vertex_map >= 0]]), name
    assert np.array_equal(out["even"], out["id"] % 2 == 0)
    place = {v: i for i, v in enumerate(r.vertex_map) if v >= 0}
    moved_by = np.abs(r.mesh.points[r.vertex_map >= 0] - b.points[r.vertex_map[r.vertex_map >= 0]]).max()
    for v in inserted:
        around = np.setdiff1d(tets[(tets == v).any(axis=1)], v)
        old = around[r.vertex_map[around] >= 0]
        if old.size:
            length = {k: np.linalg.norm(r.mesh.points[k] - r.mesh.points[v]) for k in old}
            assert length[place[out["id"][v]]] == min(length.values())
        # A mean of the neighbors: between their values; linear fields of the old positions differ by the moves alone.
        for name in ("linear", "single", "tensor"):
            near = out[name][around]
            assert (out[name][v] >= near.min(axis=0) - 1e-5).all() and (out[name][v] <= near.max(axis=0) + 1e-5).all()
        assert np.abs(out["linear"][v] - slopes @ r.mesh.points[v] - 7).max() < 6 * moved_by
        assert not (out["linear"][v] == out["linear"][around]).all(axis=1).any()
    grid = pv.UnstructuredGrid({pv.CellType.TETRA: b.tets}, b.points)
    for name in ("id", "linear"):
        grid.point_data[name] = data[name]
    shown = grid.tetune.optimize(effort="best")
    for name in ("id", "linear"):
        assert np.array_equal(shown.point_data[name], out[name])


@pytest.mark.parametrize("kind", ["line", "triangle"])
@pytest.mark.parametrize("data", ["carry", "conserve"])
def test_all_lines_or_triangles_dropped(kind, data):
    points, tets = shaken_box()
    new = {tuple(sorted(t)) for t in tetune.optimize(points, tets).mesh.tets.tolist()}
    width = {"line": 2, "triangle": 3}[kind]
    parts = lambda cells: {p for t in cells for p in combinations(sorted(t), width)}
    gone = np.array(sorted(parts(tets.tolist()) - parts(new)))[:2]
    assert len(gone) == 2, "the test needs a case where these are flipped"
    mesh = meshio.Mesh(points, [("tetra", tets), (kind, gone)], point_data={"x": points[:, 0]},
                       cell_data={"a": [np.arange(len(tets)), np.arange(2)]}, cell_sets={"all": [None, np.arange(2)]})
    r = tetune.optimize(mesh, data=data)
    assert [len(b.data) for b in r.mesh.cells] == [len(r.parent), 0] and r.mesh.cell_data["a"][1].shape == (0,)
    assert r.mesh.cell_sets["all"][1].size == 0
    if data == "carry":
        assert np.array_equal(r.mesh.cell_data["a"][0], r.parent)
        second = tetune.optimize(tetune.curve(mesh).mesh).mesh
        assert [(b.type[:4], len(b.data)) for b in second.cells] == [("tetr", len(r.parent)), (kind[:4], 0)]
    out = tetune.optimize(pv.from_meshio(mesh), data=data).mesh
    assert out.n_cells == len(r.parent) and np.array_equal(out.cell_data["a"], r.mesh.cell_data["a"][0])


def test_what_is_no_mesh_for_us():
    points, tets = shaken_box(2, 2, 2)
    with pytest.raises(tetune.MeshError, match="there is no tetrahedron in this mesh; its cells are: triangle"):
        tetune.optimize(meshio.Mesh(points, [("triangle", tets[:, :3])]))
    with pytest.raises(tetune.MeshError, match="cells of type hexahedron27 are not supported"):
        tetune.optimize(meshio.Mesh(points, [("hexahedron27", np.zeros((1, 27), int))]))
    with pytest.raises(tetune.MeshError, match="cells of VTK type 29 are not supported"):
        tetune.optimize(pv.examples.cells.TriQuadraticHexahedron())
    with pytest.raises(TypeError, match="this is a pyvista.core.pointset.PolyData"):
        tetune.optimize(pv.Sphere())
    with pytest.raises(TypeError, match="tags names data of a meshio or pyvista mesh"):
        tetune.optimize(points, tets, tags="region")
