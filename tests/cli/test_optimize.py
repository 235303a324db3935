# SPDX-License-Identifier: Apache-2.0
"""tetune optimize: what it writes, prints and returns. Run: see cli_case.py."""

import csv
import json
from pathlib import Path

import cli_case
from cli_case import MEASURES, QUALITY_KEYS, CliTest, Mesh, cube, layer, unflipped

TRACE_COLUMNS = ["event", "iteration", "pass", "energy_before", "decrease", "gradient_norm2", "moved", "active",
                 "evaluated", "flips_2_3", "flips_3_2", "edge_removals", "face_removals", "boundary_flips", "seconds"]


class Optimize(CliTest):
    def test_writes_a_valid_mesh_and_a_table(self):
        mesh = unflipped(cube(5, two_regions=True))
        done = self.run_cli("optimize", self.put("in.mesh", mesh), "-o", self.path("out.mesh"))
        after = Mesh.read(self.path("out.mesh"))
        self.assert_improved(mesh, after)
        self.assertNotEqual(after.points, mesh.points)
        self.assertIn("before", done.stdout)
        self.assertIn("after", done.stdout)
        self.assertIn("dihedral min", done.stdout)
        self.assertIn(self.path("out.mesh"), done.stdout)
        # No progress line in a pipe.
        self.assertEqual(done.stderr, "")
        self.assertEqual(self.files(), ["in.mesh", "out.mesh"])

    def test_fixed_boundary_stays(self):
        mesh = cube(4)
        self.run_cli("optimize", self.put("in.mesh", mesh), "-o", self.path("out.mesh"), "--boundary", "fixed")
        after = Mesh.read(self.path("out.mesh"))
        self.assertEqual(after.boundary_faces(), mesh.boundary_faces())
        for v in {v for face in mesh.boundary_faces() for v in face}:
            self.assertEqual(after.points[v], mesh.points[v])

    def test_preserved_boundary_keeps_the_cube(self):
        mesh = cube(4)
        self.run_cli("optimize", self.put("in.mesh", mesh), "-o", self.path("out.mesh"), "--boundary", "preserve")
        after = Mesh.read(self.path("out.mesh"))
        for p, q in zip(mesh.points, after.points):
            for a, b in zip(p, q):
                if a in (0.0, 1.0):
                    self.assertEqual(b, a)

    def test_verbosity(self):
        source = self.put("in.mesh", cube(3))
        for option in (["--quiet"], ["-v", "0"]):
            done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), *option)
            self.assertEqual(done.stdout + done.stderr, "")
        done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--quiet", "--target-quality", "0.99",
                            "mean_ratio", code=1)
        self.assertEqual(done.stderr, f"tetune: warning: {self.path('out.mesh')}: target missed\n")
        plain = self.run_cli("optimize", source, "-o", self.path("out.mesh")).stdout
        loud = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "-v", "2").stdout
        for part in ("after sweep  pass", "|grad tr|^2", "phase        time s"):
            self.assertIn(part, loud)
            self.assertNotIn(part, plain)
        self.assertGreater(len(loud.splitlines()), len(plain.splitlines()) + 5)

    def test_the_automatic_device_says_why(self):
        source = self.put("in.mesh", cube(3))
        said = {}
        for device in ("auto", "cpu"):
            done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--device", device,
                                "--report", self.path("run.json"))
            with open(self.path("run.json"), encoding="utf-8") as file:
                said[device] = json.load(file)["optimization"]
            self.assertEqual("on CPU: below 500000 tetrahedra" in done.stdout, device == "auto")
        self.assertEqual(said["auto"]["device"], "CPU")
        self.assertEqual(said["auto"]["device_reason"], "below 500000 tetrahedra")
        self.assertEqual(said["cpu"]["device_reason"], "")

    def test_report(self):
        mesh = unflipped(cube(4))
        source = self.put("in.mesh", mesh)
        self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--report", self.path("r.json"), "--threads", "2",
                     "--termination", "paper", "--max-iterations", "7")
        report = json.loads(self.read_bytes("r.json"))
        self.assertEqual(report["input"], source)
        self.assertEqual(report["output"], self.path("out.mesh"))
        self.assertEqual(report["options"], {
            "boundary": "preserve", "energy": "shape", "effort": "standard", "keep_vertices": False, "max_growth": 1.1, "surface_vertices": "auto", "restarts": -1, "untangle": False, "straighten": False,
            "feature_angle": 45, "feature_angle_deg": 45, "max_deviation": 0, "open_boundaries": True, "frozen_regions": [],
            "frozen_patches": [], "relocation": "newton", "termination": "paper", "device": "cpu", "max_iterations": 7,
            "flips": True, "max_ring": 7, "boundary_flips": True, "targets": [], "only_below": [], "rings": 2, "threads": 2, "data": "carry",
            "trace_angles": False})
        self.assertGreaterEqual(report["read_seconds"], 0)
        self.assertGreaterEqual(report["write_seconds"], 0)
        before, after, run = report["before"], report["after"], report["optimization"]
        self.assertEqual({s["dihedral_min_deg"] for s in run["sweeps"]}, {None})
        self.assertEqual([s["gradient_norm"] for s in run["sweeps"]], [s["gradient_norm2"] for s in run["sweeps"]])
        for quality in (before, after):
            self.assertEqual(set(quality), QUALITY_KEYS)
            self.assertAlmostEqual(sum(quality["dihedral_histogram_10_deg"]), 1)
            self.assertAlmostEqual(quality["volume"], 1)
            self.assertEqual(list(quality["measures"]), MEASURES)
            self.assertEqual(len(quality["worst"]), 10)
        self.assertEqual(after["measures"]["min_dihedral_deg"]["min"], after["dihedral_min_deg"])
        self.assertGreater(after["measures"]["q_h"]["mean"], before["measures"]["q_h"]["mean"])
        self.assertEqual(before["tetrahedra"], len(mesh.tets))
        self.assertEqual(run["tetrahedra_before"], before["tetrahedra"])
        self.assertEqual(run["tetrahedra_after"], after["tetrahedra"])
        self.assertEqual(run["vertices"], 5 ** 3)
        parts = ("vertices_free", "vertices_in_plane", "vertices_on_line", "vertices_fixed")
        self.assertEqual(sum(run[part] for part in parts), run["vertices"])
        self.assertGreater(run["flips_3_2"], 0)
        added = run["tetrahedra_after"] - run["tetrahedra_before"]
        self.assertGreaterEqual(added, run["flips_2_3"] - run["flips_3_2"] - 3 * run["face_removals"])
        self.assertLessEqual(added, run["flips_2_3"] - run["flips_3_2"] + 3 * run["edge_removals"]
                             + 4 * run["boundary_flips"])
        self.assertAlmostEqual(run["energy_before"] / before["shape_sum"], 1)
        self.assertAlmostEqual(run["energy_after"] / after["shape_sum"], 1)
        self.assertLess(run["energy_after"], 0.99 * run["energy_before"])
        self.assertGreater(after["mean_ratio"], before["mean_ratio"])
        self.assertEqual(run["threads"], 2)
        self.assertLessEqual(len(run["sweeps"]), 7)
        self.assertEqual([s["iteration"] for s in run["sweeps"]], list(range(1, len(run["sweeps"]) + 1)))
        self.assertEqual(sum(p["flips_2_3"] for p in run["flip_passes"]), run["flips_2_3"])
        for count in ("flips_3_2", "edge_removals", "face_removals", "boundary_flips"):
            self.assertEqual(sum(p[count] for p in run["flip_passes"]), run[count])
        self.assertEqual(self.files(), ["in.mesh", "out.mesh", "r.json"])

    def trace(self, *options):
        self.run_cli("optimize", self.put("in.mesh", unflipped(cube(4))), "-o", self.path("out.mesh"), "--report",
                     self.path("r.json"), "--trace", self.path("t.csv"), *options)
        with open(self.path("t.csv"), newline="") as file:
            reader = csv.DictReader(file)
            self.assertEqual(reader.fieldnames, TRACE_COLUMNS)
            rows = list(reader)
        return rows, json.loads(self.read_bytes("r.json"))["optimization"]

    def test_trace(self):
        rows, run = self.trace()
        for row in rows:
            self.assertNotIn(None, row)
            self.assertNotIn(None, row.values())
            empty = {"sweep": {"pass", "active", "evaluated", "flips_2_3", "flips_3_2", "edge_removals",
                               "face_removals", "boundary_flips"},
                     "flips": {"gradient_norm2", "moved"}}[row["event"]]
            self.assertEqual({c for c in TRACE_COLUMNS if row[c] == ""}, empty)
        sweeps = [r for r in rows if r["event"] == "sweep"]
        passes = [r for r in rows if r["event"] == "flips"]
        self.assertEqual(len(sweeps), len(run["sweeps"]))
        self.assertEqual(len(passes), len(run["flip_passes"]))
        self.assertGreater(len(sweeps), 1)
        self.assertGreater(sum(int(r["flips_2_3"]) + int(r["flips_3_2"]) for r in passes), 0)
        self.assertEqual([int(r["iteration"]) for r in rows], sorted(int(r["iteration"]) for r in rows))
        # Each row starts where the one before it left the energy.
        energy = run["energy_before"]
        for row in rows:
            self.assertAlmostEqual(float(row["energy_before"]) / energy, 1, places=9)
            self.assertGreaterEqual(float(row["decrease"]), 0)
            energy = float(row["energy_before"]) - float(row["decrease"])
        # The work on the few worst gives some of it back.
        self.assertAlmostEqual(energy / run["energy_after"], 1, delta=0.02)

    def test_flips_alone(self):
        rows, run = self.trace("--max-iterations", "0")
        self.assertTrue(rows)
        self.assertEqual({r["event"] for r in rows}, {"flips"})
        self.assertEqual(run["sweeps"], [])
        self.assertEqual(Mesh.read(self.path("out.mesh")).points, cube(4).points)

    def test_largest_ring(self):
        _, run = self.trace()
        self.assertGreater(run["edge_removals"], 0)
        self.assertGreater(run["face_removals"], 0)
        _, run = self.trace("--max-ring", "3")
        self.assertEqual(run["edge_removals"], 0)
        self.assertEqual(run["face_removals"], 0)
        self.assertEqual(run["tetrahedra_after"] - run["tetrahedra_before"], run["flips_2_3"] - run["flips_3_2"])

    def test_iteration_limit(self):
        _, run = self.trace("--max-iterations", "1")
        self.assertEqual(len(run["sweeps"]), 1)
        self.assertEqual(run["stopped"], "iteration limit")

    def test_gradient_relocation(self):
        _, run = self.trace("--relocation", "gradient")
        self.assertGreater(len(run["sweeps"]), 0)
        self.assertLess(run["energy_after"], run["energy_before"])

    def test_same_bytes_for_any_number_of_threads(self):
        source = self.put("in.mesh", unflipped(cube(8)))
        for threads in (1, 2, 3):
            self.run_cli("optimize", source, "-o", self.path(f"{threads}.mesh"), "--threads", threads, "--quiet")
        self.assertEqual(self.read_bytes("2.mesh"), self.read_bytes("1.mesh"))
        self.assertEqual(self.read_bytes("3.mesh"), self.read_bytes("1.mesh"))

    def test_in_place(self):
        source = self.put("in.mesh", cube(3))
        self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--quiet")
        self.run_cli("optimize", source, "-o", source, "--quiet")
        self.assertEqual(self.read_bytes("in.mesh"), self.read_bytes("out.mesh"))
        self.assertEqual(self.files(), ["in.mesh", "out.mesh"])

    def test_binary_holds_the_same(self):
        source = self.put("in.mesh", cube(3))
        self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--quiet")
        self.run_cli("optimize", source, "-o", self.path("out.meshb"), "--quiet")
        infos = [json.loads(self.run_cli("info", "--json", self.path(f)).stdout) for f in ("out.mesh", "out.meshb")]
        for key in ("counts", "quality", "validity"):
            self.assertEqual(infos[0][key], infos[1][key])

    def test_inside_out_stays_inside_out(self):
        mesh = cube(3)
        turned = Mesh(mesh.points, [(a, b, d, c) for a, b, c, d in mesh.tets])
        self.run_cli("optimize", self.put("in.mesh", turned), "-o", self.path("out.mesh"), "--quiet")
        self.assertLess(max(Mesh.read(self.path("out.mesh")).volumes()), 0)

    def test_what_the_readme_shows(self):
        """The result is the same everywhere, so the figures of the demonstration are."""
        root = Path(__file__).resolve().parents[2]
        shown = (root / "README.md").read_text().split("and prints this:\n\n```\n")[1].split("```")[0].splitlines()
        self.assertGreater(len(shown), 3)
        printed = self.run_cli("optimize", root / "data/bracket.meshb", self.path("out.mesh")).stdout.splitlines()
        self.assertEqual([line for line in shown if line not in printed], [])

    def test_tetgen_files(self):
        mesh = cube(3)
        nodes = "".join(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(mesh.points))
        self.put("m.node", f"{len(mesh.points)} 3 0 0\n{nodes}")
        tets = "".join(f"{i} {a} {b} {c} {d} 4\n" for i, (a, b, c, d) in enumerate(mesh.tets))
        self.put("m.ele", f"{len(mesh.tets)} 4 1\n{tets}")
        done = self.run_cli("optimize", self.path("m.ele"), "-o", self.path("out.mesh"))
        self.assertIn("tetune: warning: ", done.stderr)
        self.assertIn("m.face does not exist", done.stderr)
        after = Mesh.read(self.path("out.mesh"))
        self.assertEqual(set(after.tet_tags), {4})
        self.assertGreater(min(after.volumes()), 0)
        # Warnings alone when quiet, and not even these.
        done = self.run_cli("optimize", self.path("m.ele"), "-o", self.path("out.mesh"), "--quiet", "--report",
                            self.path("r.json"))
        self.assertIn("m.face does not exist", done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(["m.face does not exist" in w for w in json.loads(self.read_bytes("r.json"))["warnings"]], [True])
        done = self.run_cli("optimize", self.path("m.ele"), "-o", self.path("out.mesh"), "-v", "-1")
        self.assertEqual(done.stdout + done.stderr, "")

    def test_a_layer_whose_largest_angle_grows(self):
        """In a layer of one element that is a hundred times as wide as thick the warning has the angles of the tables."""
        self.put("in.mesh", layer(8, 0.01))
        done = self.run_cli("optimize", "in.mesh", "-o", "out.mesh", "--report", "r.json", cwd=self.folder)
        report = json.loads(self.read_bytes("r.json"))
        before, after = (report[part]["dihedral_max_deg"] for part in ("before", "after"))
        self.assertGreater(after, 150)
        self.assertIn(f"largest dihedral angle {before:.2f} -> {after:.2f}", done.stderr)
        self.assertEqual(len([text for text in report["warnings"] if "at the expense of others" in text]), 1)
        for words, count in ((["--quiet"], 1), (["-v", "-1"], 0)):
            done = self.run_cli("optimize", "in.mesh", "-o", "out.mesh", *words, cwd=self.folder)
            self.assertEqual(done.stderr.count("at the expense of others"), count, words)
        # The same elements in a thick layer.
        self.put("in.mesh", layer(8, 0.1))
        self.assertNotIn("expense", self.run_cli("optimize", "in.mesh", "-o", "out.mesh", cwd=self.folder).stderr)


if __name__ == "__main__":
    cli_case.main(__doc__)
