# SPDX-License-Identifier: Apache-2.0
"""A run while it lasts: interruption, limits of time and memory, dry run, progress, map. Run: see cli_case.py."""

import json
import os
import pty
import re
import signal
import subprocess
import time

import cli_case
from cli_case import CliTest, Mesh, cube, tangled, unflipped

PROGRESS_KEYS = {"event", "phase", "fraction", "seconds", "seconds_left", "iteration", "energy", "energy_before",
                 "worst_angle_deg"}


class LongRuns(CliTest):
    """On a mesh that takes long enough to be interrupted, however late this process gets to it: tetune waits in the middle
    until its events are read, as they are more than fit into their pipe, one of a single page."""

    @classmethod
    def setUpClass(cls):
        cls.mesh = cube(18)
        cls.text = cls.mesh.text()

    def start(self, *words, **more):
        words = [cli_case.TETUNE, "optimize", *words, "--threads", "1", "--progress", "json"]
        return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=0, pipesize=4096, **more)

    def start_one(self):
        return self.start(self.put("in.mesh", self.text), "-o", self.path("out.mesh"))

    def wait_for(self, process, phase):
        """Reads the events up to the first of this phase, and not a byte more."""
        while line := process.stderr.readline():
            if json.loads(line).get("phase") == phase:
                return
        self.fail("the event did not come")

    def end(self, process):
        out, err = process.communicate(timeout=cli_case.HANG)
        return process.returncode, out.decode(), [json.loads(line) for line in err.splitlines()]

    def assert_valid_output(self):
        after = Mesh.read(self.path("out.mesh"))
        self.assertGreater(min(after.volumes()), 0)
        self.assertEqual(len(after.points), len(self.mesh.points))
        self.assertAlmostEqual(sum(after.volumes()), 1)

    def check_signal(self, sign):
        process = self.start_one()
        self.wait_for(process, "sweep")
        process.send_signal(sign)
        code, out, events = self.end(process)
        self.assertEqual(code, 1)
        self.assertEqual(events[-1]["result"], "interrupted")
        self.assertIn("stopped early (interrupted)", out)
        self.assert_valid_output()
        self.assertEqual(self.files(), ["in.mesh", "out.mesh"])

    def test_first_signal_writes_the_best_mesh(self):
        self.check_signal(signal.SIGINT)

    def test_first_termination_writes_the_best_mesh(self):
        self.check_signal(signal.SIGTERM)

    def check_end(self, end, code, source):
        """The last event of a run that a signal ended at once."""
        self.assertTrue(0 <= end.pop("seconds") < cli_case.HANG)
        self.assertEqual(end, {"event": "end", "input": source, "result": "interrupted", "exit_code": code})

    def test_before_there_is_anything_to_write(self):
        for sign in (signal.SIGINT, signal.SIGTERM):
            process = self.start("-", self.path("out.mesh"), stdin=subprocess.PIPE)  # reads until that is closed
            self.wait_for(process, "reading")
            time.sleep(0.2)
            process.send_signal(sign)
            code, _, events = self.end(process)
            self.assertEqual(code, 2)
            self.assertIn("nothing was written", events[-2]["text"])
            self.assertGreaterEqual(events[-1]["seconds"], 0.2)
            self.check_end(events[-1], 2, "-")
            self.assertEqual(self.files(), [])

    def test_second_signal_ends_at_once(self):
        self.put("out.mesh", "an old file")
        source = self.put('in "\u00e9".mesh', self.text)
        process = self.start(source, "-o", self.path("out.mesh"))
        self.wait_for(process, "sweep")
        process.send_signal(signal.SIGSTOP)  # so that both come before it can do a thing
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGTERM)
        process.send_signal(signal.SIGCONT)
        code, _, events = self.end(process)
        self.assertEqual(code, 2)
        self.check_end(events[-1], 2, source)
        self.assertEqual(self.files(), ['in "\u00e9".mesh', "out.mesh"])
        self.assertEqual(self.read_bytes("out.mesh"), b"an old file")

    def test_signals_while_writing_leave_no_temporary_file(self):
        self.put("out.mesh", "an old file")
        process = self.start_one()
        self.wait_for(process, "sweep")
        process.send_signal(signal.SIGINT)
        self.wait_for(process, "writing")
        process.send_signal(signal.SIGINT)
        code, _, _ = self.end(process)
        self.assertEqual(self.files(), ["in.mesh", "out.mesh"])
        if code == 2:
            self.assertEqual(self.read_bytes("out.mesh"), b"an old file")
        else:
            self.assertEqual(code, 1)  # it was quicker
            self.assert_valid_output()

    def test_an_ignored_signal_stays_ignored(self):
        """As under nohup, or in the background of a shell."""
        source = self.put("in.mesh", cube(8))
        done = subprocess.run(["sh", "-c", 'trap "" INT; "$@" & p=$!; kill -INT $p; wait $p', "sh", cli_case.TETUNE, "optimize",
                               source, self.path("out.mesh"), "--quiet"], timeout=cli_case.HANG)
        self.assertEqual(done.returncode, 0)

    def test_several_meshes(self):
        first, second = self.put("a.mesh", self.text), self.put("b.mesh", self.text)
        process = self.start(first, second, "-o", self.path("new_{}.mesh"))
        self.wait_for(process, "sweep")
        process.send_signal(signal.SIGINT)
        code, out, _ = self.end(process)
        self.assertEqual(code, 2)  # of b nothing was written
        self.assertIn("interrupted", out)
        self.assertIn("not started", out)
        self.assertEqual(self.files(), ["a.mesh", "b.mesh", "new_a.mesh"])

    def test_time_limit(self):
        source = self.put("in.mesh", self.text)
        sweeps = {}
        for limit in ("0.01", "1000"):
            done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--threads", "1", "--time-limit", limit, "--report",
                                self.path("r.json"), code=0 if limit == "1000" else 1)
            run = json.loads(self.read_bytes("r.json"))["optimization"]
            sweeps[limit] = len(run["sweeps"])
            self.assertEqual(run["stopped"], "time limit" if limit == "0.01" else "converged")
            self.assertEqual("stopped early (time limit)" in done.stdout, limit == "0.01")
            self.assert_valid_output()
        self.assertLess(sweeps["0.01"], sweeps["1000"])
        for bad in ("0", "-1", "soon"):
            self.refused("optimize", source, self.path("x.mesh"), "--time-limit", bad, said=["--time-limit"])


