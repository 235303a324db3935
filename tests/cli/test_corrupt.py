# SPDX-License-Identifier: Apache-2.0
"""Damaged variants of a small mesh in each format: refused with exit code 2 and a message that names the file (and the
place, by tetune's own readers), with nothing written and memory bounded; or still a mesh, which is optimized.

Run: see cli_case.py. $TETUNE_CORRUPT is the number of variants of each format; by default it is fewer for formats
through VTK and Gmsh, whose start takes longer.
"""

import os
import random
import re
import struct
import subprocess
import threading
from concurrent.futures import ThreadPoolExecutor

import cli_case
from cli_case import CliTest, cube

VARIANTS = int(os.environ.get("TETUNE_CORRUPT", "0"))
OWN_VARIANTS, PLUGIN_VARIANTS = VARIANTS or 100, VARIANTS or 8
# Limits on the memory of a process: beyond that for the sound file, and in all where it starts VTK or Gmsh.
OWN_MEMORY_KB = 32 << 10
PLUGIN_MEMORY_KB = 300_000

WORDS = ("nan", "-inf", "1e400", "-1", "0", "1", "4", "999999999", "2147483647", "2147483648", "4294967296",
         "9223372036854775807", "99999999999999999999", "half", "0x10", "1.5", "--2", "\u00e9", "$", "<", "#")
PATTERNS = [struct.pack(f, x) for f, x in (
    ("<i", -1), ("<i", 0), ("<i", 1), ("<i", 7), ("<i", 2**31 - 1), (">i", 2**31 - 1), ("<i", -2**31), ("<I", 2**30),
    ("<q", 2**62), (">q", 2**40), ("<q", -1), ("<d", float("nan")), ("<d", float("inf")), ("<d", -1e308),
    (">d", float("nan")), ("<f", float("nan")))]


def damaged_text(rng, whole):
    """One way a text goes wrong."""
    text = whole.decode("latin-1")
    lines = text.split("\n")
    kind = rng.randrange(7)
    if kind == 0:
        return whole[:rng.randrange(len(whole))]
    if kind == 1:  # a line too few, too many, or elsewhere
        at = rng.randrange(len(lines))
        line = lines.pop(at)
        for _ in range(rng.choice((0, 1, 2))):
            lines.insert(rng.randrange(len(lines) + 1), line)
        return "\n".join(lines).encode("latin-1")
    if kind == 2:
        at = rng.randrange(len(whole))
        return whole[:at] + rng.randbytes(rng.randrange(1, 40)) + whole[at:]
    # Another word for a number; the few in lines of counts as often as the many others.
    counts = [m for line in re.finditer(r"^[^\n.]*$", text, re.M) if len(line[0]) < 30
              for m in re.finditer(r"\d+", line[0]) for m in [(line.start() + m.start(), line.start() + m.end())]]
    numbers = counts if counts and kind < 5 else [m.span() for m in re.finditer(r"[\d.eE+-]*\d", text)]
    begin, end = rng.choice(numbers)
    return (text[:begin] + rng.choice(WORDS) + text[end:]).encode("utf-8")


def damaged_bytes(rng, whole):
    """The same of a binary file, whose head and tail are hit more often."""
    kind = rng.randrange(6)
    at = rng.randrange(min(len(whole), 1200)) if kind < 3 else rng.randrange(len(whole))
    if kind == 5:
        return whole[:at]
    if kind == 4:
        return whole[:at] + whole[at + rng.randrange(1, 100):]
    new = rng.choice(PATTERNS) if rng.random() < 0.8 else rng.randbytes(rng.randrange(1, 9))
    at -= at % 4 if rng.random() < 0.7 else 0
    return whole[:at] + new + whole[at + len(new):]


def rows(items, first=1):
    return "".join(f"{i + first} {row}\n" for i, row in enumerate(items))


def numbers(values, shift=0):
    return " ".join(str(v + shift) for v in values)


def tetgen(mesh):
    node = f"{len(mesh.points)} 3 0 1\n" + rows(f"{numbers(p)} {t}" for p, t in zip(mesh.points, mesh.point_tags))
    ele = f"{len(mesh.tets)} 4 1\n" + rows(f"{numbers(t, 1)} 3" for t in mesh.tets)
    face = f"{len(mesh.boundary_faces())} 1\n" + rows(f"{numbers(f, 1)} 2" for f in sorted(mesh.boundary_faces()))
    return {".node": node, ".ele": ele, ".face": face}


