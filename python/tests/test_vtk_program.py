# SPDX-License-Identifier: Apache-2.0
"""Files of VTK where tetune was built without it, as in a wheel: through pyvista or meshio."""

import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import tetune
from meshes import BRACKET, ROOT, shaken_box
from tetune._adapters import adapter_of

meshio = pytest.importorskip("meshio")
PACKAGE = Path(tetune.__file__).parent
PROGRAM = Path("libexec/tetune/tetune-vtk")
OWN = next((p for p in map(Path, tetune.__path__) if (p / "bin").is_dir()), PACKAGE)
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="plugins are for Linux")


@pytest.fixture
def command(tmp_path):
    """Runs the command line with a plugin of Python that has one of the packages."""

    def make(package):
        if package is not None:
            pytest.importorskip(package)
        folder = tmp_path / f"with-{package}" / "tetune"
        shutil.copytree(OWN, folder, ignore=shutil.ignore_patterns("*.py", "*.pyi", "__pycache__", "tetune-gmsh"))
        if (libraries := OWN.parent / "tetune.libs").is_dir():  # of others, in a wheel
            shutil.copytree(libraries, folder.parent / libraries.name)
        (folder / PROGRAM).parent.mkdir(parents=True, exist_ok=True)
        (folder / PROGRAM).unlink(missing_ok=True)
        hidden = {"pyvista", "meshio"} - {package}
        code = f"import runpy, sys; sys.modules.update(dict.fromkeys({hidden})); runpy.run_path({str(PACKAGE / '_vtk_program.py')!r}, run_name='__main__')"
        (folder / PROGRAM).write_text(f"#!/bin/sh\nexec '{sys.executable}' -c \"{code}\" \"$@\"\n")
        (folder / PROGRAM).chmod(0o755)
        return lambda *words: subprocess.run([folder / "bin" / "tetune", *words], capture_output=True, text=True, cwd=tmp_path)

    return make


HEXAHEDRON_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]


def rich_mesh(order=1):
    """Regions, triangles, quadrilaterals, hexahedra and data; of second order, with a curved edge of a tetrahedron and one of
    a hexahedron."""
    points, tets = shaken_box(4, 2, 2)
    far = np.array([[x, y, z] for z in (5, 6) for y in (0, 1) for x in (0, 1)], float)
    region = np.where(points[tets].mean(axis=1)[:, 0] > 2, 2, 1)
    order_of_msh = np.argsort(region, kind="stable")
    tets, region = tets[order_of_msh], region[order_of_msh]
    hexahedron = len(points) + np.array([[0, 1, 3, 2, 4, 5, 7, 6]])
    points = np.concatenate([points, far])
    cells = [("tetra", tets), ("triangle", [[0, 1, 6], [0, 1, 5]]), ("quad", hexahedron[:, :4]), ("hexahedron", hexahedron)]
    if order == 2:
        pairs = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
        edges, number = np.unique(np.concatenate([np.sort(tets[:, p], axis=1) for p in pairs]), axis=0, return_inverse=True)
        middles = points[edges].mean(axis=1)
        middles[7] += [0.01, 0.02, 0]
        ends = points[hexahedron[0][HEXAHEDRON_EDGES]]
        hexahedron = np.hstack([hexahedron, len(points) + len(middles) + np.arange(12)[None, :]])
        cells = [("tetra10", np.hstack([tets, len(points) + number.reshape(6, -1).T])), cells[2], ("hexahedron20", hexahedron)]
        points = np.concatenate([points, middles, ends.mean(axis=1)])
        points[-2] += [0.02, 0.01, 0]
    sizes = [len(ids) for _, ids in cells]
    tags = [region, *(np.full(n, 5 + i) for i, n in enumerate(sizes[1:]))]
    required = np.zeros(len(points), np.uint8)
    required[3] = 1
    return meshio.Mesh(
        points, cells,
        point_data={"u": points * 2.5, "id": np.arange(len(points), dtype=np.int16), "mmg_required_vertices": required},
        cell_data={"medit:ref": tags, "load": [np.linspace(0, 1, n, dtype=np.float32) for n in sizes]},
    )


