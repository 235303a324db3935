# SPDX-License-Identifier: Apache-2.0
"""Shared by the tests of the command line: meshes, and a case that runs tetune as a process.

Run a file of tests:  python3 test_optimize.py path/to/tetune [names of tests]
"""

import functools
import math
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

TETUNE = ""
HANG = 300  # seconds: more than a process of these tests takes, also on a busy machine

# Jobs in the background of a shell ignore it, and so do the processes that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

QUALITY_KEYS = {"tetrahedra", "dihedral_min_deg", "dihedral_1_percent_deg", "dihedral_5_percent_deg",
                "dihedral_mean_deg", "dihedral_max_deg", "eta_max", "eta_95_percent", "eta_sum", "shape_sum", "mean_ratio",
                "mean_ratio_min", "volume", "worst_tetrahedron", "dihedral_histogram_10_deg", "measures", "worst"}
MEASURES = ["min_dihedral_deg", "max_dihedral_deg", "mean_ratio", "sicn", "gamma", "scaled_jacobian", "radius_ratio",
            "aspect_ratio", "q_h"]


class Mesh:
    """Vertices and tetrahedra (counted from 0) with their tags."""

    def __init__(self, points, tets, point_tags=None, tet_tags=None):
        self.points = points
        self.tets = tets
        self.point_tags = point_tags or [0] * len(points)
        self.tet_tags = tet_tags or [0] * len(tets)

    def text(self):
        lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(self.points))]
        lines += [" ".join(map(repr, p)) + f" {t}" for p, t in zip(self.points, self.point_tags)]
        lines += ["Tetrahedra", str(len(self.tets))]
        lines += [" ".join(str(v + 1) for v in tet) + f" {t}" for tet, t in zip(self.tets, self.tet_tags)]
        return "\n".join(lines + ["End", ""])

    @staticmethod
    def read(path):
        words = Path(path).read_text().split()

        def section(name, each, number):
            at = words.index(name) + 1
            values = words[at + 1:at + 1 + int(words[at]) * (each + 1)]
            rows = [values[i:i + each + 1] for i in range(0, len(values), each + 1)]
            return [tuple(map(number, r[:each])) for r in rows], [int(r[each]) for r in rows]

        points, point_tags = section("Vertices", 3, float)
        tets, tet_tags = section("Tetrahedra", 4, lambda w: int(w) - 1)
        return Mesh(points, tets, point_tags, tet_tags)

    def volumes(self):
        def volume(tet):
            p, q, r, s = (self.points[v] for v in tet)
            a, b, c = ([x - y for x, y in zip(v, p)] for v in (q, r, s))
            return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                    + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
        return [volume(tet) for tet in self.tets]

    def volume_of(self, tag):
        return sum(volume for volume, t in zip(self.volumes(), self.tet_tags) if t == tag)

    def smallest_angle(self):
        """Between two faces of a tetrahedron, in degrees."""
        def dot(a, b):
            return sum(x * y for x, y in zip(a, b))

        def angle(p, q, r, s):  # at the edge from p to q
            along, u, v = (tuple(x - y for x, y in zip(to, p)) for to in (q, r, s))
            u, v = (tuple(x - dot(w, along) / dot(along, along) * y for x, y in zip(w, along)) for w in (u, v))
            return math.degrees(math.acos(max(-1.0, min(1.0, dot(u, v) / math.sqrt(dot(u, u) * dot(v, v))))))

        return min(angle(*(self.points[tet[i]] for i in order)) for tet in self.tets
                   for order in ((0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)))

    def boundary_faces(self):
        count = {}
        for a, b, c, d in self.tets:
            for face in ((a, b, c), (a, b, d), (a, c, d), (b, c, d)):
                key = tuple(sorted(face))
                count[key] = count.get(key, 0) + 1
        assert max(count.values()) <= 2, "a face on three tetrahedra"
        return {face for face, n in count.items() if n == 1}


