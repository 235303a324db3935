# SPDX-License-Identifier: Apache-2.0
"""Makes test meshes with the names and the tetrahedron counts of the ten in the paper: a surface of our own for each,
meshed by TetGen with its optimizer off. See README.md."""

import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[i] / part) for i, part in ((1, ""), (2, "common"))]
import curved  # noqa: E402
import harness  # noqa: E402
import planes  # noqa: E402
import published  # noqa: E402

TOLERANCE = 0.1  # of the paper's count

# The maker; the length of its triangles' edges, and the largest that still shows its details (None: plane facets, as large as
# they are); TetGen's bound on the volume, found by --search. At another scale of the counts the length and the bound follow the
# size of the tetrahedra, and the bound is searched.
SHAPES = {
    "Block": (curved.block, 0.08, 0.15, 2.603e-4),
    "Ghost": (curved.ghost, 0.065, 0.08, 5.956e-5),
    "Die": (curved.die, 0.06, 0.12, 1.737e-4),
    "Snowman": (planes.snowman, None, None, 4.822e-5),
    "Barrel": (planes.barrel, None, None, 2.785e-5),
    "Falcon": (curved.falcon, 0.027, 0.055, 4.234e-6),
    "Part": (planes.part, None, None, 5.045e-6),
    "Cube": (planes.cube, None, None, 1.252e-6),
    "World": (curved.world, 0.02, 0.2, 5.871e-6),
    "Pot": (curved.pot, 0.022, 0.05, 2.75e-6),
}


class NoMesh(Exception):
    pass


def tetrahedralize(surface, bound, folder):
    """Vertices, tetrahedra, boundary triangles, from 0. -O0/0 is no optimization; p keeps the surface, splitting it at will."""
    surface.write(folder / "shape.poly")
    command = ["tetgen", f"-pq1.4a{bound:.6g}O0/0z", "shape.poly"]
    result = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode != 0 or not (folder / "shape.1.ele").exists():
        raise NoMesh(f"{' '.join(command)}: {result.stdout[-300:].strip()}")
    points = read_rows(folder / "shape.1.node", 4, float)[:, 1:]
    tets = read_rows(folder / "shape.1.ele", 5, int)[:, 1:]
    triangles = read_rows(folder / "shape.1.face", 5, int)[:, 3:0:-1]  # TetGen's are turned inwards
    for file in folder.glob("shape.1.*"):
        file.unlink()
    return points, tets, triangles


def read_rows(path, columns, kind):
    with open(path) as file:
        rows, first = int(file.readline().split()[0]), file.tell()
        file.seek(first)
        return np.fromfile(file, kind, rows * columns, sep=" ").reshape(rows, columns)


def count_flat(points, tets):
    """Tetrahedra whose volume is rounding. Chance and symmetry make a few, on which a method that moves all vertices by one
    step is stuck from the start."""
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    volume = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6
    size = np.max([np.linalg.norm(x - y, axis=1) for x, y in ((a, b), (a, c), (a, d), (b, c), (b, d), (c, d))], axis=0)
    return np.count_nonzero(volume < 1e-7 * size ** 3)


def search(surface, bound, target, folder, tries=16):
    """Searches for the volume bound that gives the target within 3 % and no flat tetrahedra: secants of the count's logarithm.
    Returns the best mesh and its bound; None where the surface has no mesh."""
    best, best_bound, best_badness, last, slope = None, None, math.inf, None, -0.9
    largest = np.ptp(surface.points, axis=0).prod()  # no tetrahedron is so large: at this bound only the surface counts
    for k in range(tries):
        try:
            mesh = tetrahedralize(surface, bound, folder)
        except NoMesh as error:
            print(f"  {error}", file=sys.stderr)
            if best is None and k == 1:
                break  # other bounds fail as well: the fault is the surface's
            bound *= 0.97
            continue
        count, flat = len(mesh[1]), count_flat(*mesh[:2])
        print(f"  bound {bound:.6g}: {count} tetrahedra, {flat} flat, target {target:.0f}", file=sys.stderr)
        near = abs(count / target - 1) <= 0.03
        badness = abs(math.log(count / target)) + 0.05 * bool(flat)
        if badness < best_badness:
            best, best_bound, best_badness = mesh, bound, badness
        if near and not flat or count > target and bound >= largest:
            break
        if near:
            bound = float(f"{bound * 0.995:.4g}")
            continue
        if last and last[0] != bound:
            slope = min(max(math.log(count / last[1]) / math.log(bound / last[0]), -1.5), -0.15)
        last = bound, count
        bound *= min(max((target / count) ** (1 / slope), 0.05), 20)
        bound = min(float(f"{bound:.4g}"), largest)
    return best, best_bound


