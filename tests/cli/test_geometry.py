# SPDX-License-Identifier: Apache-2.0
"""CAD geometry on the command line. Run: see cli_case.py; $TETUNE_MAKE_PARTS is the program that writes the CAD files."""

import itertools
import json
import math
import os
import random
import re
import subprocess
import tempfile
from pathlib import Path

import cli_case
from cli_case import CliTest, Mesh, cube, msh_text, with_triangles

MAKE_PARTS = os.environ.get("TETUNE_MAKE_PARTS", "")
PARTS = tempfile.TemporaryDirectory(prefix="tetune_parts_")


def radial(p):
    """The square or cube [-1, 1] onto the disk or ball of radius 1, the boundary exactly to rounding."""
    largest, length = max(map(abs, p)), math.hypot(*p)
    return tuple(x * largest / length for x in p) if length > 0 else p


def cylinder(n=6):
    mesh = cube(n, jitter=0)
    return Mesh([(*radial((2 * x - 1, 2 * y - 1)), z) for x, y, z in mesh.points], mesh.tets)


def ball(n=6):
    mesh = cube(n, jitter=0)
    return Mesh([radial((2 * x - 1, 2 * y - 1, 2 * z - 1)) for x, y, z in mesh.points], mesh.tets)


def prism(n=8):
    """On the curve that the spline of the CAD file interpolates, so that vertices are a little off the spline."""
    def point(x, y, z):
        r = 1 + 0.2 * math.hypot(x, y) * math.cos(3 * math.atan2(y, x))
        return (r * x, r * y, z)
    mesh = cylinder(n)
    return Mesh([point(*p) for p in mesh.points], mesh.tets)


