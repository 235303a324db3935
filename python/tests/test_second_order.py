# SPDX-License-Identifier: Apache-2.0
"""Second-order cells of meshio and pyvista, in the order of nodes of each library."""

import numpy as np
import pytest

import tetune
from meshes import shaken_box
from tetune._adapters import adapter_of

meshio = pytest.importorskip("meshio")
pv = pytest.importorskip("pyvista")

EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]


def with_middles(points, tets, curve=lambda p: p):
    """The points of the vertices and, before them, of mid-side nodes on straight edges; all mapped by `curve`."""
    ends = np.sort(tets[:, EDGES].reshape(-1, 2), axis=1)
    edges, inverse = np.unique(ends, axis=0, return_inverse=True)
    n = len(edges)
    nodes = np.concatenate([points[edges].mean(axis=1), points])
    return curve(nodes), np.hstack([tets + n, inverse.reshape(-1, 6)])


def bent(p):
    x, y, z = p.T
    return np.stack([x + 0.02 * z**2, y, z + 0.02 * x**2], axis=1)


def bent_box():
    """With straight inner edges."""
    points, tets = shaken_box(6, 4, 4)
    nodes, cells = with_middles(points, tets)
    size = points.max(axis=0)
    on_surface = ((nodes == 0) | (nodes == size)).any(axis=1)
    corners = bent(nodes)
    for k, (a, b) in enumerate(EDGES):
        inner = ~on_surface[cells[:, 4 + k]]
        corners[cells[inner, 4 + k]] = (corners[cells[inner, a]] + corners[cells[inner, b]]) / 2
    return corners, cells


def test_elements_that_are_not_valid_have_an_error_of_their_own():
    points, tets = shaken_box(3, 3, 3)
    edge = sorted(tets[0][:2])
    mesh = tetune.TetMesh(points, tets, curved_edges=[edge], curved_middles=[points[edge].mean(axis=0) + 3])
    with pytest.raises(tetune.CurvedError, match=r"measure_curved_each\(\) measures them"):
        tetune.optimize(mesh)
    assert issubclass(tetune.CurvedError, tetune.MeshError)


def middles_by_edge(points, cells):
    """Positions by the positions of the ends."""
    by_edge = {}
    for cell in cells:
        for k, (a, b) in enumerate(EDGES):
            by_edge[frozenset([tuple(points[cell[a]]), tuple(points[cell[b]])])] = tuple(points[cell[4 + k]])
    return by_edge


def test_curved_meshio():
    points, cells = bent_box()
    mesh = meshio.Mesh(
        points, [("tetra10", cells)],
        point_data={"x": points[:, 0], "id": np.arange(len(points))}, cell_data={"row": [np.arange(len(cells))]},
    )
    before = tetune.quality(mesh)
    assert 100 < before.curved.tets == before.curved.valid < len(cells)
    r = tetune.optimize(mesh)
    out, (block,) = r.mesh, r.mesh.cells
    assert block.type == "tetra10" and tetune.quality(out).curved.valid == tetune.quality(out).curved.tets
    assert tetune.quality(out).mean_ratio > before.mean_ratio
    kept = r.vertex_map >= 0
    assert np.array_equal(out.point_data["id"][kept], r.vertex_map[kept])
    assert np.array_equal(r.moved, ~kept | (out.points != points[r.vertex_map]).any(axis=1)) and r.moved.any()
    assert np.array_equal(out.cell_data["row"][0], r.parent)
    # Nodes of a curved surface stay, and nodes of the input keep their order.
    assert (np.diff(r.vertex_map[kept]) > 0).all()
    before_by_edge, after_by_edge = middles_by_edge(points, cells), middles_by_edge(out.points, block.data)
    shared = before_by_edge.keys() & after_by_edge.keys()
    held = [e for e in shared if all(abs(p[2] - 0.02 * p[0] ** 2) < 1e-9 for p in e)]  # the bottom is curved
    assert len(held) > 20 and all(before_by_edge[e] == after_by_edge[e] for e in held)


