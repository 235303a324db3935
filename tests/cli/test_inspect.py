# SPDX-License-Identifier: Apache-2.0
"""tetune info and compare. Run: see cli_case.py."""

import json
from pathlib import Path

import cli_case
from cli_case import MEASURES, QUALITY_KEYS, CliTest, Mesh, cube, tangled


class Info(CliTest):
    def test_json(self):
        mesh = cube(3)
        name = self.put("in.mesh", mesh.text().replace("End", "Corners\n2\n1\n4\nHexahedra\n1\n1 2 3 4 5 6 7 8 0\nEnd"))
        done = self.run_cli("info", "--json", name)
        self.assertEqual(done.stderr, "")
        info = json.loads(done.stdout)
        self.assertEqual(info["file"], name)
        wanted = {"vertices": 64, "tetrahedra": 162, "triangles": 0, "corners": 2, "Hexahedra": 1}
        self.assertEqual({name: info["counts"][name] for name in wanted}, wanted)
        self.assertEqual(info["validity"], {"valid": True, "findings": []})
        self.assertEqual(set(info["quality"]), QUALITY_KEYS)
        self.assertEqual(info["quality"]["tetrahedra"], 162)
        self.assertAlmostEqual(info["quality"]["volume"], 1)

    def test_figures_of_a_known_mesh(self):
        corner = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2, 3)])
        quality = json.loads(self.run_cli("info", "--json", self.put("in.mesh", corner)).stdout)["quality"]
        self.assertAlmostEqual(quality["dihedral_min_deg"], 54.735610317245346, places=9)
        self.assertAlmostEqual(quality["dihedral_max_deg"], 90, places=9)
        self.assertAlmostEqual(quality["eta_sum"], (3 * 0.25 + 0.75) * 6, places=9)
        self.assertEqual(quality["worst_tetrahedron"], 1)

    def test_invalid(self):
        name = self.put("in.mesh", tangled(2))
        info = json.loads(self.run_cli("info", "--json", name, code=1).stdout)
        self.assertFalse(info["validity"]["valid"])
        finding = next(f for f in info["validity"]["findings"] if "inverted" in f["kind"])
        self.assertEqual((finding["where"], finding["count"], finding["first"]), ("tetrahedra", 8, [15, 36, 43, 44, 45]))
        text = self.run_cli("info", name, code=1).stdout
        self.assertIn("inverted tetrahedra", text)
        self.assertIn("counted from 1: 15, 36, 43, 44, 45)", text)

    def test_unmeasurable(self):
        mesh = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2, 3)])
        info = json.loads(self.run_cli("info", "--json", self.put("in.mesh", mesh), code=1).stdout)
        self.assertNotIn("quality", info)
        self.assertEqual(info["validity"]["findings"][0]["kind"], "index out of range")

    def test_text(self):
        name = self.put("in.mesh", cube(2))
        done = self.run_cli("info", name)
        self.assertIn("valid: every volume positive", done.stdout)
        self.assertRegex(done.stdout, r"vertices +27 +tags 0: 6, 1: 6")
        self.assertRegex(done.stdout, r"tetrahedra +48 +tags 3: 48")

    def test_measures_and_worst_elements(self):
        mesh = cube(3)
        name = self.put("in.mesh", mesh)
        quality = json.loads(self.run_cli("info", "--json", name, "--worst", "4").stdout)["quality"]
        self.assertEqual(list(quality["measures"]), MEASURES)
        for measure, figures in quality["measures"].items():
            worse = ["min", "worst_1_percent", "worst_5_percent", "mean", "max"]
            values = [figures[key] for key in worse]
            if measure in ("max_dihedral_deg", "radius_ratio", "aspect_ratio"):
                values = [figures[key] for key in ("min", "mean", "worst_5_percent", "worst_1_percent", "max")]
            self.assertEqual(values, sorted(values), measure)
        self.assertEqual(len(quality["worst"]), 4)
        worst = quality["worst"][0]
        self.assertEqual(worst["tetrahedron"], quality["worst_tetrahedron"])
        self.assertEqual(worst["min_dihedral_deg"], quality["dihedral_min_deg"])
        corners = [mesh.points[v] for v in mesh.tets[worst["tetrahedron"] - 1]]
        for place, axis in zip(worst["centroid"], zip(*corners)):
            self.assertAlmostEqual(place, sum(axis) / 4)
        text = self.run_cli("info", name).stdout
        for measure in MEASURES:
            self.assertIn(measure, text)
        self.assertRegex(text, rf"min angle +q_h +centroid\n +{worst['tetrahedron']} +{worst['min_dihedral_deg']:.3f} ")

    def test_box_and_volume(self):
        mesh = cube(2)
        mesh.points = [(2 * x - 1, y, z) for x, y, z in mesh.points]
        name = self.put("in.mesh", mesh)
        text = self.run_cli("info", name).stdout
        self.assertIn("box                     -1 0 0 to 1 1 1, diagonal 2.44949\n", text)
        self.assertIn("volume                  2\n", text)
        box = json.loads(self.run_cli("info", "--json", name).stdout)["box"]
        self.assertEqual((box["low"], box["high"]), ([-1, 0, 0], [1, 1, 1]))
        self.assertAlmostEqual(box["diagonal"], 6 ** 0.5)

    def test_cell_data(self):
        name = self.put("in.mesh", cube(2))
        done = self.run_cli("info", "--json", name, "--cell-data", self.path("q.sol"))
        measures = json.loads(done.stdout)["quality"]["measures"]
        words = Path(self.path("q.sol")).read_text().split()
        self.assertEqual(words[:7], ["MeshVersionFormatted", "2", "Dimension", "3", "SolAtTetrahedra", "48", "9"])
        self.assertEqual(words[7:16], ["1"] * 9)
        self.assertEqual(words[-1], "End")
        values = list(map(float, words[16:-1]))
        self.assertEqual(len(values), 9 * 48)
        for k, measure in enumerate(MEASURES):
            self.assertEqual(min(values[k::9]), measures[measure]["min"])
            self.assertEqual(max(values[k::9]), measures[measure]["max"])
        self.assertEqual(self.files(), ["in.mesh", "q.sol"])

    def test_cell_data_refused(self):
        name = self.put("in.mesh", cube(1))
        self.refused("info", name, "--cell-data", self.path("q.mesh"), said=["q.mesh", ".sol", ".vtu"])
        self.refused("info", name, "--cell-data", self.path("absent/q.sol"), said=["absent"])
        mesh = cube(1)
        mesh.tets[0] = (0, 1, 2, 99)
        self.refused("info", self.put("wild.mesh", mesh), "--cell-data", self.path("q.sol"), said=["wild.mesh"])
        self.assertEqual(self.files(), ["in.mesh", "wild.mesh"])

    def test_warnings_go_to_the_standard_error(self):
        name = self.put("in.mesh", cube(1).text().replace("End", "Normals\n1\n0 0 1\nEnd"))
        done = self.run_cli("info", "--json", name)
        self.assertIn("warning", done.stderr)
        self.assertIn("Normals", done.stderr)
        json.loads(done.stdout)

    def test_bounds(self):
        name = self.put("in.mesh", cube(3))
        quality = json.loads(self.run_cli("info", "--json", name).stdout)["quality"]
        angle, ratio = quality["dihedral_min_deg"], quality["measures"]["mean_ratio"]["min"]
        radius = quality["measures"]["radius_ratio"]["max"]
        valid = "valid: every volume positive, every face on one or two tetrahedra, boundary closed"
        for bounds, code in (([0.99 * ratio], 0), ([1.01 * ratio], 1), ([f"min_dihedral_deg={angle - 1}"], 0),
                             ([f"min_dihedral_deg={angle + 1}"], 1), ([f"radius_ratio={radius * 1.01}"], 0),
                             ([f"radius_ratio={radius * 0.99}"], 1), ([0.99 * ratio, f"radius_ratio={radius * 0.99}"], 1)):
            words = [word for bound in bounds for word in ("--min-quality", bound)]
            self.assertIn("NOT met: " if code else " met: ", self.run_cli("info", name, *words, code=code).stdout)
            text = self.run_cli("info", "--check", *words, name, code=code).stdout
            self.assertEqual(text.splitlines(), [text.strip()])
            self.assertTrue(text.startswith(f"{name}: {valid}; "))
            judged = json.loads(self.run_cli("info", "--json", *words, name, code=code).stdout)["bounds"]
            self.assertEqual(all(b["met"] for b in judged), code == 0)
        self.assertEqual(self.run_cli("info", "--check", name).stdout, f"{name}: {valid}\n")
        mesh = cube(2)
        mesh.tets[0] = (0, 1, 2, 99)
        self.assertIn("index out of range", self.run_cli("info", "--check", "--min-quality", "0.1", self.put("b.mesh", mesh), code=1).stdout)
        for bad in ("good", "beauty=3", "mean_ratio=", "0.2x", "nan"):
            self.refused("info", name, "--min-quality", bad, said=["--min-quality"])

    def test_refusals(self):
        self.refused("info", self.path("absent.mesh"), said=["absent.mesh"])
        self.refused("info", said=["MESH is required"])
        self.refused("info", self.path("a.mesh"), self.path("b.mesh"), said=["b.mesh"])


