# SPDX-License-Identifier: Apache-2.0
"""The command line as a process: what it writes, prints and returns.

Run:  python3 test_cli.py path/to/tetune [names of tests]
"""

import csv
import json
import math
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

TETUNE = ""

TRACE_COLUMNS = ["event", "iteration", "pass", "energy_before", "decrease", "gradient_norm", "moved", "active",
                 "evaluated", "flips_2_3", "flips_3_2", "edge_removals", "boundary_flips", "seconds"]
QUALITY_KEYS = {"tetrahedra", "dihedral_min_deg", "dihedral_1_percent_deg", "dihedral_5_percent_deg",
                "dihedral_mean_deg", "dihedral_max_deg", "eta_max", "eta_95_percent", "eta_sum", "shape_sum", "mean_ratio",
                "mean_ratio_min", "volume", "worst_tetrahedron", "dihedral_histogram_10_deg", "measures", "worst"}
MEASURES = ["min_dihedral_deg", "max_dihedral_deg", "mean_ratio", "sicn", "gamma", "scaled_jacobian", "radius_ratio",
            "aspect_ratio", "q_h"]


class Mesh:
    """Vertices and tetrahedra (counted from 0) with their tags."""

    def __init__(self, points, tets, point_tags=None, tet_tags=None):
        self.points = points
        self.tets = tets
        self.point_tags = point_tags or [0] * len(points)
        self.tet_tags = tet_tags or [0] * len(tets)

    def text(self):
        lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(self.points))]
        lines += [" ".join(map(repr, p)) + f" {t}" for p, t in zip(self.points, self.point_tags)]
        lines += ["Tetrahedra", str(len(self.tets))]
        lines += [" ".join(str(v + 1) for v in tet) + f" {t}" for tet, t in zip(self.tets, self.tet_tags)]
        return "\n".join(lines + ["End", ""])

    @staticmethod
    def read(path):
        words = Path(path).read_text().split()

        def section(name, each, number):
            at = words.index(name) + 1
            values = words[at + 1:at + 1 + int(words[at]) * (each + 1)]
            rows = [values[i:i + each + 1] for i in range(0, len(values), each + 1)]
            return [tuple(map(number, r[:each])) for r in rows], [int(r[each]) for r in rows]

        points, point_tags = section("Vertices", 3, float)
        tets, tet_tags = section("Tetrahedra", 4, lambda w: int(w) - 1)
        return Mesh(points, tets, point_tags, tet_tags)

    def volumes(self):
        def volume(tet):
            p, q, r, s = (self.points[v] for v in tet)
            a, b, c = ([x - y for x, y in zip(v, p)] for v in (q, r, s))
            return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                    + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
        return [volume(tet) for tet in self.tets]

    def boundary_faces(self):
        count = {}
        for a, b, c, d in self.tets:
            for face in ((a, b, c), (a, b, d), (a, c, d), (b, c, d)):
                key = tuple(sorted(face))
                count[key] = count.get(key, 0) + 1
        assert max(count.values()) <= 2, "a face on three tetrahedra"
        return {face for face, n in count.items() if n == 1}