def test_curved_pyvista_has_the_order_of_vtk():
    points, cells = bent_box()
    grid = pv.UnstructuredGrid({pv.CellType.QUADRATIC_TETRA: cells}, points)
    grid.cell_data["row"] = np.arange(len(cells))
    out = tetune.optimize(grid).mesh
    assert set(out.celltypes) == {24}
    by_edge = middles_by_edge(np.asarray(out.points), out.cells_dict[24])
    for t in range(0, out.n_cells, 17):
        for edge in out.get_cell(t).edges:
            a, b, middle = map(tuple, edge.points)
            assert by_edge[frozenset([a, b])] == middle
            assert np.linalg.norm(np.mean([a, b], axis=0) - middle) < 0.2
    assert grid.tetune.quality().curved.tets == tetune.quality(meshio.Mesh(points, [("tetra10", cells)])).curved.tets > 100


def test_straight_second_order_stays_so():
    points, cells = with_middles(*shaken_box(4, 3, 3))
    triangle = cells[:1, [0, 1, 2, 4, 5, 6]]
    mesh = meshio.Mesh(points, [("tetra10", cells), ("triangle6", triangle)], cell_data={"medit:ref": [np.ones(len(cells)), [7]]})
    r = tetune.optimize(mesh)
    new, p = r.mesh.cells[0].data, r.mesh.points
    assert tetune.quality(r.mesh).curved.tets == 0
    for k, (a, b) in enumerate(EDGES):
        assert np.abs(p[new[:, 4 + k]] - (p[new[:, a]] + p[new[:, b]]) / 2).max() < 1e-15 * 8
    assert r.mesh.cells[1].type == "triangle6" and len(r.mesh.cells[1].data) == 1
    assert (r.vertex_map == -1).any() and len(np.unique(new)) == len(p)
    moved = tetune.move(mesh, to=points + [1, 0, 0]).mesh
    assert np.allclose(moved.points[:, 0].min(), points[:, 0].min() + 1)


def test_data_of_mid_side_nodes_that_move():
    """They follow their edge, and with data="interpolate" are means of both ends."""
    points, cells = with_middles(*shaken_box(4, 3, 3))
    own = points[:, 0].copy()
    own[cells[:, 4:]] = 1000
    mesh = meshio.Mesh(points, [("tetra10", cells)], point_data={"x": own})
    middles = np.unique(cells[:, 4:])
    for data in ("carry", "interpolate"):
        r = tetune.optimize(mesh, data=data, boundary="fixed")
        old = np.isin(r.vertex_map, middles)
        stayed, moved = old & ~r.moved, old & r.moved
        assert stayed.sum() > 0 and moved.sum() > 0
        values = r.mesh.point_data["x"]
        assert (values[stayed] == 1000).all()
        assert (values[moved] == 1000).all() if data == "carry" else (values[moved] < 5).all()


def test_arrays_of_curved_edges():
    points, cells = bent_box()
    mesh = tetune.TetMesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]], curved_edges=[[1, 0]], curved_middles=[[0.5, 0, -0.1]]
    )
    assert mesh.second_order and mesh.curved_edges.tolist() == [[0, 1]] and mesh.curved_middles.tolist() == [[0.5, 0, -0.1]]
    (tet,) = tetune.measure_curved_each(mesh)
    assert tet.validity == "valid" and 0 < tet.scaled_jacobian < 1 and tet.middle_offset == pytest.approx(0.1)
    mesh.curved_middles[0, 0] = 2
    assert tetune.measure_curved_each(mesh)[0].validity == "inverted"
    assert tetune.TetMesh(mesh.points, mesh.tets).curved_edges.shape == (0, 2)
    with pytest.raises(ValueError, match="the same number of rows"):
        tetune.TetMesh(mesh.points, mesh.tets, curved_edges=[[0, 1]])