def boxes(n=6):
    mesh = cube(n)
    points = [(0.5 if i % (n + 1) == n // 2 else x, y, z) for i, (x, y, z) in enumerate(mesh.points)]
    tags = [1 if max(points[v][0] for v in tet) <= 0.5 else 2 for tet in mesh.tets]
    return Mesh(points, mesh.tets, None, tags)


def plate(n=4, low=0.0, high=0.02):
    mesh = cube(n, jitter=0)
    return Mesh([(x, y, low + (high - low) * z) for x, y, z in mesh.points], mesh.tets)


def triangles_of(path):
    """Vertices, counted from 0, and tag of each listed triangle of a .mesh file."""
    words = Path(path).read_text().split()
    at = words.index("Triangles") + 1
    rows = [list(map(int, words[at + 1 + 4 * i:at + 5 + 4 * i])) for i in range(int(words[at]))]
    return sorted((tuple(v - 1 for v in row[:3]), row[3]) for row in rows)


def damage(whole, rng):
    """The bytes of a file cut off, with other bytes or digits at ten places, or without a line."""
    kind = rng.randrange(4)
    if kind == 0:
        return whole[:rng.randrange(len(whole))]
    if kind == 1:
        lines = whole.split(b"\n")
        del lines[rng.randrange(len(lines))]
        return b"\n".join(lines)
    places = range(len(whole)) if kind == 2 else [i for i, byte in enumerate(whole) if chr(byte).isdigit()]
    damaged = bytearray(whole)
    for i in rng.sample(places, 10):
        damaged[i] = rng.randrange(256) if kind == 2 else ord(str(rng.randrange(10)))
    return bytes(damaged)


def radius_error(points):
    return max(abs(math.hypot(*p) - 1) for p in points)


class Geometry(CliTest):
    def setUp(self):
        super().setUp()
        if not MAKE_PARTS:
            self.skipTest("built without OpenCASCADE: install libocct-data-exchange-dev")
        if not os.listdir(PARTS.name):
            subprocess.run([MAKE_PARTS, PARTS.name], check=True, stdout=subprocess.DEVNULL)

    def part(self, name):
        return os.path.join(PARTS.name, name)

    def match(self, mesh, part, *args):
        return json.loads(self.run_cli("info", mesh, "--geometry", self.part(part), "--json", *args).stdout)["geometry"]

    def optimize(self, mesh, part, output, *args):
        report = self.path("report.json")
        self.run_cli("optimize", mesh, "-o", output, "--geometry", self.part(part), "--boundary", "slide", "--report",
                     report, *args)
        return json.loads(Path(report).read_text())

    def test_each_vertex_and_triangle_is_on_its_entity(self):
        mesh = cylinder()
        source = self.put("in.mesh", mesh)
        on_side = [abs(math.hypot(x, y) - 1) < 1e-9 for x, y, _ in mesh.points]
        on_cap = [z in (0, 1) for _, _, z in mesh.points]
        for part in ("cylinder.step", "cylinder.brep", "cylinder.igs"):
            g = self.match(source, part, "-o", self.path("out.mesh"))
            # A seam is no edge, and its ends are no vertices of the shape.
            self.assertEqual(g["mesh_vertices_on_vertices"], 0)
            self.assertEqual(g["mesh_vertices_on_edges"], sum(a and b for a, b in zip(on_side, on_cap)))
            self.assertEqual(g["mesh_vertices_on_faces"], sum(a != b for a, b in zip(on_side, on_cap)))
            self.assertEqual(g["mesh_vertices_without_entity"] + g["ambiguous_triangles"], 0)
            # IGES has fewer digits.
            self.assertLess(g["largest_distance"], 1e-5 if part.endswith("igs") else 1e-9)
            rows = triangles_of(self.path("out.mesh"))
            faces = {}
            for vertices, tag in rows:
                heights = {mesh.points[v][2] for v in vertices}
                faces.setdefault(heights.pop() if len(heights) == 1 else "side", set()).add(tag)
            self.assertEqual(len(rows), 12 * 6 * 6)
            self.assertEqual(sorted(map(len, faces.values())), [1, 1, 1])
            self.assertEqual(len(set.union(*faces.values())), 3)

    def test_surfaces_of_an_msh_file_are_taken_where_distances_agree(self):
        self.match(self.put("exact.mesh", plate()), "plate.step", "-o", self.path("faces.mesh"))
        faces = triangles_of(self.path("faces.mesh"))
        self.assertEqual({tag for _, tag in faces}, {1, 2, 3, 4, 5, 6})
        # Top and bottom of this mesh are about as far from the top of the part as from the bottom.
        middle = plate(low=0.0095, high=0.0105)

        def match(tag_of):
            tagged = with_triangles(middle, [(t, tag_of(tag)) for t, tag in faces])
            self.run_cli("convert", self.put("in.mesh", tagged), "-o", self.path("in.msh"))
            return self.match(self.path("in.msh"), "plate.step", "-o", self.path("out.mesh"))

        right = match(lambda tag: tag)
        self.assertEqual((right["surfaces_of_the_file"], right["surfaces_with_other_numbers"]), (6, 0))
        self.assertEqual(right["ambiguous_triangles"], 0)
        self.assertEqual(triangles_of(self.path("out.mesh")), faces)
        other = match(lambda tag: tag % 6 + 1)
        self.assertEqual((other["surfaces_of_the_file"], other["surfaces_with_other_numbers"]), (6, 6))
        self.assertGreater(other["ambiguous_triangles"], 0)
        found = triangles_of(self.path("out.mesh"))
        self.assertTrue(all(tag in (0, face) for (_, tag), (_, face) in zip(found, faces)))
        without = self.match(self.put("in.mesh", middle), "plate.step")
        self.assertEqual(without["surfaces_of_the_file"], 0)
        self.assertEqual(without["ambiguous_triangles"], other["ambiguous_triangles"])

    def test_vertices_end_on_the_geometry(self):
        for name, mesh in (("cylinder", cylinder()), ("ball", ball()), ("spline", prism()), ("boxes", boxes())):
            source, output = self.put("in.mesh", mesh), self.path("out.mesh")
            r = self.optimize(source, f"{name}.step", output)
            g = r["geometry"]
            self.assertEqual(g["rounds"], 1, name)
            self.assertLess(g["distance_after"]["vertices"]["largest"], 2e-9, name)
            self.assertLess(self.match(output, f"{name}.step")["largest_distance"], 2e-9, name)
            self.assertGreater(r["after"]["mean_ratio"], r["before"]["mean_ratio"], name)
            self.assertGreaterEqual(r["after"]["dihedral_min_deg"], r["before"]["dihedral_min_deg"], name)
            result = Mesh.read(output)
            self.assertGreater(min(result.volumes()), 0)
            # The face between the boxes is in the file twice.
            self.assertEqual(len(g["distance_after"]["faces"]), 11 if name == "boxes" else g["faces"], name)
            if name == "ball":
                self.assertLess(radius_error([result.points[v] for face in result.boundary_faces() for v in face]), 1e-9)
            if name == "spline":
                self.assertGreater(g["distance_before"]["vertices"]["largest"], 1e-5)
                self.assertGreater(g["vertices_snapped"], 0)

    def test_mid_side_nodes_are_on_the_geometry(self):
        for part, mesh in (("ball", ball(4)), ("cylinder", cylinder(4))):
            output = self.path("out.msh")
            # Boundary faces are listed, so that their mid-side nodes can be found in the file.
            source = self.put("in.mesh", with_triangles(mesh, [(f, 1) for f in sorted(mesh.boundary_faces())]))
            done = self.run_cli("convert", source, "-o", output, "--order", "2", "--msh", "2.2-text", "--geometry",
                                self.part(f"{part}.step"))
            self.assertNotIn("stay straight", done.stderr)
            straightened = {frozenset(m.split()) for m in re.findall(r"^ +(\d+ \d+): ", done.stderr, re.M)}
            curved = json.loads(self.run_cli("info", output, "--json").stdout)["quality"]["curved"]
            self.assertEqual(curved["valid"], curved["tetrahedra"])
            self.assertGreater(curved["tetrahedra"], 100)
            self.refused("optimize", output, "-o", self.path("slid.msh"), "--boundary", "slide", "--geometry",
                         self.part(f"{part}.step"), said=["order 1 first (tetune convert IN OUT --order 1)"])
            lines = Path(output).read_text().splitlines()
            at = lines.index("$Nodes") + 1
            rows = [line.split() for line in lines[at + 1:at + 1 + int(lines[at])]]
            nodes = {row[0]: tuple(map(float, row[1:])) for row in rows}
            elements = [line.split() for line in lines[lines.index("$Elements") + 2:lines.index("$EndElements")]]
            triangles = [row[-6:] for row in elements if row[1] == "9"]
            self.assertEqual(len(triangles), len(mesh.boundary_faces()))
            middles = {frozenset(t[k:k + 2] if k < 2 else (t[2], t[0])): t[3 + k] for t in triangles for k in range(3)}
            self.assertLess(len(straightened), len(middles) / 3)
            for n in (n for edge, n in middles.items() if edge not in straightened):
                x, y, z = nodes[n]
                if part == "ball":
                    self.assertLess(abs(math.hypot(x, y, z) - 1), 1e-9)
                else:
                    self.assertLess(min(abs(math.hypot(x, y) - 1), abs(z), abs(z - 1)), 1e-9)

    def test_corners_and_interfaces_stay(self):
        mesh = boxes()
        source, output = self.put("in.mesh", mesh), self.path("out.mesh")
        g = self.optimize(source, "boxes.step", output)["geometry"]
        self.assertEqual(g["mesh_vertices_on_vertices"], 12)
        new = Mesh.read(output)
        for old, moved in zip(mesh.points, new.points):
            if all(c in (0, 0.5, 1) for c in old) and old[1] != 0.5 and old[2] != 0.5:
                self.assertEqual(old, moved)
            self.assertEqual(old[0] == 0.5, moved[0] == 0.5)

    def test_the_result_does_not_depend_on_the_number_of_threads(self):
        source = self.put("in.mesh", prism())
        for threads in (1, 3):
            self.optimize(source, "spline.step", self.path(f"{threads}.mesh"), "--threads", threads)
        self.assertEqual(self.read_bytes("1.mesh"), self.read_bytes("3.mesh"))

    def test_listed_triangles_and_tags_are_the_callers(self):
        mesh = cylinder()
        bottom = [f for f in mesh.boundary_faces() if all(mesh.points[v][2] == 0 for v in f)]
        source = self.put("in.mesh", with_triangles(mesh, [(f, 7 if mesh.points[f[0]][0] < 0 else 8) for f in sorted(bottom)]))
        output = self.path("out.mesh")
        self.optimize(source, "cylinder.step", output)
        words = Path(output).read_text().split()
        at = words.index("Triangles")
        count = int(words[at + 1])
        self.assertEqual(count, len(bottom))
        self.assertEqual({words[at + 5 + 4 * i] for i in range(count)}, {"7", "8"})

    def test_without_snap_vertices_may_stay_off(self):
        source = self.put("in.mesh", prism())
        g = self.optimize(source, "spline.step", self.path("out.mesh"), "--snap", "no")["geometry"]
        self.assertEqual((g["snapped"], g["vertices_snapped"]), (0, 0))
        self.assertEqual(g["rounds"], 1)

    def test_a_mesh_of_another_part_or_unit_is_refused(self):
        source, output = self.put("in.mesh", cylinder()), self.path("out.mesh")
        slide = ("optimize", source, "-o", output, "--boundary", "slide", "--geometry")
        self.refused(*slide, self.part("ball.step"), said=["do not belong together", "the farthest by"])
        self.assertNotIn("out.mesh", self.files())
        inches = Mesh([tuple(x / 25.4 for x in p) for p in cylinder().points], cylinder().tets)
        small = self.put("small.mesh", inches)
        for command in (("info", small), ("convert", small, self.path("out.msh"), "--order", "2")):
            self.refused(*command, "--geometry", self.part("cylinder_inch.stp"),
                         said=["tetune: " + small + ": ", "--geometry-unit 25.4 (inch)"])
        self.run_cli("info", small, "--geometry", self.part("cylinder_inch.stp"), "--geometry-unit", "inch")
        # The unit is checked before the mesh is read.
        absent = self.path("absent.mesh")
        for command in (("info", absent), ("convert", absent, self.path("out.msh"), "--order", "2")):
            self.refused(*command, "--geometry", self.part("ball.step"), "--geometry-unit", "furlong", said=["furlong"])

    def test_growth_is_that_of_all_runs(self):
        source = self.put("in.mesh", cylinder(4))
        report = self.optimize(source, "cylinder.step", self.path("out.mesh"), "--effort", "best", "--max-growth", "1.02")["optimization"]
        self.assertLessEqual(report["tetrahedra_after"], 1.02 * report["tetrahedra_before"])

    def test_required_triangles_inside_a_region_stay(self):
        mesh = cylinder(4)
        surface = mesh.boundary_faces()
        row = mesh.tets[len(mesh.tets) // 2]
        inner = [face for face in itertools.combinations(row, 3) if tuple(sorted(face)) not in surface][:2]
        listed = with_triangles(mesh, [(face, 0) for face in inner])
        source = self.put("in.mesh", listed.replace("End", "RequiredTriangles\n1\n1\nEnd"))
        report = self.optimize(source, "cylinder.step", self.path("out.mesh"))["optimization"]
        points = Mesh.read(self.path("out.mesh")).points
        rows = triangles_of(self.path("out.mesh"))
        self.assertEqual([sorted(points[v] for v in face) for face, _ in rows], [sorted(mesh.points[v] for v in inner[0])])
        self.assertIn("RequiredTriangles\n1\n1\n", Path(self.path("out.mesh")).read_text())
        self.assertEqual(report["triangles_dropped"], 1)

    def test_vertices_that_slide_do_not_hold_elements(self):
        self.run_cli("optimize", self.put("in.mesh", ball(3)), "-o", self.path("out.mesh"), "--geometry", self.part("ball.step"),
                     "--boundary", "slide", "--no-flips", "--target-quality", "mean_ratio=0.99", "--report",
                     self.path("report.json"), code=1)
        report = json.loads(Path(self.path("report.json")).read_text())
        held_by = report["optimization"]["targets"][0]["held_by"]
        self.assertEqual(report["optimization"]["vertices_fixed"], 0)
        self.assertEqual(held_by["no vertex may move"], 0)
        self.assertGreater(held_by["all four vertices on the surface"], 0)

    def test_options_without_effect_are_named(self):
        source = self.put("in.mesh", cylinder(3))
        done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--snap", "no", "--geometry-unit", "m", "--quiet")
        for option in ("--snap", "--geometry-unit"):
            self.assertIn(f"warning: {option} has no effect without --geometry", done.stderr)
        for command in (("info", source), ("convert", source, "-o", self.path("out.msh"), "--order", "2")):
            done = self.run_cli(*command, "--geometry-unit", "m")
            self.assertIn("warning: --geometry-unit has no effect without --geometry", done.stderr)
        done = self.run_cli("convert", source, "-o", self.path("out.msh"), "--order", "2", "--geometry",
                            self.part("cylinder.step"), "--feature-angle", "5")
        self.assertIn("warning: --feature-angle has no effect with --geometry", done.stderr)

    def test_warnings_are_of_the_options_and_the_data_that_were_given(self):
        mesh = cylinder(3)
        mesh.points = [(0.999 * x, 0.999 * y, z) for x, y, z in mesh.points]
        data = "".join(f"{i + 1} {i / 8}\n" for i in range(len(mesh.points)))
        n = len(mesh.points)
        data = f"$NodeData\n1\n\"heat\"\n1\n0.0\n3\n0\n1\n{n}\n{data}$EndNodeData\n"
        source = self.put("in.msh", msh_text(mesh.points, [(4, 1, tet) for tet in mesh.tets], data=data))
        moved = "the values of heat moved with their vertices"
        report = self.optimize(source, "cylinder.step", self.path("out.msh"), "--effort", "best", "--no-boundary-flips")
        self.assertEqual([w.split(";")[0] for w in report["warnings"]], [moved])
        # Vertices move onto the geometry alone.
        report = self.optimize(source, "cylinder.step", self.path("out.msh"), "--max-iterations", "0")
        self.assertGreater(report["geometry"]["vertices_snapped"], 0)
        self.assertEqual([w.split(";")[0] for w in report["warnings"]], [moved])

    def test_vertices_that_are_held_off_the_geometry_are_a_warning(self):
        mesh = cylinder(3)
        mesh.points = [(0.999 * x, 0.999 * y, z) for x, y, z in mesh.points]
        required = [i + 1 for i, (x, y, z) in enumerate(mesh.points) if math.hypot(x, y) > 0.99 and z == 0]
        self.assertGreater(len(required), 0)
        text = "\n".join(["RequiredVertices", str(len(required)), *map(str, required), "End"])
        source = self.put("in.mesh", mesh.text().replace("End", text))
        said = f"{len(required)} vertices stay off the geometry, by up to 0.001: required entities, --freeze or"
        report = self.optimize(source, "cylinder.step", self.path("out.mesh"))
        self.assertEqual([w[:len(said)] for w in report["warnings"]], [said])
        done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--geometry", self.part("cylinder.step"),
                            "--boundary", "slide", "-v", "0")
        self.assertIn("warning: " + said, done.stderr)

    def test_options_that_have_no_meaning_with_a_geometry_are_refused(self):
        source, part = self.put("in.mesh", cylinder(3)), self.part("cylinder.step")
        self.refused("optimize", source, "-o", self.path("out.mesh"), "--geometry", part, said=["--boundary slide"])
        for more in (("--max-deviation", "0.1"), ("--untangle",), ("--data", "conserve"), ("--only-below", "10"),
                     ("--surface-vertices", "edit")):
            self.refused("optimize", source, "-o", self.path("out.mesh"), "--geometry", part, "--boundary", "slide", *more,
                         said=["on a geometry"])
        self.refused("info", source, "-o", self.path("out.mesh"), said=["--geometry"])
        self.refused("convert", source, self.path("out.msh"), "--geometry", part, said=["--order 2"])
        self.refused("convert", source, self.path("out.msh"), "--order", "2", "--geometry", part, "--surface", source,
                     said=["exclude"])
        self.refused("info", source, "--geometry", source, said=["ending"])
        self.refused("info", source, "--geometry", self.path("none.step"), said=["none.step"])

    def test_damaged_files_and_foreign_meshes_have_a_message(self):
        """TETUNE_CORRUPT: the number of files; a few by default."""
        meshes = [self.put("cylinder.mesh", cylinder(3)), self.put("ball.mesh", ball(3))]
        rng = random.Random(1)
        for i in range(int(os.environ.get("TETUNE_CORRUPT", 16))):
            part = ("cylinder.step", "cylinder.brep", "cylinder.igs", "ball.step")[i % 4]
            damaged = self.path("damaged" + Path(part).suffix)
            Path(damaged).write_bytes(damage(Path(self.part(part)).read_bytes(), rng))
            source = rng.choice(meshes)
            done = subprocess.run([cli_case.TETUNE, "info", source, "--geometry", damaged], capture_output=True, text=True,
                                  timeout=cli_case.HANG)
            self.assertIn(done.returncode, (0, 2), done.stderr)
            if done.returncode == 2:
                self.assertTrue("damaged." in done.stderr or "belong together" in done.stderr, done.stderr)


if __name__ == "__main__":
    cli_case.main(__doc__)
