# SPDX-License-Identifier: Apache-2.0
"""meshio.Mesh and pyvista.UnstructuredGrid, with all their data."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import tetune
from meshes import BRACKET, shaken_box, volumes
from tetune._adapters import adapter_of

meshio = pytest.importorskip("meshio")
pv = pytest.importorskip("pyvista")


def two_regions():
    points, tets = shaken_box(8, 4, 4)
    return points, tets, np.where(points[tets].mean(axis=1)[:, 0] > 4, 2, 1)


def interface_area(points, tets, tags):
    """Of the faces between regions 1 and 2."""
    faces = np.concatenate([np.delete(tets, f, axis=1) for f in range(4)])
    owner = np.tile(np.arange(len(tets)), 4)
    order = np.lexsort(np.sort(faces, axis=1).T)
    faces, owner = faces[order], owner[order]
    same = np.flatnonzero((np.sort(faces[1:], axis=1) == np.sort(faces[:-1], axis=1)).all(axis=1))
    between = same[tags[owner[same]] != tags[owner[same + 1]]]
    a, b, c = np.moveaxis(points[faces[between]], 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


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


def test_tags_choose_the_regions():
    points, tets, region = two_regions()
    # A wavy interface: only tags hold it.
    shifted = points + np.outer((points[:, 0] == 4) * 0.25 * np.sin(points[:, 1] + points[:, 2]), [1, 0, 0])
    def area_after(mesh, **options):
        r = tetune.optimize(mesh, **options)
        tags = region[r.parent]
        return interface_area(r.mesh.points, r.mesh.cells[0].data, tags) if tags.min() != tags.max() else 0
    mesh = meshio.Mesh(shifted, [("tetra", tets)], cell_data={"material": [region.astype(float)]})
    before = interface_area(shifted, tets, region)
    assert area_after(mesh, tags="material") == pytest.approx(before, rel=1e-12)
    assert area_after(mesh) != pytest.approx(before, rel=1e-3)
    known = meshio.Mesh(shifted, [("tetra", tets)], cell_data={"gmsh:physical": [region]})
    assert area_after(known) == pytest.approx(before, rel=1e-12)
    assert area_after(known, tags=False) != pytest.approx(before, rel=1e-3)
    with pytest.raises(tetune.OptionError, match="tags is 'mat'; the cell data of this mesh are: material"):
        tetune.optimize(mesh, tags="mat")
    half = meshio.Mesh(points, [("tetra", tets)], cell_data={"material": [region / 4]})
    with pytest.raises(tetune.OptionError, match="not whole"):
        tetune.optimize(half, tags="material")
    vectors = meshio.Mesh(points, [("tetra", tets)], cell_data={"material": [np.ones((len(tets), 3))]})
    with pytest.raises(tetune.OptionError, match="has 3 numbers a cell"):
        tetune.optimize(vectors, tags="material")


@pytest.mark.parametrize("name", ["tetgen:ref", "refs"])
@pytest.mark.parametrize("package", ["meshio", "pyvista"])
def test_all_names_of_tags_in_files(name, package):
    points, tets, region = two_regions()
    shifted = points + np.outer((points[:, 0] == 4) * 0.25 * np.sin(points[:, 1] + points[:, 2]), [1, 0, 0])
    mesh = meshio.Mesh(shifted, [("tetra", tets)], cell_data={name: [region]})
    r = tetune.optimize(mesh if package == "meshio" else pv.from_meshio(mesh))
    new = r.mesh.cells_dict["tetra" if package == "meshio" else 10]
    before = interface_area(shifted, tets, region)
    assert r.moved.any() and interface_area(np.asarray(r.mesh.points), new, region[r.parent]) == pytest.approx(before, rel=1e-12)


def test_data_that_are_no_tags():
    points, tets, region = two_regions()
    mesh = meshio.Mesh(points, [("tetra", tets)], cell_data={"medit:ref": [region / 4], "refs": [region]})
    with pytest.warns(UserWarning, match='"medit:ref" does not hold integers of 32 bits: kept as data, not as tags') as record:
        r = tetune.optimize(mesh)
    assert record[0].filename == __file__
    tagged = tetune.optimize(tetune.TetMesh(points, tets, tet_tags=region))
    assert np.array_equal(r.mesh.points, tagged.mesh.points) and np.array_equal(r.mesh.cell_data["medit:ref"][0], region[r.parent] / 4)


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


def test_legacy_files_of_vtk_by_meshio(tmp_path):
    """Their arrays are big-endian."""
    points, tets, region = two_regions()
    mesh = meshio.Mesh(points, [("tetra", tets)], point_data={"x": points[:, 0].copy(), "id": np.arange(len(points))},
                       cell_data={"medit:ref": [region], "load": [np.sqrt(region)]})
    mesh.write(tmp_path / "in.vtk")
    read = meshio.read(tmp_path / "in.vtk")
    assert read.points.dtype == ">f8" and not read.cells[0].data.dtype.isnative
    for options in ({"effort": "best"}, {"data": "interpolate"}, {"data": "conserve"}):
        r, expected = tetune.optimize(read, **options), tetune.optimize(mesh, **options)
        assert np.array_equal(r.mesh.points, expected.mesh.points)
        assert np.array_equal(r.mesh.cells[0].data, expected.mesh.cells[0].data)
        for name, values in expected.mesh.point_data.items():
            assert np.array_equal(r.mesh.point_data[name], values), name
        for name, (values,) in expected.mesh.cell_data.items():
            assert np.array_equal(r.mesh.cell_data[name][0], values), name
    assert np.array_equal(tetune.TetMesh(points.astype(">f4"), tets.astype(">i2")).tets, tets)


def grid(points=None):
    p, tets, region = two_regions()
    g = pv.UnstructuredGrid({pv.CellType.TETRA: tets}, p if points is None else points)
    g.point_data["id"] = np.arange(len(p))
    g.cell_data["region"] = region
    g.cell_data["row"] = np.arange(len(tets))
    g.field_data["note"] = ["mine"]
    g.point_data.active_scalars_name = "id"
    g.point_data["velocity"] = np.ones((len(p), 3))
    g.point_data["force"] = np.ones((len(p), 3))
    g.point_data.active_vectors_name = "velocity"
    g.cell_data.active_scalars_name = "row"
    return g


def test_pyvista():
    g = grid()
    before = g.copy()
    r = tetune.optimize(g, tags="region")
    out = r.mesh
    assert isinstance(out, pv.UnstructuredGrid)
    assert g == before
    assert np.array_equal(out.point_data["id"], np.arange(g.n_points))
    assert np.array_equal(out.cell_data["row"], r.parent)
    assert np.array_equal(out.cell_data["region"], g.cell_data["region"][r.parent])
    assert out.field_data["note"][0] == "mine" and out.point_data.active_scalars_name == "id"
    assert out.point_data.active_vectors_name == "velocity" and out.cell_data.active_scalars_name == "row"
    sized = out.compute_cell_sizes(length=False, area=False)
    assert sized.cell_data["Volume"].min() > 0 and sized.volume == pytest.approx(128)
    assert out.cell_quality("scaled_jacobian")["scaled_jacobian"].min() > g.cell_quality("scaled_jacobian")["scaled_jacobian"].min()
    arrays = tetune.optimize(tetune.TetMesh(g.points, g.cells_dict[10], tet_tags=g.cell_data["region"]))
    assert np.array_equal(out.points, arrays.mesh.points) and np.array_equal(out.cells_dict[10], arrays.mesh.tets)


def test_pyvista_accessor():
    g = grid()
    out = g.tetune.optimize(tags="region", effort="fast")
    assert out == tetune.optimize(g, tags="region", effort="fast").mesh
    assert g.tetune.run(max_iterations=1).report.stop == "iteration limit"
    assert g.tetune.quality().dihedral_min == tetune.quality(g).dihedral_min < out.tetune.quality().dihedral_min
    assert len(g.tetune.measure_each()["q_h"]) == g.n_cells


def test_pyvista_accessor_needs_no_import():
    import subprocess
    import sys

    code = "import pyvista as pv; print(pv.examples.cells.Tetrahedron().tetune.quality().tets)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.stdout.strip() == "1", run.stderr


def test_single_precision_points_come_back_as_doubles():
    p = two_regions()[0].astype(np.float32)
    out = grid(p).tetune.optimize()
    assert out.points.dtype == np.float64
    assert np.array_equal(out.points[0], p[0])


def test_pyvista_mixed_cells():
    points, tets = shaken_box(4, 4, 4)
    top = np.arange(100, 125)
    above = points[top] + [0, 0, 1]
    quad = lambda i, j: [100 + 5 * j + i, 101 + 5 * j + i, 106 + 5 * j + i, 105 + 5 * j + i]
    hexes = np.array([quad(i, j) + [v + 25 for v in quad(i, j)] for i in range(4) for j in range(4)])
    g = pv.UnstructuredGrid(
        {pv.CellType.HEXAHEDRON: hexes, pv.CellType.TETRA: tets, pv.CellType.TRIANGLE: np.array([[0, 1, 5]])},
        np.concatenate([points, above]),
    )
    g.cell_data["row"] = np.arange(g.n_cells)
    r = tetune.optimize(g)
    out = r.mesh
    assert np.array_equal(out.cells_dict[12], hexes) and np.array_equal(out.cells_dict[5], [[0, 1, 5]])
    assert not r.moved[hexes].any() and r.moved.any()
    for t in (5, 12):
        assert np.array_equal(out.cell_data["row"][out.celltypes == t], g.cell_data["row"][g.celltypes == t])
    assert np.array_equal(out.cell_data["row"][out.celltypes == 10], np.flatnonzero(g.celltypes == 10)[r.parent])


def test_what_is_no_mesh_for_us():
    points, tets = shaken_box(2, 2, 2)
    with pytest.raises(tetune.MeshError, match="there is no tetrahedron in this mesh; its cells are: triangle"):
        tetune.optimize(meshio.Mesh(points, [("triangle", tets[:, :3])]))
    with pytest.raises(tetune.MeshError, match="cells of type hexahedron20 are not supported"):
        tetune.optimize(meshio.Mesh(points, [("hexahedron20", np.zeros((1, 20), int))]))
    with pytest.raises(tetune.MeshError, match="cells of VTK type 26 are not supported"):
        tetune.optimize(pv.examples.cells.QuadraticWedge())
    with pytest.raises(TypeError, match="this is a pyvista.core.pointset.PolyData"):
        tetune.optimize(pv.Sphere())
    with pytest.raises(TypeError, match="tags names data of a meshio or pyvista mesh"):
        tetune.optimize(points, tets, tags="region")


DECK = """*NODE, NSET=ALL
{nodes}*ELEMENT, TYPE=C3D4
{tets}*ELSET, ELSET=STEEL
{steel}
*MATERIAL, NAME=M
** the end
"""


def test_decks(tmp_path):
    points, tets, region = two_regions()
    (tmp_path / "in.inp").write_text(DECK.format(
        nodes="".join(f"{10 * i + 10}, {x!r}, {y!r}, {z!r}\n" for i, (x, y, z) in enumerate(points.tolist())),
        tets="".join(f"{t + 1}, {', '.join(str(10 * v + 10) for v in tet)}\n" for t, tet in enumerate(tets.tolist())),
        steel=",\n".join(str(t + 1) for t in np.flatnonzero(region == region[0]))))
    mesh = tetune.read_mesh(str(tmp_path / "in.inp"))
    assert len(set(mesh.tet_tags[region == region[0]])) == 1 and len(set(mesh.tet_tags)) == 2
    r = tetune.optimize(mesh)
    tetune.write_mesh(str(tmp_path / "out.inp"), r.mesh)
    text = (tmp_path / "out.inp").read_text()
    assert text.endswith("*MATERIAL, NAME=M\n** the end\n")
    back = tetune.read_mesh(str(tmp_path / "out.inp"))
    assert r.moved.any() and np.array_equal(back.points, r.mesh.points)
    assert sorted(back.tet_tags) == sorted(r.mesh.tet_tags)


def test_files_of_vtk(tmp_path):
    if not (Path(tetune.__file__).parent / "libexec/tetune/tetune-vtk").is_file():
        pytest.skip("built without VTK: install libvtk9-dev")
    points, tets, region = two_regions()
    grid = pv.UnstructuredGrid({pv.CellType.TETRA: tets}, points)
    grid.point_data["x"] = points[:, 0]
    grid.cell_data["medit:ref"] = region
    grid.save(tmp_path / "in.vtu")
    r = tetune.optimize(tetune.read_mesh(str(tmp_path / "in.vtu")))
    tetune.write_mesh(str(tmp_path / "out.vtu"), r.mesh)
    out = pv.read(tmp_path / "out.vtu")
    assert r.moved.any() and np.array_equal(out.points, r.mesh.points)
    assert np.array_equal(out.point_data["x"], points[:, 0])
    assert np.array_equal(out.cell_data["medit:ref"], region[r.parent])
    with pytest.warns(UserWarning, match='the format cannot hold the data "x"'):
        tetune.write_mesh(str(tmp_path / "out.mesh"), r.mesh)