def test_gmsh(tmp_path):
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addSphere(0, 0, 0, 1)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMin", 0.5)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(tmp_path / "ball.msh"))
        mesh = meshio.read(tmp_path / "ball.msh")
        own = tetune.quality(tetune.read_mesh(str(tmp_path / "ball.msh"))).curved
        assert own.tets > 50 and own.max_middle_offset > 0.01
        assert tetune.quality(mesh).curved.min_scaled_jacobian == pytest.approx(own.min_scaled_jacobian, abs=1e-12)
        out = tetune.optimize(mesh, untangle=True).mesh
        assert tetune.quality(out).curved.all_valid
        meshio.write_points_cells(tmp_path / "out.msh", out.points, {"tetra10": out.get_cells_type("tetra10")}, file_format="gmsh")
        gmsh.clear()
        gmsh.open(str(tmp_path / "out.msh"))
        tags = gmsh.model.mesh.getElementsByType(11)[0]
        assert gmsh.model.mesh.getElementQualities(tags, "minDetJac").min() > 0
    finally:
        gmsh.finalize()


def test_curve():
    points, tets = shaken_box(4, 3, 3, 0)
    points = bent(points)
    arrays = tetune.curve(points, tets)
    assert arrays.report.curved_edges == len(arrays.mesh.curved_edges) > 50 and arrays.report.straightened == []
    x, y, z = arrays.mesh.curved_middles[(abs(points[:, 2] - 0.02 * points[:, 0] ** 2) < 1e-9)[arrays.mesh.curved_edges].all(axis=1)].T
    assert len(z) > 20 and abs(z - 0.02 * x**2).max() < 1e-4
    assert tetune.quality(arrays.mesh).curved.all_valid
    mesh = meshio.Mesh(points, [("tetra", tets), ("triangle", tets[:1, :3])], point_data={"x": points[:, 0], "i": np.arange(len(points))})
    out = tetune.curve(mesh).mesh
    assert [b.type for b in out.cells] == ["tetra10", "triangle6"]
    assert np.array_equal(out.points[: len(points)], arrays.mesh.points)
    assert tetune.quality(out).curved.curved_edges == arrays.report.curved_edges
    assert np.array_equal(out.point_data["i"][: len(points)], np.arange(len(points))) and out.point_data["i"].dtype == int
    assert np.array_equal(out.points[out.cells[0].data[:, :4]], arrays.mesh.points[tets])
    grid = tetune.curve(pv.from_meshio(mesh)).mesh
    assert sorted(set(grid.celltypes)) == [22, 24]
    for edge in grid.get_cell(int(np.flatnonzero(grid.celltypes == 24)[0])).edges:
        assert np.linalg.norm(edge.points[:2].mean(axis=0) - edge.points[2]) < 0.1
    fine, fine_tets = shaken_box(12, 9, 9, 0)
    fine = bent(fine * points.max(axis=0)[1] / fine.max(axis=0)[1])
    on_finer = tetune.curve(points, tets, surface=meshio.Mesh(fine, [("tetra", fine_tets)]))
    assert on_finer.report.curved_edges > 50 and tetune.quality(on_finer.mesh).curved.all_valid
    with pytest.raises(tetune.MeshError, match="the finer surface is not that of the mesh"):
        tetune.curve(points, tets, surface=meshio.Mesh(2 * fine, [("tetra", fine_tets)]))
    with pytest.raises(tetune.MeshError, match="curved edges already"):
        tetune.curve(out)
    with pytest.raises(tetune.OptionError, match="feature_angle is 0"):
        tetune.curve(points, tets, feature_angle=0)


def test_straighten():
    points, tets = shaken_box(3, 3, 3, 0)
    # A triangle of the bottom is folded by the middle of one of its edges.
    (a, b, c), *_ = (t for t in np.concatenate([tets[:, f] for f in ([0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3])]) if (points[t, 2] == 0).all())
    mesh = tetune.TetMesh(points, tets, curved_edges=[sorted([a, b])], curved_middles=[(points[a] + points[b]) / 2 * 0.45 + points[c] * 0.55])
    with pytest.raises(tetune.MeshError, match="fold"):
        tetune.optimize(mesh, untangle=True)
    r = tetune.optimize(mesh, untangle=True, straighten=True)
    (edge,) = r.report.straightened
    assert tuple(edge.vertices) == tuple(sorted([a, b])) and 0 < edge.kept < 1 and edge.moved > 0
    assert tetune.quality(r.mesh).curved.all_valid


