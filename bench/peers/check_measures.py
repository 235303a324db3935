# SPDX-License-Identifier: Apache-2.0
"""tetune's measures beside Gmsh's getElementQualities() and VTK's (Verdict's) as pyvista's cell_quality() has them.

  check_measures.py TETUNE [MESH.mesh ...] [--gmsh PYTHON] [--vtk PYTHON]

Measures random tetrahedra, well shaped, flattened and needle-like, some of them inverted, and the meshes given; prints
the largest relative difference of each measure as a Markdown table. The two interpreters have gmsh, and pyvista; both
have numpy, as has the one that runs this. Exit code 1 when a difference is beyond 1e-5."""

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy

# Ours, whose, their name, ours from theirs, whether it has a meaning for inverted tetrahedra.
PAIRS = [
    ("min_dihedral_deg", "numpy", "min_dihedral", None, True),
    ("max_dihedral_deg", "numpy", "max_dihedral", None, True),
    ("mean_ratio", "gmsh", "eta", None, False),
    ("mean_ratio", "vtk", "shape", None, False),
    ("sicn", "gmsh", "minSICN", None, True),
    ("sicn", "vtk", "condition", lambda x: 1 / x, True),
    ("gamma", "gmsh", "gamma", None, False),
    ("scaled_jacobian", "vtk", "scaled_jacobian", None, True),
    ("radius_ratio", "vtk", "radius_ratio", None, False),
    ("aspect_ratio", "vtk", "aspect_ratio", None, False),
    ("q_h", "numpy", "q_h", None, False),
]
# VTK's smallest dihedral angle of a tetrahedron takes two of the six by their supplements, so it depends on the order of
# the vertices; the same is done here to show that this is the only difference.
PAIRS.append(("(as VTK takes them)", "vtk", "min_angle", None, True))
ORDER = ["min_dihedral_deg", "max_dihedral_deg", "mean_ratio", "sicn", "gamma", "scaled_jacobian", "radius_ratio",
         "aspect_ratio", "q_h"]
NAMES = {who: [name for _, w, name, _, _ in PAIRS if w == who] for who in ("gmsh", "vtk", "numpy")}


def by_gmsh(points, tets):
    import gmsh
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("measures")
    gmsh.model.addDiscreteEntity(3, 1)
    gmsh.model.mesh.addNodes(3, 1, numpy.arange(1, len(points) + 1), points.reshape(-1))
    ids = numpy.arange(1, len(tets) + 1)
    gmsh.model.mesh.addElementsByType(1, 4, ids, tets.reshape(-1) + 1)
    print("Gmsh " + gmsh.option.getString("General.Version"), file=sys.stderr)
    return {name: numpy.array(gmsh.model.mesh.getElementQualities(ids, name)) for name in NAMES["gmsh"]}


def by_vtk(points, tets):
    import pyvista
    import vtk
    cells = numpy.hstack([numpy.full((len(tets), 1), 4), tets])
    grid = pyvista.UnstructuredGrid(cells.reshape(-1), numpy.full(len(tets), int(pyvista.CellType.TETRA)), points)
    print(f"VTK {vtk.vtkVersion().GetVTKVersion()}, pyvista {pyvista.__version__}", file=sys.stderr)
    return {name: numpy.array(grid.cell_quality(name)[name]) for name in NAMES["vtk"]}


def by_numpy(points, tets):
    """By other formulas than tetune's: angles between rotated edges, q_h from the matrix that maps the
    regular tetrahedron to this one."""
    p = points[tets]
    angles = {}
    for i in range(4):
        for j in range(i + 1, 4):
            k, l = sorted({0, 1, 2, 3} - {i, j})
            edge = p[:, j] - p[:, i]
            edge /= numpy.linalg.norm(edge, axis=1)[:, None]
            u, v = (x - (x * edge).sum(1)[:, None] * edge for x in (p[:, k] - p[:, i], p[:, l] - p[:, i]))
            angles[i, j] = numpy.degrees(
                numpy.arctan2(numpy.linalg.norm(numpy.cross(u, v), axis=1), (u * v).sum(1)))
    as_vtk = [180 - a if edge in ((0, 2), (1, 3)) else a for edge, a in angles.items()]
    regular = numpy.array([[1, 0, 0], [0.5, 3 ** 0.5 / 2, 0], [0.5, 3 ** 0.5 / 6, (2 / 3) ** 0.5]]).T
    maps = numpy.stack([p[:, k] - p[:, 0] for k in (1, 2, 3)], axis=2) @ numpy.linalg.inv(regular)
    back = numpy.linalg.inv(maps)
    return {"min_dihedral": numpy.min(list(angles.values()), axis=0),
            "max_dihedral": numpy.max(list(angles.values()), axis=0),
            "(as VTK takes them)": numpy.min(as_vtk, axis=0),
            "q_h": 3 * numpy.cbrt(numpy.linalg.det(maps)) ** -2 / (back ** 2).sum((1, 2))}


