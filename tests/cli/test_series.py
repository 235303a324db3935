# SPDX-License-Identifier: Apache-2.0
"""tetune move of a time series: the meshes of all times, what the files must have, and exit codes. Run: see cli_case.py."""

import json
import os
import random
import re
import signal
import struct
import subprocess
import time
from pathlib import Path

import cli_case
from cli_case import CliTest, cube, needs_vtk, vtk_bytes


class Series(CliTest):
    def setUp(self):
        super().setUp()
        self.mesh = cube(4)

    def vtk(self, name, points, tets=None, data=()):
        """A legacy VTK file of the mesh at other places; `data`: name and rows of point data."""
        Path(self.path(name)).write_bytes(vtk_bytes(points, self.mesh.tets if tets is None else tets, data))

    def series(self, files, name="in.pvd"):
        entries = "".join(f'<DataSet timestep="{time}" file="{file}"/>\n' for time, file in files)
        with open(self.path(name), "w") as file:
            file.write(f'<VTKFile type="Collection" version="0.1">\n<Collection>\n{entries}</Collection>\n</VTKFile>\n')
        return self.path(name)

    def points(self, name):
        """The coordinates of a file of the result."""
        self.run_cli("convert", self.path(name), "-o", self.path("back.mesh"))
        after = cli_case.Mesh.read(self.path("back.mesh"))
        self.assertGreater(min(after.volumes()), 0)
        return after.points

    def stretched(self, by):
        return [(by * p[0], p[1], p[2]) for p in self.mesh.points]

    @needs_vtk
    def test_positions(self):
        linear = [(2 * p[0] + p[2],) for p in self.mesh.points]
        self.vtk("a.vtk", self.mesh.points, data=[("heat", linear)])
        self.vtk("b.vtk", self.stretched(1.25))
        self.vtk("c.vtk", self.stretched(0.5))
        done = self.run_cli("move", self.series([(0, "a.vtk"), (0.1, "b.vtk"), (0.3, "c.vtk")]), "-o", self.path("out.pvd"),
                            "--data", "interpolate", "--report", self.path("r.json"))
        self.assertIn("3 of 3 times written", done.stdout)
        with open(self.path("out.pvd")) as file:
            self.assertEqual(re.findall(r'timestep="([^"]*)".*file="([^"]*)"', file.read()),
                             [("0", "out_0000.vtu"), ("0.1", "out_0001.vtu"), ("0.3", "out_0002.vtu")])
        self.assertEqual(self.points("out_0000.vtu"), self.mesh.points)
        for name, by in (("out_0001.vtu", 1.25), ("out_0002.vtu", 0.5)):
            after = self.points(name)
            for v, p in enumerate(self.mesh.points):
                if any(x in (0, 1) for x in p):
                    self.assertEqual(after[v], (by * p[0], p[1], p[2]))
        with open(self.path("r.json")) as file:
            report = json.load(file)
        self.assertEqual([t["time"] for t in report["times"]], [0, 0.1, 0.3])
        self.assertEqual(report["times"][2]["motion"]["fraction"], 1)

    @needs_vtk
    def test_events(self):
        self.vtk("a.vtk", self.mesh.points)
        self.vtk("b.vtk", self.stretched(1.1))
        done = self.run_cli("move", self.series([(0, "a.vtk"), (1, "b.vtk")]), "-o", self.path("out.pvd"), "--progress", "json", "--quiet")
        events = [json.loads(line) for line in done.stderr.splitlines()]
        self.assertEqual(events[0], {"event": "start", "input": self.path("in.pvd"), "output": self.path("out.pvd")})
        self.assertEqual([events[-1][key] for key in ("event", "result", "exit_code")], ["end", "done", 0])

    @needs_vtk
    def test_displacements(self):
        still = [(0.0, 0.0, 0.0)] * len(self.mesh.points)
        lifted = [(0.0, 0.0, 0.2 * p[2]) for p in self.mesh.points]
        self.vtk("a.vtk", self.mesh.points, data=[("u", still)])
        self.vtk("b.vtk", self.mesh.points, data=[("u", lifted)])
        self.run_cli("move", self.series([(1, "a.vtk"), (2, "b.vtk")]), "-o", self.path("out.pvd"), "--displacement", "u",
                     "--effort", "best", "--threads", "1")
        self.assertAlmostEqual(max(p[2] for p in self.points("out_0001.vtu")), 1.2)

    def exodus(self, times):
        """An Exodus file with the displacements u_x, u_y, u_z of times. A NetCDF file ends with the records of its times, of
        which tetune writes the first."""
        self.vtk("one.vtk", self.mesh.points, data=[(f"u_{axis}", [(x,) for x in values]) for axis, values in zip("xyz", zip(*times[0][1]))])
        self.run_cli("convert", self.path("one.vtk"), "-o", self.path("in.e"))
        records = [struct.pack(f">{1 + 3 * len(u)}d", time, *(x for axis in zip(*u) for x in axis)) for time, u in times]
        with open(self.path("in.e"), "rb") as file:
            written = file.read()
        self.assertEqual(written[-len(records[0]) + 8:], records[0][8:])
        with open(self.path("in.e"), "wb") as file:
            file.write(written[:4] + struct.pack(">i", len(times)) + written[8:-len(records[0])] + b"".join(records))
        return self.path("in.e")

    @needs_vtk
    def test_exodus(self):
        def lifted(by):
            return [(0.0, 0.0, by * p[2]) for p in self.mesh.points]

        mesh = self.exodus([(0.5, lifted(0)), (1, lifted(0.2)), (3, lifted(-0.3))])
        self.assertNotIn("is kept", self.run_cli("move", mesh, "-o", self.path("out.pvd"), "--displacement", "u").stderr)
        with open(self.path("out.pvd")) as file:
            self.assertEqual(re.findall(r'timestep="([^"]*)"', file.read()), ["0.5", "1", "3"])
        for i, top in enumerate((1, 1.2, 0.7)):
            self.assertAlmostEqual(max(p[2] for p in self.points(f"out_000{i}.vtu")), top)
        for words, said in (((), "no target"), (("--displacement", "v"), "no point data of this name; it has: u_x, u_y, u_z")):
            self.assertIn(said, self.run_cli("move", mesh, "-o", self.path("b.pvd"), *words, code=2).stderr)
        self.exodus([(1, lifted(0)), (1, lifted(0.2))])
        self.assertIn("the times do not increase",
                      self.run_cli("move", mesh, "-o", self.path("b.pvd"), "--displacement", "u", code=2).stderr)

    @needs_vtk
    def test_files_that_exist(self):
        self.vtk("a.vtk", self.mesh.points)
        self.vtk("b.vtk", self.stretched(1.1))
        series = self.series([(0, "a.vtk"), (1, "b.vtk")])
        with open(self.path("out_0001.vtu"), "w") as file:
            file.write("of another series")
        self.assertIn("out_0001.vtu, which exists", self.run_cli("move", series, self.path("out.pvd"), code=2).stderr)
        self.assertEqual(self.read_bytes("out_0001.vtu"), b"of another series")
        self.run_cli("move", series, "-o", self.path("out.pvd"))
        self.points("out_0001.vtu")

    @needs_vtk
    def test_a_time_that_fails(self):
        self.vtk("a.vtk", self.mesh.points)
        self.vtk("b.vtk", self.stretched(1.1))
        Path(self.path("damaged.vtk")).write_bytes(b"# vtk DataFile Version 3.0")
        series = self.series([(0, "a.vtk"), (1, "b.vtk"), (2, "damaged.vtk")])
        done = self.run_cli("move", series, "-o", self.path("out.pvd"), "--report", self.path("r.json"), code=1)
        self.assertIn("damaged.vtk", done.stderr)
        self.points("out_0001.vtu")
        self.assertEqual([entry["time"] for entry in json.loads(self.read_bytes("r.json"))["times"]], [0, 1])

    def wait_for(self, name, process):
        end = time.monotonic() + cli_case.HANG
        while not os.path.exists(self.path(name)):
            self.assertIsNone(process.poll(), "it ended first")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.001)

    @needs_vtk
    def test_interruption_after_the_first_time(self):
        self.vtk("a.vtk", self.mesh.points)
        files = [(0, "a.vtk")]
        for i in range(1, 60):
            self.vtk(f"{i}.vtk", self.stretched(1.2 - 0.2 * (i % 2)))
            files.append((i, f"{i}.vtk"))
        series = self.series(files)
        for number, signals in enumerate(((signal.SIGINT,), (signal.SIGINT, signal.SIGTERM))):
            process = subprocess.Popen([cli_case.TETUNE, "move", series, "-o", self.path(f"out{number}.pvd"), "--quiet"],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            self.wait_for(f"out{number}.pvd", process)
            process.send_signal(signal.SIGSTOP)  # so that both come before it can do a thing
            for sign in signals:
                process.send_signal(sign)
            process.send_signal(signal.SIGCONT)
            _, err = process.communicate(timeout=cli_case.HANG)
            self.assertEqual(process.returncode, 1, err)
            self.assertNotIn("nothing was written", err)
            if len(signals) > 1:
                self.assertIn("interrupted after meshes of the series were written", err)
            else:
                self.assertIn("interrupted", err)
            self.points(f"out{number}_0000.vtu")

    def test_a_folder_with_the_name_of_an_option(self):
        said = self.refused("move", "max_growth/nofile.pvd", "-o", self.path("out.pvd")).stderr
        self.assertIn("max_growth/nofile.pvd", said.replace("\\", "/"))

    @needs_vtk
    def test_blocked(self):
        self.vtk("a.vtk", self.mesh.points)
        self.vtk("b.vtk", self.stretched(-1))
        self.vtk("c.vtk", self.mesh.points)
        done = self.run_cli("move", self.series([(0, "a.vtk"), (1, "b.vtk"), (2, "c.vtk")]), "-o", self.path("out.pvd"), code=1)
        self.assertIn("block it", done.stdout)
        self.points("out_0001.vtu")
        self.assertFalse(os.path.exists(self.path("out_0002.vtu")))

    @needs_vtk
    def test_quiet_and_blocked(self):
        self.vtk("a.vtk", self.mesh.points)
        self.vtk("b.vtk", self.stretched(-1))
        done = self.run_cli("move", self.series([(0, "a.vtk"), (2.5, "b.vtk")]), "-o", self.path("out.pvd"), "--quiet", code=1)
        self.assertEqual(done.stdout, "")
        self.assertIn("out.pvd: motion blocked at time 2.5, after ", done.stderr)
        self.assertIn(" % of the way there: the valid mesh of that fraction was written; ", done.stderr)

    @needs_vtk
    def test_a_time_at_which_nothing_moves(self):
        for name in ("a.vtk", "b.vtk"):
            self.vtk(name, self.mesh.points)
        for boundary in ("preserve", "slide"):
            done = self.run_cli("move", self.series([(0, "a.vtk"), (1, "b.vtk")]), "-o", self.path("out.pvd"),
                                "--boundary", boundary)
            self.assertIn("out_0001.vtu, nothing moved\n", done.stdout)
            self.assertIn("if point data are their displacements, name these with --displacement", done.stderr)
            self.assertEqual(self.points("out_0001.vtu"), self.mesh.points)

    @needs_vtk
    def test_displacements_that_are_not_named(self):
        zero = [(0, 0, 0)] * len(self.mesh.points)
        up = [(0, 0, 0.1 * p[2]) for p in self.mesh.points]
        self.vtk("a.vtk", self.mesh.points, data=[("u", zero)])
        self.vtk("b.vtk", self.mesh.points, data=[("u", up)])
        names = self.series([(0, "a.vtk"), (1, "b.vtk")])
        done = self.run_cli("move", names, "-o", self.path("out.pvd"), "--quiet", "--report", self.path("r.json"))
        self.assertIn("a.vtk has: u)", done.stderr)
        with open(self.path("r.json")) as file:
            self.assertIn("nothing moved", json.load(file)["warnings"][0])
        done = self.run_cli("move", names, "-o", self.path("out.pvd"), "--displacement", "u")
        self.assertNotIn("nothing moved", done.stderr)

    def listed(self, name="out.pvd"):
        """The files that a series lists; none if there is no series yet."""
        if not os.path.exists(self.path(name)):
            return []
        with open(self.path(name)) as file:
            text = file.read()
        self.assertTrue(text.endswith("</VTKFile>\n"), text)
        return re.findall(r'file="([^"]*)"', text)

    @needs_vtk
    def test_killed_at_any_moment(self):
        """The series lists whole and valid files alone, and no other file of a step is a part of one."""
        self.mesh = cube(7)
        steps = [(i, f"{i}.vtk") for i in range(8)]
        for i, name in steps:
            self.vtk(name, self.stretched(1 + 0.04 * i))
        words = [cli_case.TETUNE, "move", self.series(steps), "-o", self.path("out.pvd"), "--threads", "1", "--quiet"]
        start = time.monotonic()
        subprocess.run(words, check=True, timeout=cli_case.HANG)
        seconds = time.monotonic() - start
        rng = random.Random(3)
        counts = set()
        for _ in range(10):
            for name in self.files():
                if name.startswith("out"):
                    os.remove(self.path(name))
            cli_case.start_and_kill(words, lambda _: time.sleep(rng.random() * seconds))
            listed = self.listed()
            counts.add(len(listed))
            self.assertEqual(listed, [f"out_{i:04}.vtu" for i in range(len(listed))])
            for name in self.files():
                if re.fullmatch(r"out_\d{4}\.vtu", name):
                    self.run_cli("info", "--check", self.path(name))
        self.assertGreater(len(counts), 2, "the moments did not differ")

    @needs_vtk
    def test_files_that_do_not_fit(self):
        tets = [self.mesh.tets[1], self.mesh.tets[0], *self.mesh.tets[2:]]
        self.vtk("a.vtk", self.mesh.points)
        self.vtk("other.vtk", self.mesh.points, tets)
        self.vtk("less.vtk", self.mesh.points, self.mesh.tets[1:])
        out = self.path("out.pvd")
        for file, said in (("other.vtk", "tetrahedron 1 has other vertices"), ("less.vtk", "the same mesh")):
            done = self.run_cli("move", self.series([(0, "a.vtk"), (1, file)]), "-o", out, code=1)
            self.assertIn(said, done.stderr)
            self.points("out_0000.vtu")
        self.refused("move", self.series([(0, "a.vtk"), (0, "a.vtk")]), "-o", out, said=["several files"])
        self.refused("move", self.series([(0, "a.vtk"), (1, "no.vtk")]), "-o", self.path("new.pvd"),
                     said=["there is no file", "no.vtk, the mesh of time 1;"])
        self.assertFalse(os.path.exists(self.path("new_0000.vtu")))
        os.rename(self.path("a.vtk"), self.path("out_0000.vtu"))
        self.refused("move", self.series([(0, "out_0000.vtu")]), "-o", out, said=["would be overwritten"])

    def test_refusals(self):
        self.vtk("a.vtk", self.mesh.points)
        out = self.path("out.pvd")
        good = self.series([(0, "a.vtk"), (1, "a.vtk")])
        self.refused("move", good, "-o", self.path("out.mesh"), said=["becomes a time series"])
        self.refused("move", good, "-o", out, "--to", self.path("a.vtk"), said=["--to is not for time series"])
        self.refused("move", good, "-o", out, "--map", self.path("m.txt"), said=["--map"])


if __name__ == "__main__":
    cli_case.main(__doc__)