@pytest.mark.parametrize(("package", "order"), [("pyvista", 1), ("meshio", 2)])
def test_same_mesh_as_through_vtk(command, tmp_path, package, order):
    rich_mesh(order).write(tmp_path / "in.vtu")
    run = command(package)
    done = run("convert", "in.vtu", "out.msh")
    assert done.returncode == 0, done.stderr
    done = run("convert", "out.msh", "back.vtu")
    assert done.returncode == 0, done.stderr
    mesh, back = rich_mesh(order), meshio.read(tmp_path / "back.vtu")
    kinds = [b.type for b in back.cells]
    assert sorted(kinds) == sorted(b.type for b in mesh.cells) and len(back.points) == len(mesh.points)
    for i, block in enumerate(mesh.cells):
        j = kinds.index(block.type)
        assert np.array_equal(back.points[back.cells[j].data], mesh.points[block.data])
        for name, kept_as in (("medit:ref", "gmsh:physical"), ("load", "load")):  # as the .msh between has it
            assert np.array_equal(back.cell_data[kept_as][j], mesh.cell_data[name][i]), name
    middles = [mesh.cells[0].data[:, 4:].ravel(), mesh.cells[-1].data[:, 8:].ravel()]  # none of first order
    vertices = np.isin(np.arange(len(mesh.points)), np.concatenate(middles), invert=True)
    for name in ("u", "id"):
        assert np.array_equal(back.point_data[name][: vertices.sum()], mesh.point_data[name][vertices]), name
    # Where the command line of this package has VTK itself, it reads the same.
    own = OWN / PROGRAM
    if own.exists() and own.read_bytes()[:2] != b"#!":
        subprocess.run([OWN / "bin" / "tetune", "convert", "in.vtu", "vtk.msh"], cwd=tmp_path, check=True)
        assert (tmp_path / "vtk.msh").read_bytes() == (tmp_path / "out.msh").read_bytes()


@pytest.mark.parametrize("package", ["pyvista", "meshio"])
def test_wedges_of_second_order(command, tmp_path, package):
    """meshio has none."""
    pv = pytest.importorskip("pyvista")
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 2], [1, 0, 2], [0, 1, 2]], float)
    edges = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
    wedge = pv.UnstructuredGrid({26: np.arange(15)[None]}, np.concatenate([points, points[edges].mean(axis=1)]))
    wedge.save(tmp_path / "in.vtu")
    run = command(package)
    done = run("convert", "in.vtu", "out.unv")
    if package == "meshio":
        assert done.returncode == 2 and "meshio has no cells of type wedge15; install pyvista" in done.stderr
        return
    assert done.returncode == 0, done.stderr
    done = run("convert", "out.unv", "back.vtu")
    assert done.returncode == 0, done.stderr
    back = pv.read(tmp_path / "back.vtu")
    assert np.array_equal(back.points[back.cells_dict[26][0]], wedge.points)


@pytest.mark.parametrize("package", ["pyvista", "meshio"])
def test_data_of_mid_side_nodes(command, tmp_path, package):
    mesh = rich_mesh(2)
    mesh.point_data["single"] = np.sqrt(np.arange(len(mesh.points), dtype=np.float32))
    mesh.point_data["refs"] = np.arange(len(mesh.points), dtype=np.int32) + 1
    mesh.write(tmp_path / "in.vtu")
    done = command(package)("convert", "in.vtu", "out.vtu")
    assert done.returncode == 0, done.stderr
    out = meshio.read(tmp_path / "out.vtu")
    cells = next(b.data for b in out.cells if b.type == "tetra10")
    for k, (a, b) in enumerate([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]):
        node, first, second = cells[:, 4 + k], cells[:, [a, b]].min(axis=1), cells[:, [a, b]].max(axis=1)
        for name in ("u", "single"):
            values = out.point_data[name]
            assert np.array_equal(values[node], (values[first] + values[second]) / 2), name
        assert np.array_equal(out.point_data["id"][node], out.point_data["id"][first])
        assert not out.point_data["refs"][node].any() and not out.point_data["mmg_required_vertices"][node].any()
    assert {n: v.dtype for n, v in out.point_data.items()} == {n: v.dtype for n, v in mesh.point_data.items()}
    own = OWN / PROGRAM
    if own.exists() and own.read_bytes()[:2] != b"#!":
        subprocess.run([OWN / "bin" / "tetune", "convert", "in.vtu", "vtk.vtu"], cwd=tmp_path, check=True)
        same = meshio.read(tmp_path / "vtk.vtu")
        assert np.array_equal(out.points, same.points) and out.point_data.keys() == same.point_data.keys()
        for name, values in same.point_data.items():
            assert np.array_equal(out.point_data[name], values), name