def random_tets(n=20000, seed=1):
    rng = numpy.random.default_rng(seed)
    points = rng.uniform(-1, 1, (n, 4, 3))
    points[: n // 2, :, 2] *= 10.0 ** rng.uniform(-4, 0, (n // 2, 1))  # flat
    points[: n // 4, :, 1] *= 10.0 ** rng.uniform(-4, 0, (n // 4, 1))  # and thin
    return points.reshape(-1, 3), numpy.arange(4 * n).reshape(-1, 4)


def write_mesh(path, points, tets):
    with open(path, "w") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        file.writelines("%.17g %.17g %.17g 0\n" % tuple(p) for p in points)
        file.write(f"Tetrahedra\n{len(tets)}\n")
        file.writelines("%d %d %d %d 1\n" % tuple(t) for t in tets + 1)
        file.write("End\n")


def section(words, name, each):
    at = words.index(name) + 1
    count = int(words[at])
    return numpy.array(words[at + 1:at + 1 + count * each], dtype=float).reshape(count, each)


def read_mesh(path):
    words = re.sub("#.*", "", Path(path).read_text()).split()
    points, tets = section(words, "Vertices", 4)[:, :3], section(words, "Tetrahedra", 5)[:, :4].astype(numpy.int64) - 1
    if (determinants(points[tets]) <= 0).all():  # as tetune does on reading
        tets = tets[:, [0, 1, 3, 2]]
    return points, tets


def determinants(p):
    return numpy.linalg.det(p[:, 1:] - p[:, :1])


def ours(tetune, mesh, folder):
    solution = folder / "ours.sol"
    done = subprocess.run([tetune, "info", mesh, "--cell-data", solution], capture_output=True, text=True)
    if done.returncode == 2:
        raise SystemExit(done.stderr)
    words = solution.read_text().split()
    at = words.index("SolAtTetrahedra")
    count, fields = int(words[at + 1]), int(words[at + 2])
    assert fields == len(ORDER)
    start = at + 3 + fields
    values = numpy.array(words[start:start + count * fields], dtype=float).reshape(count, fields)
    return dict(zip(ORDER, values.T))


def theirs(who, python, arrays):
    subprocess.run([python, __file__, "--as", who, arrays], check=True)
    return numpy.load(f"{arrays}.{who}.npz")


def main():
    if sys.argv[1:2] == ["--as"]:
        arrays = numpy.load(sys.argv[3])
        values = {"gmsh": by_gmsh, "vtk": by_vtk, "numpy": by_numpy}[sys.argv[2]](arrays["points"], arrays["tets"])
        numpy.savez(f"{sys.argv[3]}.{sys.argv[2]}.npz", **values)
        return 0
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("tetune")
    parser.add_argument("meshes", nargs="*")
    parser.add_argument("--gmsh", default=sys.executable, help="interpreter that has gmsh")
    parser.add_argument("--vtk", default=sys.executable, help="interpreter that has pyvista")
    options = parser.parse_args()
    columns, worst = {}, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_mesh(folder / "random.mesh", *random_tets())
        for mesh in [folder / "random.mesh", *map(Path, options.meshes)]:
            points, tets = read_mesh(mesh)
            arrays = str(folder / "arrays.npz")
            numpy.savez(arrays, points=points, tets=tets)
            values = ours(options.tetune, mesh, folder)
            pythons = {"gmsh": options.gmsh, "vtk": options.vtk, "numpy": sys.executable}
            other = {who: theirs(who, python, arrays) for who, python in pythons.items()}
            positive = determinants(points[tets]) > 0
            column, values = {}, dict(other["numpy"]) | values
            for measure, who, their_name, convert, signed in PAIRS:
                chosen = slice(None) if signed else positive
                a, b = values[measure][chosen], other[who][their_name][chosen]
                b = convert(b) if convert else b
                column[measure, who, their_name] = (numpy.abs(a - b) / numpy.abs(b)).max()
            columns[f"{mesh.stem}, {len(tets)}"] = column
            # VTK's angle is an arc cosine, which has half the digits where the angle is small.
            worst = max(worst, *(d / (1000 if their_name == "min_angle" else 1)
                                 for (_, _, their_name), d in column.items()))
    print("| tetune | other | " + " | ".join(columns) + " |\n|---|---|" + "---|" * len(columns))
    for measure, who, their_name, convert, signed in PAIRS:
        figures = " | ".join(f"{column[measure, who, their_name]:.1e}" for column in columns.values())
        print(f"| {measure} | {who} {'1 / ' if convert else ''}{their_name} | {figures} |")
    return int(worst > 1e-5)


if __name__ == "__main__":
    sys.exit(main())