def cube(n, jitter=0.2, seed=1, two_regions=False):
    """n^3 cells of six tetrahedra in the unit cube; inner vertices are displaced; five tags of vertices. Two regions meet
    in a plane, in which its vertices stay."""
    rng = random.Random(seed)
    points = []
    for k in range(n + 1):
        for j in range(n + 1):
            for i in range(n + 1):
                p = [c / n + (jitter * rng.uniform(-1, 1) / n if 0 < c < n else 0.0) for c in (i, j, k)]
                if two_regions and k == n // 2:
                    p[2] = k / n
                points.append(tuple(p))

    def vertex(at):
        return (at[2] * (n + 1) + at[1]) * (n + 1) + at[0]

    tets, tags = [], []
    for cell in range(n ** 3):
        corner = [cell % n, cell // n % n, cell // n ** 2]
        for path in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
            at = list(corner)
            tet = [vertex(at)]
            for axis in path:
                at[axis] += 1
                tet.append(vertex(at))
            if path in ((0, 2, 1), (2, 1, 0), (1, 0, 2)):
                tet[2], tet[3] = tet[3], tet[2]
            tets.append(tuple(tet))
            tags.append(4 if two_regions and corner[2] < n // 2 else 3)
    return Mesh(points, tets, [i % 5 for i in range(len(points))], tags)


def layer(n, thickness):
    """The lowest n x n cells of cube(n), of another thickness; the same displacements of inner vertices on both sides."""
    whole = cube(n, jitter=0)
    count = (n + 1) ** 2
    shift = random.Random(1)
    bottom = [(x + shift.uniform(-0.2, 0.2) / n, y + shift.uniform(-0.2, 0.2) / n) if 0 < x < 1 and 0 < y < 1 else (x, y)
              for x, y, _ in whole.points[:count]]
    tets = [tet for tet in whole.tets if max(tet) < 2 * count]
    points = [(x, y, z) for z in (0, thickness) for x, y in bottom]
    return Mesh(points, tets, [0] * len(points), [1] * len(tets))


# Valid, and folded over itself: a 2-3 flip of two of them makes a face of the first a second time.
OVERLAPPING = """MeshVersionFormatted 2
Dimension 3
Vertices 8
0 0 0 0
1 0 0 0
0 1 0 0
1 1 0 0
0 0 1 0
1 0 1 0
0 1 1 0
2 1 5 0
Tetrahedra 5
1 2 3 6 0
4 3 2 8 0
6 2 5 8 0
7 5 3 8 0
2 3 5 8 0
End
"""


def tangled(n):
    """A cube with an inner vertex far outside."""
    mesh = cube(n)
    middle = (len(mesh.points) - 1) // 2
    mesh.points[middle] = (5, 5, 5)
    return mesh


def unflipped(mesh):
    """The same shape with pairs of tetrahedra replaced by three around a new edge, where that is possible."""
    owners = {}
    for t, tet in enumerate(mesh.tets):
        for v in tet:
            owners.setdefault(tuple(sorted(set(tet) - {v})), []).append((t, v))
    gone, new, tags = set(), [], []
    for (a, b, c), sides in owners.items():
        if len(sides) < 2 or gone & {t for t, _ in sides} or len({mesh.tet_tags[t] for t, _ in sides}) > 1:
            continue
        top, bottom = (v for _, v in sides)
        three = Mesh(mesh.points, [(a, b, bottom, top), (b, c, bottom, top), (c, a, bottom, top)])
        if max(three.volumes()) < -1e-4:
            three.tets = [(y, x, v, w) for x, y, v, w in three.tets]
        if min(three.volumes()) > 1e-4:
            gone |= {t for t, _ in sides}
            new += three.tets
            tags += [mesh.tet_tags[sides[0][0]]] * 3
    kept = [t for t in range(len(mesh.tets)) if t not in gone]
    return Mesh(mesh.points, [mesh.tets[t] for t in kept] + new, mesh.point_tags, [mesh.tet_tags[t] for t in kept] + tags)


def bent(mesh, height=0.1):
    """Waves in the z direction: the top and the bottom of the cube are curved."""
    points = [(x, y, z + height * math.sin(5 * x + 1) * math.cos(4 * y)) for x, y, z in mesh.points]
    return Mesh(points, mesh.tets, mesh.point_tags, mesh.tet_tags)


def with_triangles(mesh, triangles):
    """The text of a mesh with listed triangles (counted from 0) and their tags."""
    lines = ["Triangles", str(len(triangles))] + [" ".join(str(v + 1) for v in t) + f" {tag}" for t, tag in triangles]
    return mesh.text().replace("End", "\n".join(lines + ["End"]))


def msh_text(points, elements, names="", data=""):
    """A file of Gmsh, version 2.2. Each element has its type, its group and its nodes, counted from 0; `names` and `data`:
    the sections before and after the mesh."""
    nodes = "".join(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(points, 1))
    rows = "".join(f"{i} {kind} 2 {group} {group} " + " ".join(str(v + 1) for v in nodes_of_one) + "\n"
                   for i, (kind, group, nodes_of_one) in enumerate(elements, 1))
    return (f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{names}$Nodes\n{len(points)}\n{nodes}$EndNodes\n"
            f"$Elements\n{len(elements)}\n{rows}$EndElements\n{data}")


def vtk_bytes(points, tets, fields):
    """A legacy VTK file; `fields`: name and rows of point data with three or one components. Binary, as VTK reads no NaN in
    text."""
    def numbers(code, rows):
        flat = [x for row in rows for x in row]
        return struct.pack(f">{len(flat)}{code}", *flat) + b"\n"

    parts = ["# vtk DataFile Version 3.0\nx\nBINARY\nDATASET UNSTRUCTURED_GRID\n",
             f"POINTS {len(points)} double\n", numbers("d", points),
             f"CELLS {len(tets)} {5 * len(tets)}\n", numbers("i", [(4, *t) for t in tets]),
             f"CELL_TYPES {len(tets)}\n", numbers("i", [(10,)] * len(tets)), f"POINT_DATA {len(points)}\n"]
    for name, rows in fields:
        kind = f"VECTORS {name} double\n" if len(rows[0]) == 3 else f"SCALARS {name} double 1\nLOOKUP_TABLE default\n"
        parts += [kind, numbers("d", rows)]
    return b"".join(part if isinstance(part, bytes) else part.encode() for part in parts)


def start_and_kill(words, started):
    """Starts a process with its standard error in a pipe, and kills it when started(process) returns. Waits until its
    plugin has ended too."""
    # A plugin's program ends soon after tetune: then no process holds the other end of this pipe any more.
    alive, held = os.pipe()
    with subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, pass_fds=[held]) as process:
        os.close(held)
        started(process)
        process.kill()
    os.read(alive, 1)
    os.close(alive)


def has_plugin(name):
    return (Path(TETUNE).parent / "../libexec/tetune" / name).is_file()


def needs_vtk(test):
    """Skips a test where tetune was built without the plugin for VTK's formats, as for other systems than Linux."""
    @functools.wraps(test)
    def wrapped(self, *args):
        if not has_plugin("tetune-vtk"):
            self.skipTest("built without VTK: install libvtk9-dev")
        return test(self, *args)
    return wrapped


def can_mount():
    return shutil.which("unshare") is not None and subprocess.run(
        ["unshare", "-rm", "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True).returncode == 0


def needs_mount(test):
    return unittest.skipUnless(
        can_mount(), "SKIPPED, NOT TESTED: no permission to mount a file system of its own (unshare -rm)")(test)


class CliTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="tetune_cli_"))
        # A process that a test killed may still be writing there.
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return str(self.folder / name)

    def put(self, name, content):
        Path(self.path(name)).write_text(content.text() if isinstance(content, Mesh) else content)
        return self.path(name)

    def read_bytes(self, name):
        return Path(self.path(name)).read_bytes()

    def files(self):
        return sorted(os.listdir(self.folder))

    def run_cli(self, *args, code=0, **more):
        done = subprocess.run([TETUNE, *map(str, args)], capture_output=True, text=True, timeout=HANG, **more)
        self.assertEqual(done.returncode, code, f"{args}\n{done.stdout}\n{done.stderr}")
        return done

    def refused(self, *args, said=(), **more):
        """Exit code 2, a message on the standard error, nothing on the standard output."""
        done = self.run_cli(*args, code=2, **more)
        self.assertEqual(done.stdout, "")
        for part in said:
            if part not in done.stderr.replace("\\", "/"):  # in names of Windows
                self.assertIn(part, done.stderr)
        return done

    def assert_improved(self, before, after):
        self.assertEqual(len(after.points), len(before.points))
        self.assertEqual(after.point_tags, before.point_tags)
        self.assertEqual(set(after.tet_tags), set(before.tet_tags))
        self.assertGreater(min(after.volumes()), 0)
        self.assertGreater(after.smallest_angle(), before.smallest_angle())
        for tag in set(before.tet_tags):
            self.assertAlmostEqual(after.volume_of(tag), before.volume_of(tag), places=12)
        self.assertEqual(len({tuple(sorted(t)) for t in after.tets}), len(after.tets))
        after.boundary_faces()


def main(doc):
    global TETUNE
    if len(sys.argv) < 2:
        sys.exit(doc)
    TETUNE = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=1)
