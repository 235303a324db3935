# SPDX-License-Identifier: Apache-2.0
"""pyvista.UnstructuredGrid, and the accessor of its meshes."""

import numpy as np
import pytest

import tetune
from meshes import shaken_box, two_regions

pv = pytest.importorskip("pyvista")


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
