# SPDX-License-Identifier: Apache-2.0
"""tetune optimize: boundary, constraints, effort and targets. Run: see cli_case.py."""

import json
import math
import os

import cli_case
from cli_case import CliTest, Mesh, bent, cube, unflipped, with_triangles


SURFACE_KEYS = {"volume_change", "area_change", "region_volume_change", "patch_area_change", "patches",
                "mean_boundary_edge", "distance_vertices_to_old", "distance_new_to_old", "distance_sample_stride", "deviation", "distance_old_to_new", "vertices_before",
                "vertices_after", "vertex_tags_kept", "edge_tags_kept", "triangle_tags_kept",
                "tetrahedron_tags_kept", "required_vertices_moved", "corners_moved"}


class Slide(CliTest):
    def slide(self, source, *options, code=0):
        done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--report", self.path("r.json"), *options,
                            code=code)
        return json.loads(self.read_bytes("r.json")), done.stdout + done.stderr

    def test_surface_is_followed_and_reported(self):
        mesh = bent(cube(5))
        source = self.put("in.mesh", with_triangles(mesh, [(f, 4) for f in sorted(mesh.boundary_faces())]))
        report, text = self.slide(source, "--boundary", "slide")
        self.assertEqual(set(report["surface"]), SURFACE_KEYS)
        surface = report["surface"]
        self.assertLess(surface["distance_vertices_to_old"], 1e-12)
        self.assertGreater(surface["distance_new_to_old"], 1e-6)
        self.assertEqual([p["tag"] for p in surface["patches"]], [4])
        self.assertEqual(set(surface["patches"][0]), {"tag", "area_before", "area_change"})
        self.assertLess(abs(surface["patches"][0]["area_change"]), 0.02)
        for part in ("volume change", "surface area change", "surface distance", "old to new", "largest of a tagged"):
            self.assertIn(part, text)
        run = report["optimization"]
        self.assertGreater(run["vertices_on_surface"], 0)
        self.assertGreater(run["vertices_on_curve"], 0)
        self.assertEqual(run["vertices_fixed"], 8)
        self.assertEqual(run["vertices_in_plane"] + run["vertices_on_line"], 0)
        # Other modes do not report it.
        report, text = self.slide(source)
        self.assertNotIn("surface", report)
        self.assertNotIn("surface distance", text)
        self.assertEqual(report["optimization"]["vertices_on_surface"], 0)

    def test_feature_angle(self):
        source = self.put("in.mesh", cube(4))
        report, _ = self.slide(source, "--boundary", "slide")
        self.assertEqual(report["options"]["feature_angle_deg"], 45)
        for options, fixed, angle in ((["--feature-angle", "120"], 0, 120), (["-ar", "120"], 0, 120),
                                      (["-nr"], 0, 180), (["-ar", "80"], 8, 80)):
            report, _ = self.slide(source, "--boundary", "slide", *options)
            self.assertEqual(report["options"]["feature_angle_deg"], angle)
            self.assertEqual(report["optimization"]["vertices_fixed"], fixed)

    def test_max_deviation(self):
        source = self.put("in.mesh", bent(cube(5)))
        points = Mesh.read(source).points
        diagonal = math.dist(*[[f(p[k] for p in points) for k in range(3)] for f in (min, max)])
        free, _ = self.slide(source, "--boundary", "slide")
        for option in ("--max-deviation", "-hausd"):
            for text, value in (("0.002", 0.002), ("0.1%", 0.001 * diagonal), ("2e-3", 0.002)):
                report, _ = self.slide(source, "--boundary", "slide", option, text)
                self.assertAlmostEqual(report["options"]["max_deviation"], value, places=12)
                surface = report["surface"]
                self.assertTrue(surface["max_deviation_kept"])
                self.assertLessEqual(surface["deviation"], value)
                self.assertAlmostEqual(surface["deviation"], surface["mean_boundary_edge"] * max(
                    surface["distance_new_to_old"], surface["distance_old_to_new"]))
                mean = surface["distance_new_to_old"]
                self.assertLess(mean, 0.5 * free["surface"]["distance_new_to_old"])
        self.refused("optimize", source, "-o", self.path("o.mesh"), "--boundary", "slide", "--max-deviation",
                     said=["--max-deviation"])
        for text in ("-1", "x", "0.1x", "0.1%%", "%", "nan", "inf", "-5%", "1e999"):
            self.refused("optimize", source, "-o", self.path("o.mesh"), "--boundary", "slide", "--max-deviation=" + text,
                         said=["--max-deviation", f"'{text}'", "%"])

    def test_a_bound_without_sliding_changes_nothing(self):
        source = self.put("in.mesh", cube(6, jitter=0.2))
        for effort in ("standard", "best"):
            self.run_cli("optimize", source, "-o", self.path("plain.mesh"), "--effort", effort, "--quiet")
            done = self.run_cli("optimize", source, "-o", self.path("bound.mesh"), "--effort", effort, "--max-deviation", "1%", "--quiet")
            self.assertIn("--max-deviation 1% has no effect without --boundary slide", done.stderr)
            self.assertEqual(self.read_bytes("plain.mesh"), self.read_bytes("bound.mesh"))

    def test_lists_that_the_result_lacks_are_named(self):
        source = self.put("in.mesh", with_triangles(cube(3), [((0, 21, 63), 0)]))
        done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--quiet")
        self.assertIn("1 listed triangles constrain nothing and are dropped", done.stderr)
        self.assertIn("name cell data that have them (--tags)", done.stderr)

    def test_nosurf_is_a_fixed_boundary(self):
        mesh = cube(4)
        report, _ = self.slide(self.put("in.mesh", mesh), "-nosurf")
        self.assertEqual(report["options"]["boundary"], "fixed")
        after = Mesh.read(self.path("out.mesh"))
        for v in {v for face in mesh.boundary_faces() for v in face}:
            self.assertEqual(after.points[v], mesh.points[v])

    def test_energy(self):
        source = self.put("in.mesh", unflipped(cube(4)))
        for energy, key, other in (("shape", "shape_sum", "eta_sum"), ("harmonic", "eta_sum", "shape_sum")):
            report, _ = self.slide(source, "--energy", energy)
            self.assertEqual(report["options"]["energy"], energy)
            self.assertAlmostEqual(report["optimization"]["energy_after"] / report["after"][key], 1, places=9)
            self.assertNotAlmostEqual(report["optimization"]["energy_after"] / report["after"][other], 1, places=2)

    def test_another_volume_is_a_warning(self):
        # Without features the edges of the cube become round.
        source = self.put("in.mesh", cube(3))
        words = ("optimize", source, "-o", self.path("out.mesh"), "--boundary", "slide", "--feature-angle", "180")
        self.assertIn("--boundary slide has changed the volume of a region by", self.run_cli(*words).stderr)
        self.assertEqual(self.run_cli(*words, "--max-deviation", "0.1%").stderr, "")

    def test_same_bytes_for_any_number_of_threads(self):
        source = self.put("in.mesh", bent(cube(6)))
        for threads in (1, 2, 3):
            self.run_cli("optimize", source, "-o", self.path(f"{threads}.mesh"), "--threads", threads, "--quiet",
                         "--boundary", "slide", "--max-deviation", "1%")
        self.assertEqual(self.read_bytes("2.mesh"), self.read_bytes("1.mesh"))
        self.assertEqual(self.read_bytes("3.mesh"), self.read_bytes("1.mesh"))

    def test_effort(self):
        source = self.put("in.mesh", cube(5, 0.25))
        runs = {}
        for effort in ("fast", "standard"):
            self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--effort", effort, "--report", self.path("r.json"))
            report = json.loads(self.read_bytes("r.json"))
            runs[effort] = report["optimization"]
            self.assertEqual(report["options"]["effort"], effort)
            self.assertGreaterEqual(report["after"]["dihedral_min_deg"], report["before"]["dihedral_min_deg"])
        self.assertEqual(runs["fast"]["worst_rounds"], [])
        self.assertLessEqual(len(runs["fast"]["sweeps"]), len(runs["standard"]["sweeps"]))

    def test_best_effort_inserts_and_removes_vertices_unless_they_are_kept(self):
        mesh = unflipped(cube(6, 0.25))
        source = self.put("in.mesh", mesh)
        angles = {}
        for name, options in (("default", []), ("best", ["--effort", "best"]),
                              ("kept", ["--effort", "best", "--keep-vertices"])):
            text = self.run_cli("optimize", source, "-o", self.path("out.mesh"), *options, "--report",
                                self.path("r.json"), "-v", "2").stdout
            report = json.loads(self.read_bytes("r.json"))
            run = report["optimization"]
            after = Mesh.read(self.path("out.mesh"))
            change = run["vertices_inserted"] - run["vertices_removed"]
            self.assertEqual(len(after.points), len(mesh.points) + change)
            self.assertEqual(sum(w["inserted"] for w in run["worst_rounds"]), run["vertices_inserted"])
            self.assertEqual(sum(w["removed"] for w in run["worst_rounds"]), run["vertices_removed"])
            self.assertEqual(run["vertices_inserted"] > 0, name == "best")
            self.assertEqual(" vertices inserted, " in text, name == "best")
            self.assertEqual(report["options"]["keep_vertices"], name == "kept")
            self.assertGreater(min(after.volumes()), 0)
            self.assertAlmostEqual(sum(after.volumes()), 1)
            angles[name] = report["after"]["dihedral_min_deg"]
            if name == "best":
                compared = self.run_cli("compare", source, self.path("out.mesh")).stdout
                self.assertIn(f"{len(mesh.points)} -> {len(after.points)}", compared)
                self.assertNotIn("NO", compared)
        self.assertGreater(angles["best"], angles["default"])
        self.assertGreaterEqual(angles["kept"], angles["default"])

    def test_vertices_of_the_surface_are_inserted_and_removed_if_they_may(self):
        mesh = unflipped(cube(6, 0.2))
        source = self.put("in.mesh", with_triangles(mesh, [(f, 4) for f in sorted(mesh.boundary_faces())]))
        faces = {}
        for name, options in (("edit", ["--effort", "best", "--surface-vertices", "edit"]), ("auto", ["--effort", "best"]),
                              ("keep", ["--effort", "best", "--surface-vertices", "keep"])):
            self.run_cli("optimize", source, "-o", self.path("out.mesh"), *options)
            after = Mesh.read(self.path("out.mesh"))
            self.assertAlmostEqual(sum(after.volumes()), 1)
            words = (self.folder / "out.mesh").read_text().split()
            at = words.index("Triangles") + 1
            rows = [words[at + 1 + 4 * i:at + 5 + 4 * i] for i in range(int(words[at]))]
            self.assertEqual(after.boundary_faces(), {tuple(sorted(int(v) - 1 for v in row[:3])) for row in rows})
            self.assertEqual({row[3] for row in rows}, {"4"})
            self.assertEqual(len(rows), len(after.boundary_faces()))
            faces[name] = len(rows)
            compared = self.run_cli("compare", source, self.path("out.mesh")).stdout
            self.assertNotIn("NO", compared)
        self.assertEqual(faces["edit"], faces["auto"])
        self.assertNotEqual(faces["edit"], faces["keep"])
        self.assertEqual(faces["keep"], len(mesh.boundary_faces()))
        text = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--surface-vertices", "edit", "--boundary", "fixed").stderr
        self.assertIn("--surface-vertices edit edits inner vertices only with --boundary fixed", text)

    def test_vertices_of_the_surface_are_inserted_and_removed_within_a_bound(self):
        mesh = bent(cube(5))
        source = self.put("in.mesh", mesh)
        faces = {}
        for word in ("keep", "edit"):
            report, text = self.slide(source, "--boundary", "slide", "--effort", "best", "--surface-vertices", word, "--max-deviation", "1%")
            self.assertTrue(report["surface"]["max_deviation_kept"])
            self.assertNotIn("warning", text)
            faces[word] = len(Mesh.read(self.path("out.mesh")).boundary_faces())
        self.assertEqual(faces["keep"], len(mesh.boundary_faces()))
        self.assertNotEqual(faces["edit"], faces["keep"])

    def test_freeze(self):
        mesh = bent(cube(4))
        mesh.tet_tags = [1 if t < len(mesh.tets) // 2 else 2 for t in range(len(mesh.tets))]
        faces = sorted(mesh.boundary_faces())
        low = [f for f in faces if max(mesh.points[v][0] for v in f) < 0.01]
        source = self.put("in.mesh", with_triangles(mesh, [(f, 7 if f in low else 8) for f in faces]))

        def kept(vertices):
            after = Mesh.read(self.path("out.mesh"))
            self.assertTrue(all(after.points[v] == mesh.points[v] for v in vertices))
            self.assertNotEqual(after.points, mesh.points)

        first = {v for t, tag in zip(mesh.tets, mesh.tet_tags) if tag == 1 for v in t}
        patch = {v for f in low for v in f}
        for options, regions, patches, vertices in (
                (["--freeze", "tag=1"], [1], [], first), (["--freeze", "patch=7"], [], [7], patch),
                (["--freeze", "tag=1,patch=7"], [1], [7], first | patch),
                (["--freeze", "tag=1", "--freeze", "patch=7,8"], [1], [7, 8], first | {v for f in faces for v in f})):
            for boundary in ("slide", "preserve"):
                report, _ = self.slide(source, "--boundary", boundary, *options)
                self.assertEqual(report["options"]["frozen_regions"], regions)
                self.assertEqual(report["options"]["frozen_patches"], patches)
                kept(vertices)
        os.remove(self.path("out.mesh"))
        for text, said in (("tag=9", "no region 9; it has 1, 2"), ("patch=9", "no patch 9; it has 7, 8"),
                           ("tag=1,patch=1", "no patch 1"), ("tag=1,9", "no region 9"), ("tag=steel", 'no region "steel"')):
            self.refused("optimize", source, "-o", self.path("out.mesh"), "--freeze", text, said=[said])
        for text in ("1", "tag=", "colour=1", "tag=1,"):
            self.refused("optimize", source, "-o", self.path("out.mesh"), "--freeze", text,
                         said=["--freeze", f"'{text}'", "tag=1,2"])
        self.assertNotIn("out.mesh", self.files())

    def test_open_boundaries(self):
        mesh = cube(4)
        inside = sorted({tuple(sorted(t[:3])) for t in mesh.tets} - mesh.boundary_faces())[:6]
        source = self.put("in.mesh", with_triangles(mesh, [(f, 5) for f in inside]))

        def triangles(*options):
            _, text = self.slide(source, *options)
            counts = json.loads(self.run_cli("info", "--json", self.path("out.mesh")).stdout)["counts"]
            return counts["triangles"], "are dropped" in text
        self.assertEqual(triangles(), (6, False))
        self.assertEqual(triangles("--open-boundaries"), (6, False))
        self.assertEqual(triangles("--no-open-boundaries"), (0, True))
        self.assertEqual(triangles("--no-open-boundaries", "--freeze", "patch=5"), (6, False))

    def test_lists_that_hold_too_much(self):
        mesh = cube(6)
        faces = sorted(mesh.boundary_faces())
        edges = sorted({tuple(sorted((f[i], f[j]))) for f in faces for i, j in ((0, 1), (0, 2), (1, 2))})
        vertices = sorted({v for f in faces for v in f})
        lists = ["Edges", str(len(edges))] + [f"{a + 1} {b + 1} 1" for a, b in edges]
        lists += ["Corners", str(len(vertices))] + [str(v + 1) for v in vertices]
        source = self.put("in.mesh", mesh.text().replace("End", "\n".join(lists + ["End"])))
        for boundary in ("preserve", "slide"):
            report, text = self.slide(source, "--boundary", boundary)
            run = report["optimization"]
            self.assertEqual(run["vertices_fixed"], 8)
            self.assertEqual(run["corners_not_held"], len(vertices) - 8)
            self.assertEqual(run["edges_not_held"], len(edges))
            self.assertIn("listed corners lie where", text)
            self.assertIn("tagged edges are too many", text)

    def test_bad_values(self):
        source = self.put("in.mesh", cube(2))
        for options, said in (
                (["--boundary", "slide", "--feature-angle", "-1"], ["--feature-angle -1 is out of range"]),
                (["--max-growth", "0.9"], ["--max-growth 0.9 is out of range: it must be 1 to 100"]),
                (["--boundary", "slide", "--feature-angle", "0"], ["--feature-angle 0 is out of range: it must be above 0 and"]),
                (["--boundary", "slide", "--feature-angle", "181"], ["--feature-angle"]),
                (["--boundary", "slide", "-ar"], ["--feature-angle"]),
                (["--boundary", "glide"], ["--boundary", "slide"]),
                (["--energy", "elastic"], ["--energy", "shape"]),
                (["--effort", "heroic"], ["--effort", "fast", "standard", "best"]),
                (["-nosurf", "--boundary", "slide"], ["--boundary"])):
            self.refused("optimize", source, "-o", self.path("out.mesh"), *options, said=said)
            self.assertEqual(self.files(), ["in.mesh"])

    def test_targets(self):
        source = self.put("in.mesh", cube(5, 0.25, two_regions=True))

        def run(*options, code):
            text = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--report", self.path("r.json"), *options,
                                code=code).stdout
            self.assert_improved(Mesh.read(source), Mesh.read(self.path("out.mesh")))
            return json.loads(self.read_bytes("r.json")), text

        report, text = run("--target-dihedral", "5", "--target-quality", "radius_ratio=20", code=0)
        self.assertEqual(report["options"]["targets"], [{"measure": "min_dihedral_deg", "value": 5.0},
                                                        {"measure": "radius_ratio", "value": 20.0}])
        self.assertEqual([t["met"] for t in report["optimization"]["targets"]], [True, True])
        self.assertIn("min_dihedral_deg >= 5: met by all", text)
        self.assertIn("radius_ratio <= 20: met by all", text)
        easy = self.read_bytes("out.mesh")

        report, text = run("--target-quality", "mean_ratio=0.8", "--target-dihedral", "5", "--target-quality", "1.1",
                           "aspect_ratio", code=1)
        self.assertEqual(self.read_bytes("out.mesh"), easy)
        by_name = {t["measure"]: t for t in report["optimization"]["targets"]}
        self.assertEqual(set(by_name), {"min_dihedral_deg", "mean_ratio", "aspect_ratio"})
        self.assertTrue(by_name["min_dihedral_deg"]["met"])
        missed = by_name["mean_ratio"]
        self.assertFalse(missed["met"])
        self.assertEqual(sum(missed["held_by"].values()), missed["missed"])
        self.assertIn(f"mean_ratio >= 0.8: NOT met by {missed['missed']} of {missed['tetrahedra']}", text)
        worst = missed["worst"][0]
        self.assertEqual(worst["value"], report["after"]["measures"]["mean_ratio"]["min"])
        self.assertIn(worst["held_by"], text)
        self.assertIn(f"  {worst['tetrahedron']} ", text)

        # The surface's own angle: a lone tetrahedron, cut off a cube.
        corner = self.put("corner.mesh", Mesh([(0., 0., 0.), (1., 0., 0.), (0., 1., 0.), (0., 0., 1.)], [(0, 1, 2, 3)]))
        text = self.run_cli("optimize", corner, "-o", self.path("out.mesh"), "--target-dihedral", "60", "--report",
                            self.path("r.json"), code=1).stdout
        worst = json.loads(self.read_bytes("r.json"))["optimization"]["targets"][0]["worst"][0]
        self.assertEqual(worst["held_by"], "angle of the surface")
        self.assertAlmostEqual(worst["surface_angle_deg"], 54.7356, places=4)
        self.assertIn(f"surface: 54.736 deg at edge {worst['edge'][0]} {worst['edge'][1]}", text)
        os.remove(self.path("out.mesh"))

        for options, said in ((["--target-dihedral", "75"], ["min_dihedral_deg", "70.528"]),
                              (["--target-dihedral", "steep"], ["--target-dihedral"]),
                              (["--target-quality", "0.5", "beauty"], ["--target-quality", "'beauty'", "mean_ratio", "q_h"]),
                              (["--target-quality", "0.5"], ["--target-quality", "'0.5' is not a measure and a number", "mean_ratio=0.2"]),
                              (["--target-quality", "beauty=0.5"], ["--target-quality", "'beauty'", "mean_ratio", "q_h"]),
                              (["--target-quality", "0.9", "radius_ratio"], ["radius_ratio", "1 or more"]),
                              (["--target-quality", "170", "gamma"], ["gamma", "at most 1"])):
            self.refused("optimize", source, "-o", self.path("out.mesh"), *options, said=said)
        self.assertNotIn("out.mesh", self.files())

    def test_help_names_the_options(self):
        text = self.run_cli("optimize", "--help").stdout
        for option in ("--boundary", "slide", "--feature-angle", "--max-deviation", "--freeze", "--open-boundaries",
                       "--no-open-boundaries", "--energy", "harmonic", "--effort", "best", "--keep-vertices", "--target-dihedral", "--target-quality",
                       "--boundary-flips", "--no-boundary-flips"):
            self.assertIn(option, text)


if __name__ == "__main__":
    cli_case.main(__doc__)