def cube(n, jitter=0.2, seed=1):
    """n^3 cells of six tetrahedra in the unit cube; inner vertices displaced; two regions; a tag a vertex."""
    rng = random.Random(seed)
    points = []
    for k in range(n + 1):
        for j in range(n + 1):
            for i in range(n + 1):
                points.append(tuple(c / n + (jitter * rng.uniform(-1, 1) / n if 0 < c < n else 0.0) for c in (i, j, k)))

    def vertex(at):
        return (at[2] * (n + 1) + at[1]) * (n + 1) + at[0]

    tets, tags = [], []
    for cell in range(n ** 3):
        corner = [cell % n, cell // n % n, cell // n ** 2]
        for path in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
            at = list(corner)
            tet = [vertex(at)]
            for axis in path:
                at[axis] += 1
                tet.append(vertex(at))
            if path in ((0, 2, 1), (2, 1, 0), (1, 0, 2)):
                tet[2], tet[3] = tet[3], tet[2]
            tets.append(tuple(tet))
            tags.append(3)
    return Mesh(points, tets, [i % 5 for i in range(len(points))], tags)


def unflipped(mesh):
    """The same shape with pairs of tetrahedra replaced by three around a new edge, where that is possible."""
    owners = {}
    for t, tet in enumerate(mesh.tets):
        for v in tet:
            owners.setdefault(tuple(sorted(set(tet) - {v})), []).append((t, v))
    gone, new = set(), []
    for (a, b, c), sides in owners.items():
        if len(sides) < 2 or gone & {t for t, _ in sides}:
            continue
        top, bottom = (v for _, v in sides)
        three = Mesh(mesh.points, [(a, b, bottom, top), (b, c, bottom, top), (c, a, bottom, top)])
        if max(three.volumes()) < -1e-4:
            three.tets = [(y, x, v, w) for x, y, v, w in three.tets]
        if min(three.volumes()) > 1e-4:
            gone |= {t for t, _ in sides}
            new += three.tets
    tets = [tet for t, tet in enumerate(mesh.tets) if t not in gone] + new
    return Mesh(mesh.points, tets, mesh.point_tags, [mesh.tet_tags[0]] * len(tets))


class CliTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="tetune_cli_"))
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return str(self.folder / name)

    def put(self, name, content):
        Path(self.path(name)).write_text(content.text() if isinstance(content, Mesh) else content)
        return self.path(name)

    def read_bytes(self, name):
        return Path(self.path(name)).read_bytes()

    def files(self):
        return sorted(os.listdir(self.folder))

    def run_cli(self, *args, code=0, **more):
        done = subprocess.run([TETUNE, *map(str, args)], capture_output=True, text=True, timeout=120, **more)
        self.assertEqual(done.returncode, code, f"{args}\n{done.stdout}\n{done.stderr}")
        return done

    def refused(self, *args, said=()):
        """Exit code 2, a message on the standard error, nothing on the standard output."""
        done = self.run_cli(*args, code=2)
        self.assertEqual(done.stdout, "")
        for part in said:
            self.assertIn(part, done.stderr)
        return done

    def assert_improved(self, before, after):
        self.assertEqual(len(after.points), len(before.points))
        self.assertEqual(after.point_tags, before.point_tags)
        self.assertEqual(set(after.tet_tags), set(before.tet_tags))
        self.assertGreater(min(after.volumes()), 0)
        self.assertAlmostEqual(sum(after.volumes()), sum(before.volumes()), places=12)
        self.assertEqual(len({tuple(sorted(t)) for t in after.tets}), len(after.tets))
        after.boundary_faces()