def msh2(mesh, binary):
    head = f"$MeshFormat\n2.2 {int(binary)} 8\n".encode()
    n, m = len(mesh.points), len(mesh.tets)
    if not binary:
        return head + (f"$EndMeshFormat\n$Nodes\n{n}\n{rows(map(numbers, mesh.points))}$EndNodes\n$Elements\n{m}\n"
                       + rows(f"4 2 3 3 {numbers(t, 1)}" for t in mesh.tets) + "$EndElements\n").encode()
    nodes = b"".join(struct.pack("<i3d", i + 1, *p) for i, p in enumerate(mesh.points))
    tets = b"".join(struct.pack("<7i", i + 1, 3, 3, *(v + 1 for v in t)) for i, t in enumerate(mesh.tets))
    return (head + struct.pack("<i", 1) + b"\n$EndMeshFormat\n$Nodes\n%d\n" % n + nodes + b"\n$EndNodes\n$Elements\n%d\n"
            % m + struct.pack("<3i", 4, m, 2) + tets + b"\n$EndElements\n")


def msh4(mesh):
    n, m = len(mesh.points), len(mesh.tets)
    return (f"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 1 3 0\n$EndEntities\n"
            f"$Nodes\n1 {n} 1 {n}\n3 1 0 {n}\n" + "".join(f"{i + 1}\n" for i in range(n))
            + "".join(f"{numbers(p)}\n" for p in mesh.points)
            + f"$EndNodes\n$Elements\n1 {m} 1 {m}\n3 1 4 {m}\n" + rows(numbers(t, 1) for t in mesh.tets)
            + "$EndElements\n").encode()


def vtk(mesh):
    n, m = len(mesh.points), len(mesh.tets)
    return (f"# vtk DataFile Version 3.0\ncube\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {n} double\n"
            + "".join(f"{numbers(p)}\n" for p in mesh.points) + f"CELLS {m} {5 * m}\n"
            + "".join(f"4 {numbers(t)}\n" for t in mesh.tets) + f"CELL_TYPES {m}\n" + "10\n" * m
            + f"POINT_DATA {n}\nSCALARS heat double 1\nLOOKUP_TABLE default\n" + "0.5\n" * n).encode()


def vtu(mesh):
    def array(kind, name, values, more=""):
        return f'<DataArray type="{kind}" Name="{name}" format="ascii"{more}>\n{values}\n</DataArray>\n'
    m = len(mesh.tets)
    return ('<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>\n'
            f'<Piece NumberOfPoints="{len(mesh.points)}" NumberOfCells="{m}"><Points>\n'
            + array("Float64", "Points", "\n".join(map(numbers, mesh.points)), ' NumberOfComponents="3"')
            + "</Points><Cells>\n" + array("Int64", "connectivity", "\n".join(map(numbers, mesh.tets)))
            + array("Int64", "offsets", numbers(range(4, 4 * m + 1, 4))) + array("UInt8", "types", "10 " * m)
            + "</Cells></Piece></UnstructuredGrid></VTKFile>\n").encode()