class Compare(CliTest):
    def compare(self, before, after, code=0):
        return json.loads(self.run_cli("compare", "--json", before, after, code=code).stdout)

    def test_the_same(self):
        name = self.put("in.mesh", cube(2))
        result = self.compare(name, name)
        change = result["change"]
        for key in ("volume_change", "area_change", "region_volume_change", "distance_new_to_old",
                    "distance_old_to_new", "required_vertices_moved", "corners_moved"):
            self.assertEqual(change[key], 0, key)
        for key in ("vertex_tags_kept", "edge_tags_kept", "triangle_tags_kept", "tetrahedron_tags_kept"):
            self.assertIs(change[key], True)
        self.assertEqual(result["before"], result["after"])
        self.assertEqual(result["before"]["file"], name)

    def test_optimized(self):
        source = self.put("in.mesh", cube(4))
        self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--quiet")
        result = self.compare(source, self.path("out.mesh"))
        self.assertLess(abs(result["change"]["volume_change"]), 1e-12)
        self.assertLess(abs(result["change"]["area_change"]), 1e-12)
        self.assertLess(result["change"]["distance_new_to_old"], 1e-12)
        self.assertLess(result["change"]["distance_old_to_new"], 1e-12)
        self.assertLess(result["after"]["quality"]["eta_sum"], result["before"]["quality"]["eta_sum"])
        text = self.run_cli("compare", source, self.path("out.mesh")).stdout
        self.assertIn("surface distance", text)
        for part in ("measures before", "measures after", "worst before", "worst after", "scaled_jacobian"):
            self.assertIn(part, text)
        for side in ("before", "after"):
            self.assertEqual(list(result[side]["quality"]["measures"]), MEASURES)
        self.assertNotIn("NO", text)

    def test_other_volumes_are_a_warning(self):
        mesh = cube(2)
        small = self.put("a.mesh", mesh)
        for scale, said in ((2, "times the volume"), (2.01, "b.mesh has 2.01 times the volume"), (0.49, "b.mesh has 0.49 times")):
            wide = Mesh([(scale * x, y, z) for x, y, z in mesh.points], mesh.tets)
            done = self.run_cli("compare", small, self.put("b.mesh", wide))
            check = self.assertNotIn if scale == 2 else self.assertIn
            check(said, done.stderr)

    def test_different(self):
        mesh = cube(2)
        wide = Mesh([(2 * x, y, z) for x, y, z in mesh.points], mesh.tets, mesh.point_tags, [5] * len(mesh.tets))
        change = self.compare(self.put("a.mesh", mesh), self.put("b.mesh", wide))["change"]
        self.assertAlmostEqual(change["volume_change"], 1)
        self.assertAlmostEqual(change["area_change"], 4 / 6)
        self.assertGreater(change["distance_new_to_old"], 0.1)
        self.assertIs(change["tetrahedron_tags_kept"], False)
        self.assertIs(change["vertex_tags_kept"], True)

    def test_invalid(self):
        mesh = cube(1)
        good = self.put("a.mesh", mesh)
        mesh.points[7] = (0, 0, 0.5)
        result = self.compare(good, self.put("b.mesh", mesh), code=1)
        self.assertTrue(result["before"]["validity"]["valid"])
        self.assertFalse(result["after"]["validity"]["valid"])

    def test_refusals(self):
        self.refused("compare", self.put("a.mesh", cube(1)), said=["AFTER is required"])
        self.refused("compare", self.path("a.mesh"), self.path("absent.mesh"), said=["absent.mesh"])


if __name__ == "__main__":
    cli_case.main(__doc__)