class Optimize(CliTest):
    def test_writes_a_valid_mesh_and_a_table(self):
        mesh = unflipped(cube(5))
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
        plain = self.run_cli("optimize", source, "-o", self.path("out.mesh")).stdout
        loud = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "-v", "2").stdout
        for part in ("after sweep  pass", "|grad tr|^2", "phase        time s"):
            self.assertIn(part, loud)
            self.assertNotIn(part, plain)
        self.assertGreater(len(loud.splitlines()), len(plain.splitlines()) + 5)

    def test_report(self):
        mesh = unflipped(cube(4))
        source = self.put("in.mesh", mesh)
        self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--report", self.path("r.json"), "--threads", "2",
                     "--termination", "paper", "--max-iterations", "7")
        report = json.loads(self.read_bytes("r.json"))
        self.assertEqual(report["input"], source)
        self.assertEqual(report["output"], self.path("out.mesh"))
        self.assertEqual(report["options"], {"boundary": "preserve", "energy": "shape", "effort": "default", "keep_vertices": False, "feature_angle_deg": 45,
                                             "max_deviation": 0, "open_boundaries": True, "frozen_regions": [],
                                             "frozen_patches": [], "relocation": "newton", "termination": "paper",
                                             "device": "auto", "max_iterations": 7, "max_ring": 7, "boundary_flips": True, "targets": [],
                                             "threads": 2})
        self.assertGreaterEqual(report["read_seconds"], 0)
        self.assertGreaterEqual(report["write_seconds"], 0)
        before, after, run = report["before"], report["after"], report["optimization"]
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
        self.assertGreaterEqual(added, run["flips_2_3"] - run["flips_3_2"])
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
        for count in ("flips_3_2", "edge_removals", "boundary_flips"):
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
                               "boundary_flips"},
                     "flips": {"gradient_norm", "moved"}}[row["event"]]
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
        self.assertAlmostEqual(energy / run["energy_after"], 1, places=9)

    def test_flips_alone(self):
        rows, run = self.trace("--max-iterations", "0")
        self.assertTrue(rows)
        self.assertEqual({r["event"] for r in rows}, {"flips"})
        self.assertEqual(run["sweeps"], [])
        self.assertEqual(Mesh.read(self.path("out.mesh")).points, cube(4).points)

    def test_largest_ring(self):
        _, run = self.trace()
        self.assertGreater(run["edge_removals"], 0)
        _, run = self.trace("--max-ring", "3")
        self.assertEqual(run["edge_removals"], 0)
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

    def test_tetgen_files(self):
        mesh = cube(3)
        nodes = "".join(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(mesh.points))
        self.put("m.node", f"{len(mesh.points)} 3 0 0\n{nodes}")
        tets = "".join(f"{i} {a} {b} {c} {d} 4\n" for i, (a, b, c, d) in enumerate(mesh.tets))
        self.put("m.ele", f"{len(mesh.tets)} 4 1\n{tets}")
        done = self.run_cli("optimize", self.path("m.ele"), "-o", self.path("out.mesh"))
        self.assertIn("tetune: warning: ", done.stderr)
        self.assertIn("m.face is not there", done.stderr)
        after = Mesh.read(self.path("out.mesh"))
        self.assertEqual(set(after.tet_tags), {4})
        self.assertGreater(min(after.volumes()), 0)
        # Nothing of warnings when quiet.
        done = self.run_cli("optimize", self.path("m.ele"), "-o", self.path("out.mesh"), "--quiet")
        self.assertEqual(done.stderr, "")


SURFACE_KEYS = {"volume_change", "area_change", "region_volume_change", "patch_area_change", "patches",
                "distance_vertices_to_old", "distance_new_to_old", "distance_old_to_new", "vertices_before",
                "vertices_after", "vertex_tags_kept", "edge_tags_kept", "triangle_tags_kept",
                "tetrahedron_tags_kept", "required_vertices_moved", "corners_moved"}


def bent(mesh, height=0.1):
    """Waves in the z direction: the top and the bottom of the cube are curved."""
    points = [(x, y, z + height * math.sin(5 * x + 1) * math.cos(4 * y)) for x, y, z in mesh.points]
    return Mesh(points, mesh.tets, mesh.point_tags, mesh.tet_tags)


def with_triangles(mesh, triangles):
    """The text of a mesh with listed triangles (counted from 0) and their tags."""
    lines = ["Triangles", str(len(triangles))] + [" ".join(str(v + 1) for v in t) + f" {tag}" for t, tag in triangles]
    return mesh.text().replace("End", "\n".join(lines + ["End"]))