class Limits(CliTest):
    def test_memory(self):
        source = self.put("in.mesh", cube(8))
        self.run_cli("optimize", source, "-o", self.path("out.mesh"), "-m", "1000", "--quiet")
        os.remove(self.path("out.mesh"))
        done = self.refused("optimize", source, "-o", self.path("out.mesh"), "-m", "1", said=["in.mesh", "--max-memory", "allows 1;"])
        self.assertRegex(done.stderr, r"needs about \d+ MB")
        self.assertEqual(self.files(), ["in.mesh"])
        self.refused("optimize", source, "-o", self.path("out.mesh"), "-m", "much", said=["--max-memory"])

    def test_dry_run(self):
        mesh = cube(5)
        source = self.put("in.mesh", mesh)
        done = self.run_cli("optimize", source, "--dry-run")
        for name, count in (("free vertices", 4 ** 3), ("vertices in planes", 6 * 16), ("vertices on lines", 12 * 4),
                            ("fixed vertices", 8), ("tetrahedra", 750)):
            self.assertRegex(done.stdout, rf"(?m)^  {name} +{count}\b")
        self.assertRegex(done.stdout, r"memory +about \d+ MB")
        self.assertRegex(done.stdout, r"time +about [\d.e-]+ s on \d+ threads?")
        best = self.run_cli("optimize", source, "--dry-run", "--effort", "best", "--restarts", 40, "--threads", 1)
        seconds = re.search(r"time +about ([\d.e-]+) s on 1 thread", best.stdout)
        self.assertGreater(float(seconds[1]), 10)
        self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--dry-run", "--map", self.path("m"), "--report",
                     self.path("r.json"))
        self.assertEqual(self.files(), ["in.mesh"])
        several = [source, self.put("b.mesh", cube(2)), self.put("c.mesh", cube(3))]
        for names in (several, several[:2]):
            done = self.run_cli("optimize", *names, "--dry-run")
            for name in names:
                self.assertIn(f"{name}: nothing is written", done.stdout)
                self.assertRegex(done.stdout, rf"(?m)^  {name} +checked$")
        self.assertEqual(self.files(), ["b.mesh", "c.mesh", "in.mesh"])
        # A run that would fail does so.
        self.refused("optimize", source, self.path("absent/out.mesh"), "--dry-run", said=["absent"])
        self.refused("optimize", self.put("bad.mesh", tangled(4)), "--dry-run", said=["inverted"])


