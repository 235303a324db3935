# SPDX-License-Identifier: Apache-2.0
"""--criteria: verdicts, exit codes, JSON, errors. Run: see cli_case.py."""

import json
import subprocess

import cli_case
from cli_case import CliTest, cube

PRESETS = ("abaqus", "ansys", "calculix", "fluent", "nastran", "openfoam")


class Criteria(CliTest):
    def setUp(self):
        super().setUp()
        self.put("in.mesh", cube(3))

    def run_here(self, *args, code=0):
        return self.run_cli(*args, code=code, cwd=self.folder)

    def needs_files(self):
        self.put("mine.toml", "[edge_ratio]\nfail = 100\n")
        run = subprocess.run([cli_case.TETUNE, "info", "in.mesh", "--criteria", "mine.toml"], capture_output=True,
                             text=True, cwd=self.folder, timeout=60)
        if "reads no criteria files" in run.stderr:
            self.skipTest("toml++ was not installed")

    def test_presets(self):
        for name in PRESETS:
            done = self.run_here("info", "in.mesh", "--criteria", name)
            self.assertIn(f"acceptance by {name}: pass", done.stdout)
            line = self.run_here("info", "--check", "in.mesh", "--criteria", name).stdout
            self.assertTrue(line.endswith(f"; {name}: pass\n"), line)
        for command in ("info", "compare", "optimize"):
            text = self.run_here(command, "--help").stdout
            self.assertTrue(all(name in text for name in PRESETS))

    def test_presets_accept_volumes_below_the_range_of_doubles(self):
        mesh = cube(2)
        mesh.points = [tuple(1e-149 * x for x in p) for p in mesh.points]
        self.put("tiny.mesh", mesh)
        done = self.run_here("info", "tiny.mesh", "--criteria", "abaqus")
        self.assertRegex(done.stdout, r"(?m)^  volume +pass +2.22507e-308 +- +2.22507e-308 +0 +0 ")
        volumes = json.loads(self.run_here("info", "tiny.mesh", "--criteria", "abaqus", "--json").stdout)["acceptance"]["results"][0]
        self.assertEqual((volumes["worst"], volumes["fail"], volumes["failed"]), (2.2250738585072014e-308,) * 2 + (0,))

    def test_a_failed_criterion_is_exit_code_1(self):
        self.needs_files()
        self.put("mine.toml", "# gr\u00f6\u00dfer\n[edge_ratio]\nfail = 1.01\n\n[mean_ratio]\nwarn = 0.999\nfail = 1e-3\n")
        self.run_here("info", "in.mesh", "--criteria", "mine.toml", code=1)
        done = self.run_here("info", "in.mesh", "--json", "--criteria", "mine.toml", code=1)
        acceptance = json.loads(done.stdout)["acceptance"]
        self.assertEqual((acceptance["criteria"], acceptance["verdict"]), ("mine.toml", "fail"))
        edges, ratio = acceptance["results"]
        self.assertEqual((edges["measure"], edges["verdict"], edges["failed"], edges["warn"]),
                         ("edge_ratio", "fail", edges["count"], None))
        self.assertEqual((ratio["verdict"], ratio["failed"], ratio["source"]), ("warn", 0, "mine.toml"))
        done = self.run_here("optimize", "in.mesh", "-o", "out.mesh", "--criteria", "mine.toml", "--report", "r.json",
                             code=1)
        self.assertIn("acceptance by mine.toml: fail, before fail\n", done.stdout)
        self.assertRegex(done.stdout, r"(?m)^  edge_ratio +fail -> fail +[0-9.]+ -> [0-9.]+ +- +1.01 +0 -> 0 +162 -> 162 ")
        self.assertRegex(done.stdout, r"(?m)^  mean_ratio +warn -> warn ")
        both = json.loads(self.read_bytes("r.json"))["acceptance"]
        self.assertEqual((both["before"]["verdict"], both["after"]["verdict"]), ("fail", "fail"))
        self.assertIn("round on the elements that fail: 2 rings", done.stdout)
        self.assertIn("edge_ratio fails:", done.stdout)
        limits, = both["limits"]
        self.assertEqual(sum(limits["held_by"].values()), both["after"]["results"][0]["failed"])
        self.assertEqual(both["rounds"][0]["rings"], 2)
        self.assertLess(both["after"]["results"][0]["worst"], both["before"]["results"][0]["worst"])
        self.run_here("compare", "in.mesh", "out.mesh", "--criteria", "mine.toml", code=1)

    def test_what_optimize_repairs_is_accepted(self):
        self.needs_files()
        after = self.run_here("optimize", "in.mesh", "-o", "out.mesh", "--report", "r.json")
        quality = json.loads(self.read_bytes("r.json"))
        limit = (quality["before"]["mean_ratio_min"] + quality["after"]["mean_ratio_min"]) / 2
        self.put("mine.toml", f"[mean_ratio]\nfail = {limit}\n")
        self.run_here("info", "in.mesh", "--criteria", "mine.toml", code=1)
        self.assertNotIn("acceptance", after.stdout)
        self.run_here("optimize", "in.mesh", "-o", "out.mesh", "--criteria", "mine.toml")
        done = self.run_here("compare", "in.mesh", "out.mesh", "--criteria", "mine.toml", "--json")
        both = json.loads(done.stdout)
        self.assertEqual((both["before"]["acceptance"]["verdict"], both["after"]["acceptance"]["verdict"]),
                         ("fail", "pass"))
        self.put("mine.toml", f"[mean_ratio]\nfail = {limit}\nallowed_percent = 99\n")
        self.assertIn("mine.toml: warn", self.run_here("info", "--check", "in.mesh", "--criteria", "mine.toml").stdout)

    def test_what_a_criterion_would_lose_is_undone(self):
        self.needs_files()
        mesh = cube(4)
        mesh.points = [(x, y, 0.02 * z) for x, y, z in mesh.points]
        self.put("thin.mesh", mesh)
        for limits, loss in (("fail = 0.005", "pass -> fail, 0 -> "), ("warn = 0.02\nfail = 0.005", "warn -> fail, 0 -> ")):
            self.put("mine.toml", f"[scaled_jacobian]\n{limits}\n")
            done = self.run_here("optimize", "thin.mesh", "-o", "out.mesh", "--criteria", "mine.toml", "--report", "r.json")
            acceptance = json.loads(self.read_bytes("r.json"))["acceptance"]
            self.assertIn("(scaled_jacobian: " + loss, acceptance["undone"])
            self.assertIn("tetune: warning: " + acceptance["undone"], done.stderr)
            before, after = (acceptance[key]["results"][0] for key in ("before", "after"))
            self.assertLessEqual(after["failed"], before["failed"])
            self.assertLessEqual(after["warned"], before["warned"])
            self.assertGreaterEqual(after["worst"], before["worst"])
            for r in acceptance["rounds"]:
                self.assertEqual(r["failed_before"], before["warned"])
                self.assertIn(f"round on the elements that warn: {r['rings']} rings", done.stdout)

    def test_errors_name_file_line_and_the_nearest_name(self):
        self.needs_files()
        for text, said in (("\n[edge_ration]\nfail = 2\n", ["mine.toml:2:", "'edge_ration'", "mean 'edge_ratio'?"]),
                           ("[edge_ratio]\nfails = 2\n", ["mine.toml:2:", "'fails'", "mean 'fail'?"]),
                           ("[edge_ratio]\nfail = 'two'\n", ["mine.toml:2:", "must be a number"]),
                           ("[edge_ratio]\nfail = 2\nwarn = 3\n", ["mine.toml:1:", "edge_ratio", "at most fail"]),
                           ("[edge_ratio]\n", ["mine.toml:1:", "no limit"]),
                           ("edge_ratio = 2\n", ["mine.toml:1:", "must be a table"]),
                           ("\n[scaled_jacobian]\nwarn = 1.5\n", ["mine.toml:2:", "the best value is 1"]),
                           ("[edge_ratio\nfail = 2\n", ["mine.toml:1:", "not TOML"]),
                           ("[edge_ratio]\n\0", ["mine.toml:2:", "control character"]),
                           ("", ["mine.toml", "no criterion"])):
            self.put("mine.toml", text)
            for command in (["info", "in.mesh"], ["optimize", "in.mesh", "-o", "out.mesh"]):
                self.refused(*command, "--criteria", "mine.toml", said=said, cwd=self.folder)
        self.refused("info", "in.mesh", "--criteria", "open-foam", said=["did you mean 'openfoam'?"], cwd=self.folder)
        self.assertEqual(self.files(), ["in.mesh", "mine.toml"])


if __name__ == "__main__":
    cli_case.main(__doc__)