class Slide(CliTest):
    def slide(self, source, *options, code=0):
        done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--report", self.path("r.json"), *options,
                            code=code)
        return json.loads(self.read_bytes("r.json")), done.stdout

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
        # The other modes say nothing of it.
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
                mean = report["surface"]["distance_new_to_old"]
                self.assertLess(mean, 0.5 * free["surface"]["distance_new_to_old"])
        self.refused("optimize", source, "-o", self.path("o.mesh"), "--boundary", "slide", "--max-deviation",
                     said=["--max-deviation"])
        for text in ("0", "-1", "x", "0.1x", "0.1%%", "%", "nan", "inf", "-5%", "1e999"):
            self.refused("optimize", source, "-o", self.path("o.mesh"), "--boundary", "slide", "--max-deviation=" + text,
                         said=["--max-deviation", f"'{text}'", "%"])

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
        for effort in ("fast", "default"):
            self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--effort", effort, "--report", self.path("r.json"))
            report = json.loads(self.read_bytes("r.json"))
            runs[effort] = report["optimization"]
            self.assertEqual(report["options"]["effort"], effort)
            self.assertGreaterEqual(report["after"]["dihedral_min_deg"], report["before"]["dihedral_min_deg"])
        self.assertEqual(runs["fast"]["worst_rounds"], [])
        self.assertLessEqual(len(runs["fast"]["sweeps"]), len(runs["default"]["sweeps"]))

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
        for text, said in (("tag=9", "tag 9"), ("patch=9", "tag 9"), ("tag=1,patch=1", "tag 1"), ("tag=1,9", "tag 9")):
            self.refused("optimize", source, "-o", self.path("out.mesh"), "--freeze", text, said=[said])
        for text in ("1", "tag=", "tag=a", "colour=1", "tag=1,", "tag=1;patch=2", "tag=1.5", "tag=99999999999"):
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
            return counts["triangles"], "dropped" in text
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

    def test_bad_values_and_options_without_effect(self):
        source = self.put("in.mesh", cube(2))
        for options, said in (
                (["--feature-angle", "60"], ["--feature-angle", "--boundary slide"]),
                (["--max-deviation", "0.1"], ["--max-deviation", "--boundary slide"]),
                (["-ar", "60", "--boundary", "fixed"], ["--feature-angle", "--boundary slide"]),
                (["--boundary", "slide", "--feature-angle", "-1"], ["--feature-angle"]),
                (["--boundary", "slide", "--feature-angle", "0"], ["feature_angle"]),
                (["--boundary", "slide", "--feature-angle", "181"], ["--feature-angle"]),
                (["--boundary", "slide", "-ar"], ["--feature-angle"]),
                (["--boundary", "glide"], ["--boundary", "slide"]),
                (["--energy", "elastic"], ["--energy", "shape"]),
                (["--effort", "fast", "--termination", "paper"], ["--effort", "--termination paper"]),
                (["--boundary-flips", "-nosurf"], ["--boundary-flips", "--boundary fixed"]),
                (["--boundary-flips", "--max-ring", "3"], ["--boundary-flips", "--max-ring 3"]),
                (["--no-boundary-flips", "--max-iterations", "0"], ["--no-boundary-flips", "--max-iterations 0"]),
                (["--boundary-flips", "--boundary", "slide", "-hausd", "0.1"], ["--boundary-flips", "--max-deviation"]),
                (["--effort", "heroic"], ["--effort", "fast", "default", "best"]),
                (["--effort", "best", "--energy", "harmonic"], ["--effort best", "--energy harmonic"]),
                (["--effort", "best", "--max-iterations", "0"], ["--effort", "--max-iterations 0"]),
                (["--keep-vertices"], ["--keep-vertices", "--effort best"]),
                (["-nosurf", "--boundary", "slide"], ["--boundary"])):
            self.refused("optimize", source, "-o", self.path("out.mesh"), *options, said=said)
            self.assertEqual(self.files(), ["in.mesh"])

    def test_targets(self):
        source = self.put("in.mesh", cube(5, 0.25))

        def run(*options, code):
            text = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--report", self.path("r.json"), *options,
                                code=code).stdout
            self.assert_improved(Mesh.read(source), Mesh.read(self.path("out.mesh")))
            return json.loads(self.read_bytes("r.json")), text

        report, text = run("--target-dihedral", "5", "--target-quality", "20", "radius_ratio", code=0)
        self.assertEqual(report["options"]["targets"], [{"measure": "min_dihedral_deg", "value": 5.0},
                                                        {"measure": "radius_ratio", "value": 20.0}])
        self.assertEqual([t["met"] for t in report["optimization"]["targets"]], [True, True])
        self.assertIn("min_dihedral_deg >= 5: met by all", text)
        self.assertIn("radius_ratio <= 20: met by all", text)
        easy = self.read_bytes("out.mesh")

        report, text = run("--target-quality", "0.8", "mean_ratio", "--target-dihedral", "5", "--target-quality", "1.1",
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
                              (["--target-quality", "0.5"], ["--target-quality"]),
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


class Refusals(CliTest):
    def optimize_refused(self, source, *options, said=()):
        """The output, old or absent, is as it was, and no report or trace appears."""
        for old in (None, "an old file"):
            if old:
                self.put("out.mesh", old)
            names = self.files()
            self.refused("optimize", source, "-o", self.path("out.mesh"), "--report", self.path("r.json"), "--trace",
                         self.path("t.csv"), *options, said=said)
            self.assertEqual(self.files(), names)
            if old:
                self.assertEqual(self.read_bytes("out.mesh").decode(), old)
        os.remove(self.path("out.mesh"))

    def test_inverted_tetrahedra(self):
        mesh = cube(3)
        for t in (4, 9, 30, 31, 77, 100):
            a, b, c, d = mesh.tets[t]
            mesh.tets[t] = (a, b, d, c)
        self.optimize_refused(self.put("in.mesh", mesh), said=[
            self.path("in.mesh"), "inverted tetrahedra", ": 6 (first, counted from 1: 5, 10, 31, 32, 78)"])

    def test_flat_tetrahedron(self):
        mesh = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [(0, 1, 2, 3)])
        self.optimize_refused(self.put("in.mesh", mesh), said=["flat tetrahedra", ": 1 (first, counted from 1: 1)"])

    def test_index_out_of_range(self):
        mesh = cube(2)
        mesh.tets[6] = (0, 1, 2, 1000)
        self.optimize_refused(self.put("in.mesh", mesh), said=["index out of range", ": 1 (first, counted from 1: 7)"])

    def test_no_tetrahedra(self):
        self.optimize_refused(self.put("in.mesh", Mesh([(0, 0, 0)], [])), said=["no tetrahedron"])

    def test_broken_file(self):
        text = cube(2).text().split("\n")
        text[6] = "0.5 half 0.5 1"
        self.optimize_refused(self.put("in.mesh", "\n".join(text)), said=["in.mesh:7: ", '"half"'])

    def test_absent_file(self):
        self.optimize_refused(self.path("absent.mesh"), said=["absent.mesh", "No such file"])

    def test_unknown_endings(self):
        self.optimize_refused(self.put("in.vtu", "<VTKFile>"), said=["in.vtu", ".mesh"])
        self.refused("optimize", self.put("in.mesh", cube(1)), "-o", self.path("out.stl"), said=["out.stl", ".mesh"])

    def test_full_disk(self):
        """A write that fails midway leaves the old file."""
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, resource.RLIM_INFINITY))
        source = self.put("in.mesh", cube(4))
        self.put("out.mesh", "an old file")
        # As Python ignores the signal SIGXFSZ, the process does, too, and sees the write fail.
        done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), code=2, preexec_fn=limit,
                            restore_signals=False)
        self.assertIn("cannot write", done.stderr)
        self.assertEqual(self.files(), ["in.mesh", "out.mesh"])
        self.assertEqual(self.read_bytes("out.mesh"), b"an old file")

    def test_output_folder_is_checked_before_the_work(self):
        # The input is absent as well: the folder is what the message is about.
        for target in (self.path("absent/out.mesh"), self.path("in.mesh/out.mesh")):
            self.put("in.mesh", "")
            self.refused("optimize", self.path("absent.mesh"), "-o", target, said=["folder", target])
        self.assertEqual(self.files(), ["in.mesh"])

    def test_folders_of_report_and_trace_are_checked_before_the_work(self):
        source = self.put("in.mesh", cube(1))
        for option in ("--report", "--trace"):
            target = self.path("absent/figures")
            self.refused("optimize", source, "-o", self.path("out.mesh"), option, target, said=["folder", target])
        self.assertEqual(self.files(), ["in.mesh"])

    def test_options(self):
        source = self.put("in.mesh", cube(1))
        for options in (["--bogus"], ["--device", "tpu"], ["--boundary", "free"], ["--relocation", "newton2"],
                        ["--termination", "never"], ["--max-iterations", "-1"], ["--max-iterations", "many"],
                        ["--max-ring", "2"], ["--max-ring", "8"], ["--threads", "-1"], ["--threads", "100000"],
                        ["-v", "3"], ["second.mesh"]):
            self.optimize_refused(source, *options, said=[options[-1]])
        self.refused("optimize", source, said=["output"])
        self.refused("optimize", "-o", self.path("out.mesh"), said=["input"])
        self.refused("repair", source, said=["subcommand"])
        self.refused(said=["subcommand"])

    def test_options_without_effect(self):
        source = self.put("in.mesh", cube(1))
        for options, said in (
                (["--max-iterations", "0", "--relocation", "newton"], ["--relocation", "--max-iterations 0"]),
                (["--max-iterations", "0", "--termination", "paper"], ["--termination", "--max-iterations 0"]),
                (["--device", "cuda", "--threads", "2"], ["--threads", "--device cuda"]),
                (["--quiet", "-v", "2"], ["--quiet", "-v"])):
            self.optimize_refused(source, *options, said=said)

    @unittest.skipIf(shutil.which("nvidia-smi"), "there may be a GPU")
    def test_cuda_without_a_gpu(self):
        self.optimize_refused(self.put("in.mesh", cube(2)), "--device", "cuda", said=["CUDA", "--device cpu"])

    def test_killed_process_leaves_the_old_file(self):
        """Whenever it dies: the output is the old file or the whole new one."""
        mesh = cube(12)
        source = self.put("in.mesh", mesh)
        self.run_cli("optimize", source, "-o", self.path("whole.mesh"), "--quiet")
        for delay in (0.05, 0.15, 0.3):
            self.put("out.mesh", "an old file")
            process = subprocess.Popen([TETUNE, "optimize", source, "-o", self.path("out.mesh"), "--quiet"])
            try:
                process.wait(timeout=delay)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
            self.assertIn(self.read_bytes("out.mesh"), (b"an old file", self.read_bytes("whole.mesh")))


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
        mesh = cube(2)
        a, b, c, d = mesh.tets[10]
        mesh.tets[10] = (b, a, c, d)
        name = self.put("in.mesh", mesh)
        info = json.loads(self.run_cli("info", "--json", name, code=1).stdout)
        self.assertFalse(info["validity"]["valid"])
        finding = next(f for f in info["validity"]["findings"] if "inverted" in f["kind"])
        self.assertEqual((finding["where"], finding["count"], finding["first"]), ("tetrahedra", 1, [11]))
        text = self.run_cli("info", name, code=1).stdout
        self.assertIn("inverted tetrahedra", text)
        self.assertIn("counted from 1: 11)", text)

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
        self.assertRegex(text, rf"least angle +q_h +centroid\n +{worst['tetrahedron']} +{worst['min_dihedral_deg']:.3f} ")

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
        self.refused("info", name, "--cell-data", self.path("q.vtk"), said=["q.vtk", ".sol"])
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

    def test_refusals(self):
        self.refused("info", self.path("absent.mesh"), said=["absent.mesh"])
        self.refused("info", said=["file"])


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

    def test_optimised(self):
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
        a, b, c, d = mesh.tets[2]
        mesh.tets[2] = (b, a, c, d)
        result = self.compare(good, self.put("b.mesh", mesh), code=1)
        self.assertTrue(result["before"]["validity"]["valid"])
        self.assertFalse(result["after"]["validity"]["valid"])

    def test_refusals(self):
        self.refused("compare", self.put("a.mesh", cube(1)), said=["files"])
        self.refused("compare", self.path("a.mesh"), self.path("absent.mesh"), said=["absent.mesh"])


class Help(CliTest):
    def test_help_and_version(self):
        for args in (["--help"], ["optimize", "--help"], ["info", "--help"], ["compare", "--help"]):
            done = self.run_cli(*args)
            self.assertIn("Usage", done.stdout)
            self.assertEqual(done.stderr, "")
        self.assertIn("Exit codes", self.run_cli("--help").stdout)
        self.assertRegex(self.run_cli("--version").stdout, r"^tetune \d+\.\d+\.\d+\n$")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    TETUNE = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=1)