class ProgressEvents(CliTest):
    def test_json(self):
        source = self.put("in.mesh", unflipped(cube(6, 0.25)))
        for effort, phases in (("fast", {"load", "flips", "sweep"}), ("standard", {"load", "flips", "sweep", "worst", "angles"}),
                               ("best", {"load", "flips", "sweep", "worst", "angles", "restarts"})):
            done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--progress", "json", "--effort", effort)
            events = [json.loads(line) for line in done.stderr.splitlines()]
            self.assertEqual(events[0], {"event": "start", "input": source, "output": self.path("out.mesh")})
            self.assertEqual([e["phase"] for e in events if e["event"] == "phase"], ["reading", "optimizing", "writing"])
            end = events[-1]
            self.assertEqual((end["event"], end["result"], end["exit_code"]), ("end", "done", 0))
            self.assertGreaterEqual(end["worst_angle_deg"], end["worst_angle_before_deg"])
            progress = [e for e in events if e["event"] == "progress"]
            seen = {e["phase"] for e in progress}
            self.assertTrue(phases - {"worst", "restarts"} <= seen <= phases, seen)  # none may be bad enough for these
            for e in progress:
                self.assertEqual(set(e), PROGRESS_KEYS)
                self.assertTrue(0 < e["fraction"] <= 1)
                self.assertGreaterEqual(e["worst_angle_deg"], end["worst_angle_before_deg"] - 1e-6)
            self.assertAlmostEqual(progress[0]["worst_angle_deg"], end["worst_angle_before_deg"], places=6)
            self.assertEqual([e["fraction"] for e in progress], sorted(e["fraction"] for e in progress))
            self.assertEqual([e["seconds"] for e in progress], sorted(e["seconds"] for e in progress))
            self.assertIsNone(progress[0]["seconds_left"])
            self.assertGreaterEqual(progress[-1]["seconds_left"], 0)
            self.assertLess(progress[-1]["energy"], progress[0]["energy_before"])

    def test_warnings_and_errors_are_events(self):
        source = self.put("in.mesh", cube(1).text().replace("End", "Normals\n1\n0 0 1\nEnd"))
        done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--progress", "json", "--quiet")
        events = [json.loads(line) for line in done.stderr.splitlines()]
        self.assertIn("Normals", next(e["text"] for e in events if e["event"] == "warning"))
        done = self.run_cli("optimize", self.path("absent.mesh"), "-o", self.path("out.mesh"), "--progress", "json", code=2)
        events = [json.loads(line) for line in done.stderr.splitlines()]
        self.assertIn("absent.mesh", next(e["text"] for e in events if e["event"] == "error"))
        self.assertEqual(events[-1]["exit_code"], 2)

    def on_terminal(self, *words):
        ours, theirs = pty.openpty()
        process = subprocess.Popen([cli_case.TETUNE, "optimize", *words], stdout=subprocess.DEVNULL, stderr=theirs)
        os.close(theirs)
        text = b""
        while True:
            try:
                got = os.read(ours, 65536)
            except OSError:  # the other side is closed
                break
            if not got:
                break
            text += got
        os.close(ours)
        self.assertEqual(process.wait(timeout=cli_case.HANG), 0)
        return text.decode()

    def test_line_on_a_terminal(self):
        source = self.put("in.mesh", cube(8))
        text = self.on_terminal(source, "-o", self.path("out.mesh"))
        for part in ("reading ...", " %  ", "energy -", "worst angle ", "writing ..."):
            self.assertIn(part, text)
        self.assertTrue(text.endswith("\r\x1b[K"))
        for words in (["--progress", "none"], ["--quiet"]):
            self.assertEqual(self.on_terminal(source, "-o", self.path("out.mesh"), *words), "")

    def test_watching_changes_nothing(self):
        source = self.put("in.mesh", unflipped(cube(6)))
        self.run_cli("optimize", source, self.path("a.mesh"), "--progress", "json")
        self.run_cli("optimize", source, self.path("b.mesh"), "--progress", "none")
        self.assertEqual(self.read_bytes("a.mesh"), self.read_bytes("b.mesh"))


