# SPDX-License-Identifier: Apache-2.0
"""Curved second-order tetrahedra on the command line. Run: see cli_case.py."""

import json
import re
from itertools import combinations

import cli_case
from cli_case import CliTest, cube, msh_text
from second_order import EDGES, TET10, Middles, bend


def curved_block(n=4, jitter=0.15, straight=False, bends=True):
    """A bent cube: the nodes of each tetrahedron, the positions, and the mid-side nodes of the surface; with straight
    inner edges if asked."""
    mesh = cube(n, jitter=jitter)
    points = [tuple(p) for p in mesh.points]
    middles = Middles(points)
    nodes = [middles.nodes_of(tet) for tet in mesh.tets]
    on_surface = {middles.of_edge(*ends) for face in mesh.boundary_faces() for ends in combinations(face, 2)}
    positions = [bend(p) if bends else p for p in points]
    for (a, b), v in middles.edge2node.items():
        if straight and v not in on_surface:
            positions[v] = tuple((positions[a][k] + positions[b][k]) / 2 for k in range(3))
    return nodes, positions, on_surface


def write_msh(path, nodes, points):
    path.write_text(msh_text(points, [(TET10, 1, row) for row in nodes]))


def read_nodes(path):
    lines = path.read_text().splitlines()
    first = lines.index("$Nodes") + 2
    return {tuple(float(x) for x in line.split()[1:4]) for line in lines[first:first + int(lines[first - 1])]}


