# SPDX-License-Identifier: Apache-2.0
"""tetune move: targets in files, what is written, and exit codes. Run: see cli_case.py."""

import json
import math
import os
import re
import signal
import struct
import subprocess
from pathlib import Path

import cli_case
from cli_case import CliTest, Mesh, cube, msh_text, needs_vtk, vtk_bytes, with_triangles


def on_side(point):
    return any(x in (0, 1) for x in point)


def moved(mesh, function):
    return Mesh([function(p) for p in mesh.points], mesh.tets, mesh.point_tags, mesh.tet_tags)


def stretched(mesh):
    return moved(mesh, lambda p: (1.5 * p[0], p[1], p[2]))


class Moves(CliTest):
    def setUp(self):
        super().setUp()
        self.mesh = cube(5)
        self.source = self.put("in.mesh", self.mesh)

    def move(self, *words, code=0):
        done = self.run_cli("move", self.source, "-o", self.path("out.mesh"), *words, "--report", self.path("r.json"), code=code)
        after = Mesh.read(self.path("out.mesh"))
        self.assertGreater(min(after.volumes()), 0)
        after.boundary_faces()
        self.assertEqual(after.point_tags, self.mesh.point_tags)
        with open(self.path("r.json")) as file:
            return after, json.load(file)["motion"], done.stdout

    def vtk(self, name, values, field="u"):
        """A file with a field of three components per vertex."""
        Path(self.path(name)).write_bytes(vtk_bytes(self.mesh.points, self.mesh.tets, [(field, values)]))
        return self.path(name)

    def test_to_the_surface_of_a_second_mesh(self):
        target = stretched(self.mesh)
        after, motion, out = self.move("--to", self.put("to.mesh", target))
        self.assertEqual((motion["targets"], motion["targets_reached"], motion["fraction"]), (1, 1, 1))
        self.assertIn("to 1 of 1 targets", out)
        surface = [v for v, p in enumerate(self.mesh.points) if on_side(p)]
        self.assertEqual(motion["vertices_prescribed"], len(surface))
        for v in surface:
            self.assertEqual(after.points[v], target.points[v])
        self.assertNotEqual(after.points, target.points)
        self.assertAlmostEqual(sum(after.volumes()), 1.5)
        self.assertEqual(motion["steps"][-1]["fraction"], 1)

    def test_all_vertices(self):
        target = stretched(self.mesh)
        after, motion, _ = self.move("--to", self.put("to.mesh", target), "--all-vertices", "--effort", "fast")
        self.assertEqual(after.points, target.points)
        self.assertEqual(motion["vertices_prescribed"], len(target.points))

    def test_several_targets(self):
        words = []
        for i, degrees in enumerate((20, 40, 60)):
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            turned = moved(self.mesh, lambda p: (c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]))
            words += ["--to", self.put(f"to{i}.mesh", turned)]
        after, motion, _ = self.move(*words)
        self.assertEqual(motion["targets_reached"], 3)
        self.assertAlmostEqual(sum(after.volumes()), 1)
        for p, q in zip(self.mesh.points, after.points):
            if on_side(p):
                self.assertEqual(q, (c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]))

    @needs_vtk
    def test_displacement_with_vertices_that_follow(self):
        nan = math.nan
        piston = [(-0.4, 0.0, 0.0) if p[0] == 1 else (0.0, 0.0, 0.0) if p[0] == 0 else (nan, nan, nan) for p in self.mesh.points]
        after, motion, _ = self.move("--to", self.vtk("to.vtk", piston), "--displacement", "u")
        self.assertEqual(motion["vertices_prescribed"], 2 * 6 * 6)
        for p, q in zip(self.mesh.points, after.points):
            if p[0] in (0, 1):
                self.assertEqual(q, (p[0] + (-0.4 if p[0] == 1 else 0.0), p[1], p[2]))
            self.assertTrue(all(b == a for a, b in zip(p[1:], q[1:]) if a in (0, 1)))
        self.assertAlmostEqual(sum(after.volumes()), 0.6)

    @needs_vtk
    def test_displacement_with_nan_in_one_component(self):
        shifted = [(0.0, math.nan if i == 7 else 0.0, 0.0) for i in range(len(self.mesh.points))]
        self.refused("move", self.source, "-o", self.path("out.mesh"), "--to", self.vtk("to.vtk", shifted), "--displacement", "u",
                     said=['--displacement "u": vertex 7 of', "NaN in 1 of its three components"])

    @needs_vtk
    def test_displacement_of_the_input(self):
        self.source = self.vtk("in.vtk", [(0.0, 0.25 * p[1], 0.0) for p in self.mesh.points])
        self.run_cli("move", self.source, "-o", self.path("out.mesh"), "--displacement", "u", "--quiet")
        self.assertAlmostEqual(sum(Mesh.read(self.path("out.mesh")).volumes()), 1.25)

    @needs_vtk
    def test_data_are_interpolated(self):
        """A linear field is exact at the new places, and moves with a mesh that is shifted."""
        source = self.vtk("in.vtk", [(p[0], p[1] - p[2], 2.0) for p in self.mesh.points])

        def read(name):
            head, numbers = re.split(rb"\n?u 3 216 double\n|VECTORS u double\n", self.read_bytes(name))
            return struct.iter_unpack(">3d", numbers[:24 * len(self.mesh.points)])

        self.run_cli("optimize", source, self.path("out.vtk"), "--data", "interpolate", "--quiet")
        carried = self.run_cli("optimize", source, "-o", self.path("out.mesh"))
        self.assertIn("the values of u moved with their vertices;", carried.stderr)
        self.run_cli("optimize", source, self.path("conserved.vtk"), "--data", "conserve", "--quiet")
        for name in ("out.vtk", "conserved.vtk"):
            for p, u in zip(Mesh.read(self.path("out.mesh")).points, read(name), strict=True):
                for x, y in zip(u, (p[0], p[1] - p[2], 2.0)):
                    self.assertAlmostEqual(x, y, places=12)

    def test_patches(self):
        top = next(t for t in self.mesh.tets if sum(self.mesh.points[v][2] == 1 for v in t) == 3)
        triangle = tuple(v for v in top if self.mesh.points[v][2] == 1)
        self.source = self.put("in.mesh", with_triangles(self.mesh, [(triangle, 4)]))
        to = self.put("to.mesh", moved(self.mesh, lambda p: (p[0], p[1], p[2] + 0.05)))
        after, motion, _ = self.move("--to", to, "--patches", "4")
        self.assertEqual(motion["vertices_prescribed"], 3)
        for v in triangle:
            self.assertEqual(after.points[v][2], 1.05)
        self.refused("move", self.source, self.path("x.mesh"), "--to", to, "--patches", "4,5", said=["--patches: the input has no patch 5; it has ", "4"])
        # Patches by the names of their groups.
        elements = [(2, 4, triangle), *((4, 1, tet) for tet in self.mesh.tets)]
        self.source = self.put("in.msh", msh_text(self.mesh.points, elements,
                                                  names='$PhysicalNames\n1\n2 4 "lid"\n$EndPhysicalNames\n'))
        self.mesh.point_tags = [0] * len(self.mesh.points)
        _, motion, _ = self.move("--to", to, "--patches", "lid")
        self.assertEqual(motion["vertices_prescribed"], 3)
        self.refused("move", self.source, self.path("x.mesh"), "--to", to, "--patches", "floor", said=['no patch "floor"; it has ', '4 "lid"'])

    def test_a_target_out_of_reach(self):
        mirrored = moved(self.mesh, lambda p: (1 - p[0], p[1], p[2]))
        after, motion, out = self.move("--to", self.put("to.mesh", mirrored), code=1)
        self.assertLess(motion["fraction"], 0.5)
        self.assertGreater(motion["fraction"], 0.4)
        self.assertIn("target 1: stopped after", out)
        self.assertIn("block it", out)
        self.assertTrue(motion["blocking_tetrahedra"] and motion["blocking_vertices"])
        self.assertLessEqual(max(motion["blocking_tetrahedra"]), len(after.tets))
        self.assertGreaterEqual(min(motion["blocking_vertices"]), 1)
        done = self.run_cli("move", self.source, "-o", self.path("quiet.mesh"), "--to", self.path("to.mesh"), "--quiet", code=1)
        self.assertEqual(done.stdout, "")
        self.assertIn("quiet.mesh: motion blocked at target 1, after %.4g %% of the way there: " % (100 * motion["fraction"]), done.stderr)
        self.assertEqual(self.read_bytes("quiet.mesh"), self.read_bytes("out.mesh"))

    def with_prism(self, name, height):
        """The mesh with a prism beside it."""
        n = len(self.mesh.points)
        prism = [(x + 3.0, y, z * height) for z in (0, 1) for x, y in ((0, 0), (1, 0), (0, 1))]
        text = Mesh(self.mesh.points + prism, self.mesh.tets).text()
        self.assertIn("\nEnd", text)
        words = " ".join(str(n + i) for i in range(1, 7))
        return self.put(name, text.replace("\nEnd", f"\nPrisms\n1\n{words} 0\nEnd"))

    def test_elements_of_other_kinds_that_are_inverted(self):
        source = self.with_prism("prism.mesh", 1.0)
        for height, inverted in ((0.5, []), (-0.5, [{"kind": "Prisms", "elements": [1]}])):
            done = self.run_cli("move", source, "-o", self.path("out.mesh"), "--to", self.with_prism("to.mesh", height),
                                "--report", self.path("r.json"))
            with open(self.path("r.json")) as file:
                report = json.load(file)
            self.assertEqual(report["motion"]["inverted_elements"], inverted)
            said = "the motion inverted 1 of the Prisms (first, counted from 1: 1): "
            self.assertEqual(said in done.stderr, bool(inverted))
            self.assertEqual([w.startswith(said) for w in report["warnings"]], [True] * len(inverted))
        self.assertIn("boundary closed; elements of other kinds are not checked", self.run_cli("info", self.path("out.mesh")).stdout)

    def test_frozen_vertices_that_targets_move(self):
        self.mesh.tet_tags = [1 if sum(self.mesh.points[v][0] for v in tet) < 2 else 2 for tet in self.mesh.tets]
        self.source = self.put("in.mesh", self.mesh)
        to = self.put("to.mesh", stretched(self.mesh))
        frozen = {v for tet, tag in zip(self.mesh.tets, self.mesh.tet_tags) if tag == 2 for v in tet}
        after, motion, _ = self.move("--to", to, "--freeze", "tag=2", "--all-vertices")
        self.assertEqual(motion["frozen_vertices_moved"], len(frozen))
        for v in frozen:
            self.assertEqual(after.points[v], (1.5 * self.mesh.points[v][0], *self.mesh.points[v][1:]))
        with open(self.path("r.json")) as file:
            self.assertTrue(json.load(file)["warnings"][0].startswith(f"targets move {len(frozen)} frozen vertices: "))
        _, motion, _ = self.move("--to", to)
        self.assertEqual(motion["frozen_vertices_moved"], 0)

    @needs_vtk
    def test_names_what_blocks(self):
        """One vertex is to leave the cube through a side that stays: it and tetrahedra around it are named, and its place is
        the fraction of the way that is reported."""
        v = next(i for i, p in enumerate(self.mesh.points) if max(abs(x - 0.5) for x in p) < 0.2)
        begin = self.mesh.points[v]
        targets = [p if on_side(p) else (math.nan,) * 3 for p in self.mesh.points]
        targets[v] = (1.4, *begin[1:])
        self.source = self.vtk("in.vtk", [tuple(x - y for x, y in zip(a, b)) for a, b in zip(targets, self.mesh.points)])
        self.run_cli("move", self.source, "-o", self.path("out.mesh"), "--displacement", "u", "--all-vertices", "--report",
                     self.path("r.json"), code=1)
        after = Mesh.read(self.path("out.mesh"))
        with open(self.path("r.json")) as file:
            motion = json.load(file)["motion"]
        self.assertEqual(motion["blocking_vertices"], [v + 1])
        for t in motion["blocking_tetrahedra"]:
            self.assertTrue(any(on_side(after.points[w]) for w in after.tets[t - 1]))
        self.assertGreater(min(after.volumes()), 0)
        end = after.points[v]
        self.assertAlmostEqual(end[0], begin[0] + motion["fraction"] * (1.4 - begin[0]), places=9)
        self.assertEqual(end[1:], begin[1:])
        self.assertGreater(end[0], 0.9, "it could come nearer to the side")
        self.assertLess(end[0], 1)

    def test_the_same_file_for_any_number_of_threads(self):
        to = self.put("to.mesh", stretched(self.mesh))
        for threads in "1", "3":
            self.run_cli("move", self.source, self.path(threads + ".mesh"), "--to", to, "--threads", threads, "--quiet")
        self.assertEqual(self.read_bytes("1.mesh"), self.read_bytes("3.mesh"))

    def test_refusals(self):
        to = self.put("to.mesh", stretched(self.mesh))
        small = self.put("small.mesh", cube(2))
        out = self.path("x.mesh")
        for words, said in (([], ["no target", "--to", "--displacement"]),
                            (["--to", self.path("none.mesh")], ["none.mesh"]),
                            (["--to", small], ["27 vertices", "the input has 216"]),
                            (["--displacement", "v"], ["the input has no point data of this name"]),
                            (["--to", to, "--boundary", "slide", "--max-deviation", "0.1"], ["--max-deviation bounds", "--boundary preserve"]),
                            (["--to", to, "--all-vertices", "--patches", "1"], ["exclude each other"])):
            self.refused("move", self.source, out, *words, said=said)
        self.assertFalse(os.path.exists(out))

    @needs_vtk
    def test_a_displacement_that_is_missing(self):
        one = self.vtk("one.vtk", [(0.0, 0.0, 0.0)] * len(self.mesh.points))
        self.refused("move", self.source, self.path("x.mesh"), "--to", one, "--displacement", "v",
                     said=["no point data of this name; it has: u"])

    def test_a_limit_of_memory(self):
        to = self.put("to.mesh", stretched(self.mesh))
        self.refused("move", self.source, self.path("x.mesh"), "--to", to, "--max-memory", "1", said=["needs about", "MB"])

    def test_dry_run_writes_nothing(self):
        to = self.put("to.mesh", stretched(self.mesh))
        done = self.run_cli("move", self.source, "--to", to, "--dry-run")
        self.assertIn("nothing is written", done.stdout)
        self.assertEqual(self.files(), ["in.mesh", "to.mesh"])

    def test_a_signal_leaves_a_valid_mesh(self):
        self.mesh = cube(16)
        source = self.put("big.mesh", self.mesh)
        to = self.put("to.mesh", stretched(self.mesh))
        process = subprocess.Popen(
            [cli_case.TETUNE, "move", source, self.path("out.mesh"), "--to", to, "--threads", "1", "--progress", "json"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=0, pipesize=4096)
        while line := process.stderr.readline():
            if json.loads(line).get("phase") == "sweep":
                break
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=cli_case.HANG)
        self.assertEqual(process.returncode, 1)
        after = Mesh.read(self.path("out.mesh"))
        self.assertGreater(min(after.volumes()), 0)


if __name__ == "__main__":
    cli_case.main(__doc__)