@pytest.mark.parametrize("order", [1, 2])
def test_pieces_with_ghosts(command, tmp_path, order):
    """Points where the pieces meet are one, and a ghost cell is the copy of a cell of the other piece."""
    whole = meshio.Mesh(*(lambda p, t: (p, [("tetra", t)]))(*shaken_box(4, 2, 2)))
    if order == 2:
        whole = tetune.curve(whole).mesh
        whole.points += np.stack([0.02 * whole.points[:, 1] ** 2, 0 * whole.points[:, 0], 0 * whole.points[:, 0]], axis=1)
    kind, cells = whole.cells[0].type, whole.cells[0].data
    left = whole.points[cells].mean(axis=1)[:, 0] < 2
    for name, ids, ghosts in (("a.vtu", np.flatnonzero(left), 0), ("b.vtu", np.flatnonzero(~left), 3)):
        ids = np.concatenate([np.flatnonzero(left)[:ghosts], ids])
        used, number = np.unique(cells[ids], return_inverse=True)
        ghost = (np.arange(len(ids)) < ghosts).astype(np.uint8)
        meshio.Mesh(whole.points[used], [(kind, number.reshape(len(ids), -1))], cell_data={"vtkGhostType": [ghost]}).write(tmp_path / name)
    (tmp_path / "whole.pvtu").write_text(
        '<VTKFile type="PUnstructuredGrid" version="1.0"><PUnstructuredGrid GhostLevel="1"><PCellData>'
        '<PDataArray type="UInt8" Name="vtkGhostType"/></PCellData><PPoints><PDataArray type="Float64" NumberOfComponents="3"/>'
        '</PPoints><Piece Source="a.vtu"/><Piece Source="b.vtu"/></PUnstructuredGrid></VTKFile>')
    done = command("pyvista")("convert", "whole.pvtu", "out.msh")
    assert done.returncode == 0, done.stderr
    out, expected = tetune.read_mesh(tmp_path / "out.msh"), adapter_of(whole, None).tet_mesh()
    by_place = lambda mesh, cells: sorted(map(sorted, mesh.points[cells].tolist()))
    assert len(out.points) == len(expected.points) and by_place(out, out.tets) == by_place(expected, expected.tets)
    assert len(out.curved_edges) == len(expected.curved_edges) and (len(out.curved_edges) > 0) == (order == 2)
    assert by_place(out, out.curved_edges) == by_place(expected, expected.curved_edges)
    assert sorted(out.curved_middles.tolist()) == sorted(expected.curved_middles.tolist())


@pytest.mark.parametrize("package", ["pyvista", "meshio"])
def test_ghosts_of_one_file(command, tmp_path, package):
    points, tets = shaken_box(2, 2, 2)
    region = np.arange(len(tets), dtype=np.int32) + 1
    ghost = (region % 4 == 0).astype(np.uint8)
    meshio.Mesh(points, [("tetra", tets), ("triangle", tets[:2, :3])], cell_data={
        "vtkGhostType": [ghost, np.array([0, 1], np.uint8)], "medit:ref": [region, np.array([90, 91], np.int32)]}).write(tmp_path / "in.vtu")
    done = command(package)("convert", "in.vtu", "out.mesh")
    assert done.returncode == 0, done.stderr
    out = tetune.read_mesh(tmp_path / "out.mesh")
    assert np.array_equal(out.tets, tets[ghost == 0]) and np.array_equal(out.tet_tags, region[ghost == 0])
    assert out.triangle_tags.tolist() == [90]


@pytest.mark.parametrize("package", ["pyvista", "meshio"])
def test_meshes_inside_out_are_written_as_they_came(command, tmp_path, package):
    points, tets = shaken_box(2, 2, 2)
    turned = tets[:, [0, 1, 3, 2]]
    meshio.Mesh(points, [("tetra", turned)]).write(tmp_path / "in.vtu")
    done = command(package)("convert", "in.vtu", "out.vtu")
    assert done.returncode == 0, done.stderr
    assert np.array_equal(meshio.read(tmp_path / "out.vtu").cells[0].data, turned)


def test_no_warning_of_pyvista(tmp_path):
    pytest.importorskip("pyvista")
    from tetune._vtk_program import load_by_pyvista

    rich_mesh().write(tmp_path / "in.vtu")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        grid = load_by_pyvista(str(tmp_path / "in.vtu"), [])
    cells = {kind: ids for kind, ids, _ in grid.cells}
    for block, kind in zip(rich_mesh().cells, (10, 5, 9, 12)):
        assert np.array_equal(cells[kind], block.data)


def test_required_entities(command, tmp_path):
    rich_mesh().write(tmp_path / "in.vtu")
    run = command("meshio")
    for a, b in (("in.vtu", "a.mesh"), ("a.mesh", "back.vtu"), ("back.vtu", "b.mesh")):
        assert run("convert", a, b).returncode == 0
    assert (tmp_path / "a.mesh").read_bytes() == (tmp_path / "b.mesh").read_bytes()
    assert np.array_equal(tetune.read_mesh(str(tmp_path / "a.mesh")).required_vertices, [3])