class Curved(CliTest):
    def path_of(self, name):
        return self.folder / name

    def info(self, name, code=0):
        return json.loads(self.run_cli("info", self.path_of(name), "--json", code=code).stdout)

    def test_the_curved_surface_stays_and_all_elements_are_proved_valid(self):
        nodes, points, on_surface = curved_block()
        write_msh(self.path_of("in.msh"), nodes, points)
        before = self.run_cli("info", self.path_of("in.msh")).stdout
        self.assertIn("proved valid, 0 inverted, 0 undecided", before)
        results = set()
        for threads in ("1", "3"):
            self.run_cli("optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--threads", threads)
            results.add(self.path_of("out.msh").read_bytes())
        self.assertEqual(len(results), 1)
        after = read_nodes(self.path_of("out.msh"))
        self.assertEqual([p for i, p in enumerate(points) if i in on_surface and p not in after], [])
        self.assertIn("proved valid, 0 inverted, 0 undecided", self.run_cli("info", self.path_of("out.msh")).stdout)
        self.assertNotEqual(self.path_of("in.msh").read_bytes(), self.path_of("out.msh").read_bytes())

    def test_inverted_elements_are_refused_or_made_valid(self):
        nodes, points, on_surface = curved_block(jitter=0)
        inner = next(v for v in nodes[len(nodes) // 2][4:] if v not in on_surface)
        points[inner] = tuple(x + d for x, d in zip(points[inner], (0.2, 0.15, 0.1)))
        write_msh(self.path_of("in.msh"), nodes, points)
        self.run_cli("info", self.path_of("in.msh"), code=1)
        refused = self.run_cli("optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), code=2).stderr
        self.assertIn("not proved positive", refused)
        self.assertIn("(--untangle). `tetune info` measures them", refused)
        self.assertNotIn("()", refused)
        around = [t for t, row in enumerate(nodes) if inner in row]
        ids = re.search(r"\(first, counted from 1: ([\d, ]+)\), the first near (\S+) (\S+) (\S+)", refused).groups()
        self.assertTrue({int(i) - 1 for i in ids[0].split(",")} <= set(around), refused)
        first = nodes[int(ids[0].split(",")[0]) - 1]
        for k in range(3):
            self.assertAlmostEqual(float(ids[1 + k]), sum(points[v][k] for v in first[:4]) / 4, places=5)
        self.assertFalse(self.path_of("out.msh").exists())
        stopped = self.run_cli("optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--untangle", "--time-limit", "1e-9",
                               code=1).stderr
        self.assertIn("stopped before all tetrahedra were made valid, nothing was written", stopped)
        self.run_cli("optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--untangle")
        self.run_cli("info", self.path_of("out.msh"))

    def test_elements_that_the_growth_leaves_unsplit_are_a_warning(self):
        ball = cube(3, jitter=0)
        for i, p in enumerate(ball.points):
            q = [2 * x - 1 for x in p]
            norm = sum(x * x for x in q) ** 0.5
            ball.points[i] = tuple(max(map(abs, q)) * x / norm if norm > 0 else x for x in q)
        straight, curved = self.put("ball.mesh", ball), self.path("ball.msh")
        self.run_cli("convert", straight, curved, "--order", "2")
        words = ["optimize", curved, "-o", self.path("out.msh"), "--untangle", "--no-flips", "--quiet", "--max-growth"]
        self.assertRegex(self.run_cli(*words, "1").stderr, r"the surface bounds the scaled Jacobian of \d+ tetrahedra, .*\(--max-growth\)")
        self.assertNotIn("bounds the scaled Jacobian", self.run_cli(*words, "3").stderr)

    def test_a_folded_surface_is_refused_or_straightened(self):
        nodes, points, on_surface = curved_block(n=2, jitter=0)
        row = nodes[0]
        k = next(k for k, v in enumerate(row[4:]) if v in on_surface)
        a, b = (row[i] for i in EDGES[k])
        middle = row[4 + k]
        points[middle] = tuple(p + 1.2 * (q - p) for p, q in zip(points[a], points[b]))
        write_msh(self.path_of("in.msh"), nodes, points)
        words = ["optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--untangle",
                 "--keep-vertices", "--max-iterations", "0"]
        refused = self.run_cli(*words, "--report", self.path_of("r.json"), code=1)
        self.assertFalse(self.path_of("out.msh").exists())
        self.check_refusal(refused.stderr, json.loads(self.path_of("r.json").read_text())["untangling"], nodes, points)
        done = self.run_cli(*words, "--straighten", "--report", self.path_of("r.json"))
        self.info("out.msh")
        straightened = json.loads(self.path_of("r.json").read_text())["optimization"]["straightened"]
        self.assertIn(sorted((a + 1, b + 1)), [s["edge"] for s in straightened])
        self.assertTrue(all(0 <= s["kept"] < 1 and s["moved"] > 0 for s in straightened))
        self.assertIn(f"{len(straightened)} edges of the surface", done.stdout + done.stderr)
        kept = {p for i, p in enumerate(points) if i in on_surface} & read_nodes(self.path_of("out.msh"))
        self.assertEqual(len(kept), len(on_surface) - len(straightened))

    def test_inverted_straight_tetrahedra_are_untangled_after_conversion(self):
        nodes, points, on_surface = curved_block(n=3, jitter=0)
        corners = {v for row in nodes for v in row[:4]}
        surface = {row[i] for row in nodes for k, v in enumerate(row[4:]) if v in on_surface for i in EDGES[k]}
        inner = min(corners - surface)
        points[inner] = tuple(x + 0.6 for x in points[inner])
        write_msh(self.path_of("in.msh"), nodes, points)
        for words in (["info", "in.msh"], ["info", "--check", "in.msh"]):
            said = self.run_cli(*words, code=1, cwd=self.folder).stdout
            self.assertIn("(tetune convert --order 1) and untangle this (--untangle)", said)
        for more in ([], ["--untangle"]):
            said = self.run_cli("optimize", "in.msh", "-o", "out.msh", *more, code=2, cwd=self.folder).stderr
            self.assertIn("(tetune convert --order 1) and untangle this (--untangle)", said)
            self.assertNotIn("untangle them", said)
            self.assertIn("counted from 1", said)
        self.run_cli("convert", "in.msh", "-o", "straight.msh", "--order", "1", cwd=self.folder)
        self.run_cli("optimize", "straight.msh", "-o", "out.msh", "--untangle", cwd=self.folder)
        self.run_cli("info", "--check", "out.msh", cwd=self.folder)

    def test_a_face_that_its_own_nodes_fold_is_refused_as_failed_untangling(self):
        nodes, points, on_surface = curved_block(n=2, jitter=0, bends=False)
        row = next(row for row in nodes if on_surface.issuperset(row[4:7]))
        points[row[4]] = tuple(p + 1.3 * (q - p) + 0.3 * (r - p) for p, q, r in zip(*(points[v] for v in row[:3])))
        write_msh(self.path_of("in.msh"), nodes, points)
        words = ["optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--untangle"]
        done = self.run_cli(*words, "--report", self.path_of("r.json"), code=1)
        self.assertFalse(self.path_of("out.msh").exists())
        self.assertIn("mid-side nodes fold", done.stderr)
        untangling = json.loads(self.path_of("r.json").read_text())["untangling"]
        self.assertTrue(set(untangling["folded"]) <= set(untangling["left"]))
        self.check_refusal(done.stderr, untangling, nodes, points)

    def check_refusal(self, text, untangling, nodes, points):
        """The message has the first ids, counted from 1 as in the report, and the position of the first."""
        named = untangling.get("folded", untangling["left"])
        self.assertIn("(first, counted from 1: " + ", ".join(map(str, named[:5])) + ")", text)
        self.assertIn("No mesh was written", text)
        at = [float(x) for x in re.search(r"the first near (\S+) (\S+) (\S+)", text).groups()]
        for k in range(3):
            self.assertAlmostEqual(at[k], sum(points[v][k] for v in nodes[named[0] - 1][:4]) / 4, places=5)

    def test_straightening_counts_for_the_bound_on_the_deviation(self):
        nodes, points, on_surface = curved_block(n=2, jitter=0)
        row = nodes[0]
        k = next(k for k, v in enumerate(row[4:]) if v in on_surface)
        a, b = (row[i] for i in EDGES[k])
        points[row[4 + k]] = tuple(p + 1.2 * (q - p) for p, q in zip(points[a], points[b]))
        write_msh(self.path_of("in.msh"), nodes, points)
        words = ["optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--untangle", "--straighten",
                 "--boundary", "slide", "--keep-vertices", "--max-iterations", "0", "--report", self.path_of("r.json")]
        for bound, is_kept in (("1e-4", False), ("10", True)):
            done = self.run_cli(*words, "--max-deviation", bound)
            report = json.loads(self.path_of("r.json").read_text())
            moved = max(s["moved"] for s in report["optimization"]["straightened"])
            self.assertGreater(moved, 1e-2)
            self.assertGreaterEqual(report["optimization"]["curved_deviation"], 4 / 3 * moved)
            self.assertEqual(report["surface"]["max_deviation_kept"], is_kept)
            exceeded = f"the surface is {report['optimization']['curved_deviation']:.3e} from the old one"
            (self.assertNotIn if is_kept else self.assertIn)(exceeded, done.stderr)

    def test_the_surface_slides_on_itself_within_the_bound(self):
        nodes, points, on_surface = curved_block(n=3, jitter=0.25, straight=True)
        write_msh(self.path_of("in.msh"), nodes, points)
        words = ["optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--report", self.path_of("r.json")]
        self.run_cli(*words)
        kept = self.info("out.msh")["quality"]
        for bound in ([], ["--max-deviation", "0.001"]):
            done = self.run_cli(*words, "--boundary", "slide", *bound)
            slid = self.info("out.msh")["quality"]
            self.assertEqual(slid["curved"]["valid"], slid["curved"]["tetrahedra"])
            self.assertGreaterEqual(slid["curved"]["min_scaled_jacobian"], kept["curved"]["min_scaled_jacobian"] - 2e-3)
            self.assertLess(slid["shape_sum"], kept["shape_sum"])
            report = json.loads(self.path_of("r.json").read_text())
            self.assertGreater(report["surface"]["deviation"], 0)
            self.assertLess(report["surface"]["deviation"], 0.01)
            if bound:
                self.assertTrue(report["surface"]["max_deviation_kept"])
                self.assertIn(", kept", done.stdout)
                self.assertLessEqual(report["surface"]["deviation"], 0.001)
                self.assertLessEqual(0, report["optimization"]["curved_deviation"])
                self.assertLessEqual(report["optimization"]["curved_deviation"], 0.001)
        moved = [p for i, p in enumerate(points) if i in on_surface and p not in read_nodes(self.path_of("out.msh"))]
        self.assertGreater(len(moved), 10)

    def test_only_below_is_refused(self):
        nodes, points, _ = curved_block(n=2)
        write_msh(self.path_of("in.msh"), nodes, points)
        done = self.run_cli("optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--only-below", "20", code=2)
        self.assertIn("--only-below: curved second-order elements are relaxed wherever they are; leave it out", done.stderr)

    def test_move_refuses_curved_meshes(self):
        nodes, points, _ = curved_block(n=2)
        write_msh(self.path_of("in.msh"), nodes, points)
        done = self.run_cli("move", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--to", self.path_of("in.msh"), code=2)
        self.assertIn("convert it to straight ones (tetune convert --order 1)", done.stderr)

    def test_straightening_of_periodic_meshes_is_refused(self):
        nodes, points, _ = curved_block(n=2, jitter=0, bends=False)
        inner = next(row[4 + k] for row in nodes for k, (a, b) in enumerate(EDGES)
                     if all(0 < (points[row[a]][i] + points[row[b]][i]) / 2 < 1 for i in range(3)))
        points[inner] = tuple(x + 0.02 for x in points[inner])
        write_msh(self.path_of("in.msh"), nodes, points)
        words = ["optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--periodic", "x", "--untangle"]
        said = self.run_cli(*words, "--straighten", code=2).stderr
        self.assertIn("--straighten: mid-side nodes of periodic vertices would no longer match; leave it out", said)
        self.run_cli(*words)

    def test_invalid_curved_elements_are_named_beside_verdicts(self):
        nodes, points, on_surface = curved_block(n=3, jitter=0)
        write_msh(self.path_of("good.msh"), nodes, points)
        inner = next(v for v in nodes[len(nodes) // 2][4:] if v not in on_surface)
        points[inner] = tuple(x + d for x, d in zip(points[inner], (0.2, 0.15, 0.1)))
        write_msh(self.path_of("bad.msh"), nodes, points)
        curved = self.info("bad.msh", code=1)["quality"]["curved"]
        invalid = curved["tetrahedra"] - curved["valid"]
        around = [t + 1 for t, row in enumerate(nodes) if inner in row]
        self.assertGreater(invalid, 0)

        def run(*words, code=1):
            return self.run_cli(*words, "--worst", "0", code=code, cwd=self.folder).stdout

        reason = f"{invalid} curved tetrahedra are not proved valid (first, counted from 1: "
        note = f"(criteria judge straight tetrahedra; {invalid} curved ones are not proved valid)\n"
        text = run("info", "bad.msh", "--criteria", "calculix")
        self.assertIn("  " + reason, text)
        self.assertIn("acceptance by calculix: pass " + note, text)
        self.assertNotIn("valid: every volume positive", text)
        text = run("info", "--check", "bad.msh", "--criteria", "calculix")
        self.assertTrue(text.startswith("bad.msh: " + reason), text)
        self.assertTrue(text.endswith("; calculix: pass " + note), text)
        self.assertEqual(len(text.splitlines()), 1)
        text = run("compare", "good.msh", "bad.msh", "--criteria", "calculix")
        self.assertRegex(text, rf"(?m)^  curved: 0 of \d+ not proved valid -> {invalid} of \d+; smallest scaled Jacobian [0-9.]+ -> \S+$")
        text = self.run_cli("optimize", "bad.msh", "-o", "repaired.msh", "--untangle", cwd=self.folder).stdout
        self.assertRegex(text, rf"(?m)^  curved: {invalid} of \d+ not proved valid -> 0 of \d+; smallest scaled Jacobian \S+ -> 0\.\d+$")
        text = run("compare", "good.msh", "bad.msh", "--criteria", "calculix")
        self.assertIn("acceptance before by calculix: pass\n", text)
        self.assertIn("acceptance after by calculix: pass " + note, text)
        self.assertTrue(text.splitlines()[-1].startswith("  bad.msh: " + reason), text)
        self.assertIn("  bad.msh: " + reason, run("compare", "bad.msh", "good.msh"))
        sides = json.loads(run("compare", "good.msh", "bad.msh", "--json", "--criteria", "calculix"))
        self.assertEqual(sides["before"]["validity"], {"valid": True, "findings": []})
        self.assertEqual(sides["before"]["acceptance"]["curved_not_valid"], 0)
        for side in (sides["after"], json.loads(run("info", "bad.msh", "--json", "--criteria", "calculix"))):
            self.assertIs(side["validity"]["valid"], False)
            finding, = side["validity"]["findings"]
            self.assertEqual(finding["count"], invalid)
            self.assertTrue(finding["first"] and set(finding["first"]) <= set(around), finding)
            self.assertEqual(side["acceptance"]["curved_not_valid"], invalid)

    def test_a_dry_run_counts_the_vertices_that_slide(self):
        nodes, points, _ = curved_block(n=3, jitter=0.25, straight=True)
        write_msh(self.path_of("in.msh"), nodes, points)
        kinds = {"free vertices": "free", "vertices in planes": "in_plane", "vertices on lines": "on_line",
                 "vertices on surface": "on_surface", "vertices on curves": "on_curve", "fixed vertices": "fixed"}
        for words in ([], ["--boundary", "slide"], ["--boundary", "slide", "--data", "interpolate"]):
            dry = self.run_cli("optimize", self.path_of("in.msh"), "--dry-run", *words).stdout
            self.run_cli("optimize", self.path_of("in.msh"), "-o", self.path_of("out.msh"), "--report", self.path_of("r.json"), *words)
            run = json.loads(self.path_of("r.json").read_text())["optimization"]
            counts = {name: int(count) for name, count in re.findall(r"(?m)^  ([a-z ]+?) +(\d+)$", dry) if name in kinds}
            self.assertEqual(counts, {name: run["vertices_" + key] for name, key in kinds.items() if run["vertices_" + key] > 0})
            self.assertEqual("vertices on surface" in counts, "slide" in words)


if __name__ == "__main__":
    cli_case.main(__doc__)