def write_meshb(path, points, tets, triangles):
    """MEDIT binary, version 2: doubles, 32-bit integers and positions. Boundary triangles have tag 1, all else 0."""
    vertex = np.zeros(len(points), [("x", "<f8", 3), ("tag", "<i4")])
    vertex["x"] = points
    triangle = np.column_stack([triangles + 1, np.ones(len(triangles), int)]).astype("<i4")
    tet = np.column_stack([tets + 1, np.zeros(len(tets), int)]).astype("<i4")
    with open(path, "wb") as file:
        np.array([1, 2, 3, file.tell() + 20, 3], "<i4").tofile(file)  # byte order, version; dimension
        for keyword, rows in ((4, vertex), (6, triangle), (8, tet)):
            np.array([keyword, file.tell() + 12 + rows.nbytes, len(rows)], "<i4").tofile(file)
            rows.tofile(file)
        np.array([54, 0], "<i4").tofile(file)


def make_mesh(name, target, scale, force_search, folder):
    """With the bound of the table, or a search where there is none or it misses the count."""
    maker, edge, coarsest, bound = SHAPES[name]
    for finer in (1, 0.9, 0.8):  # where edges are long for the details, the surface may cut itself
        surface = maker() if edge is None else maker(finer * min(edge * scale ** (-1 / 3), coarsest))
        if scale == 1 and not force_search:
            mesh = tetrahedralize(surface, bound, folder)
            if abs(len(mesh[1]) / target - 1) <= TOLERANCE:
                return mesh
            print(f"  {name}: {len(mesh[1])} tetrahedra with the bound of the table; searching", file=sys.stderr)
        mesh, found = search(surface, bound / scale, target, folder)
        if mesh is not None:
            print(f"  {name}: bound {found:.6g}", file=sys.stderr)
            return mesh
    raise NoMesh(f"{name}: TetGen makes no mesh")


def make(name, out, scale, force_search):
    """Makes one file, unless it is there; returns its row of the table and whether it is as it should be."""
    target = published.TABLE_1[name][0] * scale
    path = out / f"{name}.meshb"
    if force_search or not path.exists():
        with tempfile.TemporaryDirectory() as folder:
            mesh = make_mesh(name, target, scale, force_search, pathlib.Path(folder))
        write_meshb(path.with_suffix(".tmp"), *mesh)
        path.with_suffix(".tmp").rename(path)
    info = harness.info(path)
    count, quality = info["counts"]["tetrahedra"], info["quality"]
    difference = count / target - 1
    fewest = scale < 1 and difference > TOLERANCE  # the surface alone needs more than the target
    good = info["validity"]["valid"] and (abs(difference) <= TOLERANCE or fewest)
    findings = "yes" if info["validity"]["valid"] else f"NO: {info['validity']['findings']}"
    return (f"| {name} | {info['counts']['vertices']} | {count} | {target:.0f} | {100 * difference:+.1f} %"
            f"{', the fewest' if fewest else ''} | {quality['dihedral_min_deg']:.3f} "
            f"| {quality['dihedral_5_percent_deg']:.2f} | {findings} |"), good


def main():
    parser = argparse.ArgumentParser(prog="make", description=__doc__)
    parser.add_argument("out", type=pathlib.Path, help="folder for NAME.meshb; those that are there stay")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"default all: {' '.join(SHAPES)}")
    parser.add_argument("--scale", type=float, default=1, help="of the number of tetrahedra; 0.02 or more; default 1")
    parser.add_argument("--search", action="store_true", help="search for the volume bound in place of the table's")
    args = parser.parse_args()
    unknown = [n for n in args.names if n not in SHAPES]
    if unknown:
        parser.error(f"no such shape: {', '.join(unknown)}; there are {', '.join(SHAPES)}")
    if not harness.TETUNE.exists():
        parser.error("tetune is not built: cmake --preset release && cmake --build --preset release")
    args.out.mkdir(parents=True, exist_ok=True)
    scaled = "" if args.scale == 1 else f" x {args.scale:g}"
    print(f"| mesh | vertices | \\|T\\| | paper{scaled} | difference | phi min | phi 5 % | valid |")
    print("|---|---|---|---|---|---|---|---|")
    bad = []
    for name in args.names or SHAPES:
        try:
            row, good = make(name, args.out, args.scale, args.search)
        except NoMesh as error:
            row, good = f"| {name} | - | - | - | - | - | - | {error} |", False
        print(row, flush=True)
        if not good:
            bad.append(name)
    if bad:
        sys.exit(f"not as they should be: {', '.join(bad)}; delete a mesh to have it made again")


if __name__ == "__main__":
    main()