@pytest.mark.parametrize("package", ["pyvista", "meshio"])
def test_long_names_in_legacy_files(command, tmp_path, package):
    mesh = rich_mesh()
    names = ["f" * 255, "f" * 256, "f" * 300, "\u00f6" * 43]  # each of the last takes six characters
    values = [np.arange(len(mesh.points)) + float(i) for i in range(len(names))]
    mesh.point_data |= dict(zip(names, values))
    mesh.write(tmp_path / "in.vtu")
    run = command(package)
    done = run("convert", "in.vtu", "out.vtk")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("is longer than the format allows") == 3
    back = run("convert", "out.vtk", "back.vtu")
    assert back.returncode == 0, back.stderr
    short = ["f" * 255, "f" * 253 + "~2", "f" * 253 + "~3"]
    data = meshio.read(tmp_path / "back.vtu").point_data
    for name, value in zip(short, values):
        assert np.array_equal(data[name], value), name
    if package == "pyvista":  # meshio reads no names that are not ASCII from legacy files
        assert np.array_equal(data["\u00f6" * 42], values[3])


@pytest.mark.parametrize("package", ["pyvista", "meshio"])
def test_data_with_the_name_of_tags_are_renamed(command, tmp_path, package):
    nodes = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n"
    (tmp_path / "in.msh").write_text(
        f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n{nodes}$EndNodes\n"
        "$Elements\n2\n1 4 2 5 5 1 2 3 4\n2 4 2 9 9 2 5 3 4\n$EndElements\n"
        '$ElementData\n1\n"gmsh:physical"\n1\n0.0\n3\n0\n1\n2\n1 1\n2 2\n$EndElementData\n')
    done = command(package)("convert", "in.msh", "out.vtu")
    assert done.returncode == 0, done.stderr
    assert 'the cell data "gmsh:physical" are renamed to "gmsh:physical:before", as tags have this name' in done.stderr
    data = meshio.read(tmp_path / "out.vtu").cell_data
    assert np.array_equal(np.concatenate(data["gmsh:physical"]), [5, 9])
    assert np.array_equal(np.concatenate(data["gmsh:physical:before"]), [1, 2])


@pytest.mark.parametrize("package", ["pyvista", "meshio"])
def test_field_data_are_a_warning(command, tmp_path, package):
    pv = pytest.importorskip("pyvista")
    grid = pv.UnstructuredGrid({10: np.array([[0, 1, 2, 3]])}, np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float))
    grid.field_data["origin"] = [1.0, 2.0]
    grid.save(tmp_path / "in.vtu")
    done = command(package)("convert", "in.vtu", "out.mesh")
    assert done.returncode == 0, done.stderr
    assert 'the field data "origin" is not kept' in done.stderr


def test_optimize(command, tmp_path):
    run = command("meshio")
    done = run("optimize", str(BRACKET), "a.vtk")
    assert done.returncode == 0, done.stderr
    assert run("optimize", str(BRACKET), "a.meshb").returncode == 0
    assert run("convert", "a.vtk", "b.meshb").returncode == 0
    a, b = tetune.read_mesh(str(tmp_path / "a.meshb")), tetune.read_mesh(str(tmp_path / "b.meshb"))
    assert np.array_equal(a.points, b.points) and np.array_equal(a.tets, b.tets) and np.array_equal(a.tet_tags, b.tet_tags)


def test_errors_come_before_the_work(command, tmp_path):
    run = command(None)
    done = run("optimize", str(BRACKET), "out.vtu")
    assert done.returncode == 2 and "pip install" in done.stderr and "out.vtu" in done.stderr
    run = command("meshio")
    done = run("optimize", str(BRACKET), "out.e")
    assert done.returncode == 2 and "convert the mesh" in done.stderr
    script = tmp_path / "with-meshio" / "tetune" / PROGRAM
    assert run("convert", str(BRACKET), "good.vtu").returncode == 0
    # From this folder it finds no interpreter.
    script.write_bytes((ROOT / "python" / "src" / "tetune-vtk.sh").read_bytes())
    done = run("info", "good.vtu")
    assert done.returncode == 2 and "there is no Python interpreter to run it" in done.stderr and "damaged" not in done.stderr


def test_damaged_files(command, tmp_path):
    run = command("meshio")
    (tmp_path / "broken.vtu").write_text("<VTKFile>")
    done = run("info", "broken.vtu")
    assert done.returncode == 2 and "broken.vtu: meshio failed to read it" in done.stderr