class Map(CliTest):
    def read_map(self, *words):
        self.run_cli("optimize", self.path("in.mesh"), "-o", self.path("out.mesh"), "--map", self.path("m.txt"), *words)
        lines = self.read_bytes("m.txt").decode().splitlines()
        self.assertEqual(lines[0], "# tetune map: old new, counted from 1; 0: none")
        maps, at = [], 1
        for name in ("Vertices", "Tetrahedra"):
            head, count = lines[at].split()
            self.assertEqual(head, name)
            maps.append([tuple(map(int, line.split())) for line in lines[at + 1:at + 1 + int(count)]])
            at += 1 + int(count)
        self.assertEqual(at, len(lines))
        return maps

    def check(self, pairs, old, new):
        """Every id of either mesh is there, and each new one once."""
        self.assertEqual({o for o, _ in pairs if o}, set(range(1, old + 1)))
        self.assertEqual([n for _, n in pairs if n], list(range(1, new + 1)))
        self.assertNotIn((0, 0), pairs)

    def test_kept_vertices(self):
        mesh = unflipped(cube(5))
        mesh.tet_tags = [1 + (sum(mesh.points[v][0] for v in t) > 2) for t in mesh.tets]
        self.put("in.mesh", mesh)
        vertices, tets = self.read_map()
        after = Mesh.read(self.path("out.mesh"))
        self.assertEqual(vertices, [(i, i) for i in range(1, len(mesh.points) + 1)])
        self.check(tets, len(mesh.tets), len(after.tets))
        self.assertIn(0, {n for _, n in tets})  # flips took some away
        for old, new in tets:
            if new:
                self.assertEqual(after.tet_tags[new - 1], mesh.tet_tags[old - 1])

    def test_inserted_and_removed_vertices(self):
        mesh = unflipped(cube(6, 0.25))
        self.put("in.mesh", mesh)
        vertices, tets = self.read_map("--effort", "best")
        after = Mesh.read(self.path("out.mesh"))
        self.check(vertices, len(mesh.points), len(after.points))
        self.check(tets, len(mesh.tets), len(after.tets))
        self.assertTrue({o for o, n in vertices if n == 0} or {n for o, n in vertices if o == 0})
        for old, new in vertices:
            if old and new:
                self.assertEqual(after.point_tags[new - 1], mesh.point_tags[old - 1])

    def test_refused(self):
        self.put("in.mesh", cube(1))
        self.refused("optimize", self.path("in.mesh"), "-o", self.path("out.mesh"), "--map", self.path("absent/m"), said=["absent"])
        self.refused("optimize", self.path("in.mesh"), "-o", self.path("out.mesh"), "--map", "/dev/null", said=["/dev/null", "regular"])
        self.assertEqual(self.files(), ["in.mesh"])


if __name__ == "__main__":
    cli_case.main(__doc__)