def test_refused():
    points, cells = bent_box()
    with pytest.raises(tetune.MeshError, match="tetra10 beside tetra"):
        tetune.quality(meshio.Mesh(points, [("tetra10", cells[1:]), ("tetra", cells[:1, :4])]))
    wrong = cells.copy()
    wrong[0, 4] = cells[1, 0]
    with pytest.raises(tetune.MeshError, match="is a mid-side node of one cell and a vertex of another"):
        tetune.quality(meshio.Mesh(points, [("tetra10", wrong)]))
    wrong = cells.copy()
    wrong[0, 4] = cells[0, 5]
    with pytest.raises(tetune.MeshError, match="two edges, or one of two nodes of the same edge"):
        tetune.quality(meshio.Mesh(points, [("tetra10", wrong)]))
    wrong[0, 4] = len(points)
    with pytest.raises(tetune.MeshError, match=f"a mid-side node is {len(points)}; the mesh has {len(points)} points"):
        tetune.quality(meshio.Mesh(points, [("tetra10", wrong)]))
    with pytest.raises(tetune.MeshError, match="holds no mid-side nodes"):
        tetune.LiveMesh(meshio.Mesh(points, [("tetra10", cells)]))


WEDGE_EDGES = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]


def test_other_kinds_keep_their_nodes():
    flat, tets = shaken_box(4, 3, 3)
    nodes, cells = with_middles(flat, tets)
    first = len(nodes) - len(flat)
    faces = np.concatenate([tets[:, k] for k in ([0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2])])
    faces = faces[(flat[faces][..., 2] == 0).all(axis=1)]
    corners = np.unique(faces)
    lower = {v: len(nodes) + i for i, v in enumerate(corners)}
    middle = {tuple(sorted((cell[a], cell[b]))): cell[4 + k] for cell in cells for k, (a, b) in enumerate(EDGES)}
    positions, wedges = [*nodes, *(flat[corners] - [0, 0, 1])], []
    for face in faces:
        row = [*(lower[v] for v in face), *(first + face)]
        for a, b in WEDGE_EDGES:
            edge = tuple(sorted((row[a], row[b])))
            if edge not in middle:
                middle[edge] = len(positions)
                positions.append((positions[edge[0]] + positions[edge[1]]) / 2)
            row.append(middle[edge])
        wedges.append(row)
    positions, wedges = bent(np.array(positions)), np.array(wedges)
    grid = pv.UnstructuredGrid({24: cells, 26: wedges}, positions)
    work = adapter_of(grid, None).tet_mesh()
    assert work.second_order and work.second_order_others == [True] and work.others[0][0] == "Prisms"
    assert len(work.points) == len(flat) + len(corners)
    r = tetune.optimize(grid, boundary="slide")
    assert r.moved.any()
    kept = r.mesh.cells_dict
    new = r.mesh.points[kept[26]]
    assert np.array_equal(new, positions[wedges])
    by_edge = middles_by_edge(r.mesh.points, kept[24])
    for k, (a, b) in enumerate(WEDGE_EDGES):
        for wedge in new:
            edge = frozenset([tuple(wedge[a]), tuple(wedge[b])])
            assert by_edge.get(edge, tuple(wedge[6 + k])) == tuple(wedge[6 + k])
    with pytest.raises(tetune.MeshError, match="cells of type wedge15 without tetra10 beside them are not supported"):
        tetune.optimize(pv.UnstructuredGrid({10: cells[:, :4], 26: wedges}, positions))
    with pytest.raises(ValueError, match="second_order_others must have one entry per entry of others"):
        tetune.TetMesh(flat, tets, second_order_others=[True])


def test_hexahedra_of_meshio():
    points, cells = bent_box()
    corners = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float) + [9, 0, 0]
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    hexahedron = bent(np.concatenate([corners, corners[edges].mean(axis=1)]))
    mesh = meshio.Mesh(np.concatenate([points, hexahedron]), [("tetra10", cells), ("hexahedron20", len(points) + np.arange(20)[None])])
    for r in (tetune.optimize(mesh), tetune.optimize(mesh, boundary="slide")):
        assert r.moved.any() and [b.type for b in r.mesh.cells] == ["tetra10", "hexahedron20"]
        assert np.array_equal(r.mesh.points[r.mesh.cells[1].data[0]], hexahedron)
        assert tetune.quality(r.mesh).curved.all_valid
