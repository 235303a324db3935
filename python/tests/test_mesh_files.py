# SPDX-License-Identifier: Apache-2.0
"""Meshes in files: decks, and those of VTK."""

from pathlib import Path

import numpy as np
import pytest

import tetune
from meshes import two_regions

meshio = pytest.importorskip("meshio")
pv = pytest.importorskip("pyvista")


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