class Corrupt(CliTest):
    def start(self, *arguments):
        """Exit code, standard output and error, and the most memory of the process and its plugin, in kB."""
        with subprocess.Popen([cli_case.TETUNE, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            limit = threading.Timer(cli_case.HANG, process.kill)
            limit.start()
            out, error = (stream.read().decode("utf-8", "replace") for stream in (process.stdout, process.stderr))
            _, status, usage = os.wait4(process.pid, 0)
            limit.cancel()
            process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, out, error, usage.ru_maxrss

    def attempt(self, folder, name, files, memory_kb):
        """The outcome: "refused", "optimized", or what is wrong."""
        place = self.folder / folder
        place.mkdir()
        for file, content in files.items():
            (place / file).write_bytes(content)
        (place / "out.meshb").write_bytes(b"old")
        before = sorted(os.listdir(place))
        code, out, error, peak = self.start("optimize", str(place / name), "-o", str(place / "out.meshb"), "--threads", "1",
                                            "--max-iterations", "2")
        written = (place / "out.meshb").read_bytes()
        wrong = []
        if peak > memory_kb:
            wrong.append(f"{peak} kB of memory, {memory_kb} allowed")
        if sorted(os.listdir(place)) != before:
            wrong.append(f"left {os.listdir(place)}")
        if code == 2:
            if out or written != b"old":
                wrong.append("the output was touched")
            at = max(files, key=lambda f: error.count(str(place / f)))
            if str(place / at) not in error:
                wrong.append("the message does not name the file")
            elif memory_kb < PLUGIN_MEMORY_KB and not re.search(
                    re.escape(str(place / at)) + r"(:\d+: |, byte \d+: |: the mesh is not valid|: there is no tetrahedron)", error):
                wrong.append("the message does not name the place")
        elif code == 0:
            if self.start("info", "--check", str(place / "out.meshb"))[0] != 0:
                wrong.append("the result is not valid")
        else:
            wrong.append(f"exit code {code}")
        return "; ".join(wrong + [error.strip()]) if wrong else ("refused" if code == 2 else "optimized")

    def check(self, name, files, damage, count, own=False):
        """Variants of the file `name` with others beside it."""
        whole = files[name]
        place = self.folder / "whole"
        place.mkdir()
        for file, content in files.items():
            (place / file).write_bytes(content)
        code, _, error, peak = self.start("optimize", str(place / name), "-o", str(place / "out.meshb"), "--threads", "1")
        self.assertEqual(code, 0, error)
        memory_kb = peak + OWN_MEMORY_KB if own else PLUGIN_MEMORY_KB

        def one(seed):
            rng = random.Random(seed)
            return self.attempt(str(seed), name, {**files, name: damage(rng, whole)}, memory_kb)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            results = list(pool.map(one, range(count)))
        wrong = [f"seed {seed}: {r}" for seed, r in enumerate(results) if r not in ("refused", "optimized")]
        self.assertEqual(wrong, [], "\n".join(wrong))
        # The damage is at places that matter.
        self.assertGreater(results.count("refused"), count / 10)
        if VARIANTS:
            print(f"\n{name}: {results.count('refused')} of {count} refused", flush=True)

    def by_tetune(self, name):
        """The mesh in another format."""
        code, _, error, _ = self.start("optimize", self.put("in.mesh", cube(3)), "-o", self.path(name), "--threads", "1")
        self.assertEqual(code, 0, error)
        return self.read_bytes(name)

    def plugin(self, name, whole, damage, program):
        if not cli_case.has_plugin(program):
            self.skipTest(f"built without {program}")
        self.check(name, {name: whole() if callable(whole) else whole}, damage, PLUGIN_VARIANTS)

    def test_medit_text(self):
        self.check("a.mesh", {"a.mesh": cube(3).text().encode()}, damaged_text, OWN_VARIANTS, own=True)

    def test_medit_binary(self):
        self.check("a.meshb", {"a.meshb": self.by_tetune("a.meshb")}, damaged_bytes, OWN_VARIANTS, own=True)

    def test_tetgen(self):
        files = {"a" + ending: text.encode() for ending, text in tetgen(cube(3)).items()}
        for name in files:
            with self.subTest(name):
                self.check(name, files, damaged_text, -(-OWN_VARIANTS // 3), own=True)
                for folder in self.folder.iterdir():
                    folder.rename(folder.with_name(f"{name}_{folder.name}"))

    def test_msh_2_text(self):
        self.check("a.msh", {"a.msh": msh2(cube(3), False)}, damaged_text, OWN_VARIANTS, own=True)

    def test_msh_2_binary(self):
        self.check("a.msh", {"a.msh": msh2(cube(3), True)}, damaged_bytes, OWN_VARIANTS, own=True)

    def test_msh_4_text(self):
        self.check("a.msh", {"a.msh": msh4(cube(3))}, damaged_text, OWN_VARIANTS, own=True)

    def test_msh_4_binary(self):
        self.check("a.msh", {"a.msh": self.by_tetune("a.msh")}, damaged_bytes, OWN_VARIANTS, own=True)

    def test_unv(self):
        self.check("a.unv", {"a.unv": self.by_tetune("a.unv")}, damaged_text, OWN_VARIANTS, own=True)

    def test_bdf(self):
        self.check("a.bdf", {"a.bdf": self.by_tetune("a.bdf")}, damaged_text, OWN_VARIANTS, own=True)

    def test_vtk_text(self):
        self.plugin("a.vtk", vtk(cube(3)), damaged_text, "tetune-vtk")

    def test_vtk_binary(self):
        self.plugin("a.vtk", lambda: self.by_tetune("a.vtk"), damaged_bytes, "tetune-vtk")

    def test_vtu_text(self):
        self.plugin("a.vtu", vtu(cube(3)), damaged_text, "tetune-vtk")

    def test_vtu_appended(self):
        self.plugin("a.vtu", lambda: self.by_tetune("a.vtu"), damaged_bytes, "tetune-vtk")

    def test_exodus(self):
        self.plugin("a.e", lambda: self.by_tetune("a.e"), damaged_bytes, "tetune-vtk")


if __name__ == "__main__":
    cli_case.main(__doc__)
