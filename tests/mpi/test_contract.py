# SPDX-License-Identifier: Apache-2.0
"""The contract of tetune-mpi, on the bracket of two materials: as on one machine, for 1 to 4 ranks."""

import json
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import mpi_case
from mpi_case import MpiTest, cli_case


def entities(path):
    """Vertices, triangles and tetrahedra with their tags, whatever their numbers."""
    mesh = cli_case.Mesh.read(path)
    words = Path(path).read_text().split()
    at = words.index("Triangles") + 1
    rows = [words[i:i + 4] for i in range(at + 1, at + 1 + 4 * int(words[at]), 4)]
    triangles = {(frozenset(mesh.points[int(v) - 1] for v in row[:3]), int(row[3])) for row in rows}
    tets = {(frozenset(mesh.points[v] for v in tet), tag) for tet, tag in zip(mesh.tets, mesh.tet_tags)}
    return set(zip(mesh.points, mesh.point_tags)), triangles, tets


def surface_faces(mesh):
    """Of the boundary, and between regions."""
    regions = {}
    for (a, b, c, d), tag in zip(mesh.tets, mesh.tet_tags):
        for face in ((a, b, c), (a, b, d), (a, c, d), (b, c, d)):
            regions.setdefault(tuple(sorted(face)), []).append(tag)
    return [face for face, tags in regions.items() if len(tags) == 1 or tags[0] != tags[1]]


def minus(p, q):
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


def dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def mean_edge(mesh):
    """Of the boundary: the unit of distances."""
    edges = {tuple(sorted(e)) for a, b, c in mesh.boundary_faces() for e in ((a, b), (b, c), (c, a))}
    return sum(dot(d, d) ** 0.5 for d in (minus(mesh.points[a], mesh.points[b]) for a, b in edges)) / len(edges)


def to_segment(p, a, b):
    along, d = minus(b, a), minus(p, a)
    s = min(1.0, max(0.0, dot(d, along) / dot(along, along)))
    off = minus(d, tuple(s * x for x in along))
    return dot(off, off) ** 0.5


def to_triangle(p, a, b, c):
    u, v, d = minus(b, a), minus(c, a), minus(p, a)
    uu, uv, vv, du, dv = dot(u, u), dot(u, v), dot(v, v), dot(d, u), dot(d, v)
    det = uu * vv - uv * uv
    s, t = (vv * du - uv * dv) / det, (uu * dv - uv * du) / det
    if s >= 0 and t >= 0 and s + t <= 1:
        off = minus(d, tuple(s * x + t * y for x, y in zip(u, v)))
        return dot(off, off) ** 0.5
    return min(to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a))


class Contract(MpiTest):
    def judged(self, out, slide=False):
        """Valid, nothing lost, the shape as it was."""
        change = self.compare(mpi_case.BRACKET, out)["change"]
        after = self.info(out)
        self.assertTrue(after["validity"]["valid"], after["validity"])
        for kept in ("vertex_tags_kept", "edge_tags_kept", "triangle_tags_kept", "tetrahedron_tags_kept"):
            self.assertTrue(change[kept], kept)
        self.assertEqual(change["vertices_before"], change["vertices_after"])
        if not slide:
            self.assertLess(abs(change["volume_change"]), 1e-12)
            self.assertLess(change["distance_new_to_old"], 1e-9)
        counts = self.info(mpi_case.BRACKET)["counts"]
        for listed in ("vertices", "triangles", "edges"):
            self.assertEqual(after["counts"][listed], counts[listed])
        return after["quality"]

    def test_as_good_as_on_one_machine(self):
        alone = self.on_one_machine(mpi_case.BRACKET)["quality"]
        for ranks in (1, 2, 3, 4):
            with self.subTest(ranks=ranks):
                out, report = self.path(f"{ranks}.meshb"), self.path("report.json")
                self.mpi(ranks, mpi_case.BRACKET, out, "--report", report)
                q = self.judged(out)
                self.assertLess(abs(q["eta_sum"] / alone["eta_sum"] - 1), 0.005)
                self.assertGreater(q["dihedral_min_deg"], 0.9 * alone["dihedral_min_deg"])
                run = json.loads(Path(report).read_text())
                self.assertEqual(run["ranks"], ranks)
                self.assertEqual(run["optimization"]["left_frozen"], 0)
                self.assertEqual(run["after"]["tets"], q["tetrahedra"])
                self.assertAlmostEqual(run["after"]["dihedral_min_deg"], q["dihedral_min_deg"], places=9)
                self.assertAlmostEqual(run["optimization"]["energy_after"] / run["after"]["shape_sum"], 1, places=9)

    def test_same_bits(self):
        a, b = self.path("a.meshb"), self.path("b.meshb")
        for boundary in ("preserve", "slide"):
            self.mpi(3, mpi_case.BRACKET, a, "--quiet", "--effort", "fast", "--boundary", boundary)
            self.mpi(3, mpi_case.BRACKET, b, "--quiet", "--effort", "fast", "--boundary", boundary, "--threads", "2")
            self.assertEqual(Path(a).read_bytes(), Path(b).read_bytes())

    def test_one_rank_does_what_one_machine_does(self):
        for options in ([], ["--boundary", "slide"], ["--boundary", "slide", "--max-deviation", "0.05"]):
            with self.subTest(options=options):
                alone, one = self.path("alone.mesh"), self.path("one.mesh")
                options = ["--quiet", "--effort", "fast", *options]
                subprocess.run([mpi_case.TETUNE, "optimize", mpi_case.BRACKET, "-o", alone, *options], check=True)
                self.mpi(1, mpi_case.BRACKET, one, *options)
                self.assertEqual(Path(alone).read_bytes(), Path(one).read_bytes())

    def test_text_and_binary_are_the_same_mesh(self):
        text = self.path("in.mesh")
        subprocess.run([mpi_case.TETUNE, "optimize", "--quiet", mpi_case.BRACKET, "-o", text, "--effort", "fast"], check=True)
        binary = self.path("in.meshb")
        subprocess.run([mpi_case.TETUNE, "optimize", "--quiet", mpi_case.BRACKET, "-o", binary, "--effort", "fast"], check=True)
        for source, name in ((text, "a.mesh"), (text, "b.meshb"), (binary, "c.mesh"), (binary, "d.meshb")):
            self.mpi(2, source, self.path(name), "--quiet", "--effort", "fast")
        self.assertEqual(Path(self.path("a.mesh")).read_bytes(), Path(self.path("c.mesh")).read_bytes())
        self.assertEqual(Path(self.path("b.meshb")).read_bytes(), Path(self.path("d.meshb")).read_bytes())

    def test_numbers_of_a_gmsh_file_are_not_kept(self):
        """They are no data of the user: of a mesh with data nothing is written."""
        mesh = cli_case.cube(4)
        nodes = [f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(mesh.points)]
        elements = [f"{i + 1} 4 2 7 {1 + i % 2} " + " ".join(str(v + 1) for v in tet) for i, tet in enumerate(mesh.tets)]
        text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes)), *nodes, "$EndNodes", "$Elements",
                str(len(elements)), *elements, "$EndElements", ""]
        done = self.mpi(2, self.put("in.msh", "\n".join(text)), self.path("out.mesh"), "--effort", "fast")
        self.assertIn("the numbers gmsh:geometrical are not kept", done.stderr)
        self.assertEqual(set(cli_case.Mesh.read(self.path("out.mesh")).tet_tags), {7})

    def test_slide_keeps_the_distance(self):
        out = self.path("out.meshb")
        self.mpi(3, mpi_case.BRACKET, out, "--quiet", "--boundary", "slide", "--max-deviation", "0.05")
        self.judged(out, slide=True)
        change = self.compare(mpi_case.BRACKET, out)["change"]
        length = mean_edge(self.bracket_as_text())
        for distance in ("distance_new_to_old", "distance_old_to_new"):
            self.assertLess(change[distance] * length, 0.05)
        alone = self.on_one_machine(mpi_case.BRACKET, "--boundary", "slide", "--max-deviation", "0.05")["quality"]
        self.assertLess(abs(self.info(out)["quality"]["eta_sum"] / alone["eta_sum"] - 1), 0.005)

    def test_all_rounds_slide_on_the_surface_of_the_input(self):
        flat = cli_case.cube(8)
        before = cli_case.bent(flat)
        before.tet_tags = [7 if sum(flat.points[v][0] for v in tet) < 2 else 3 for tet in before.tets]
        source = self.put("in.mesh", before)
        triangles = [[before.points[v] for v in face] for face in surface_faces(before)]

        def sides(v):
            return {(k, x) for k, x in enumerate(flat.points[v]) if x in (0, 1)}

        lines = [(a, b) for face in before.boundary_faces() for a, b in zip(face, face[1:] + face[:1])
                 if len(sides(a) & sides(b)) == 2]
        for ranks, options in ((2, []), (4, ["--effort", "fast"]), (3, ["--effort", "best"]), (4, ["--max-deviation", "0.01"])):
            with self.subTest(ranks=ranks, options=options):
                out, report = self.path("out.mesh"), self.path("report.json")
                self.mpi(ranks, source, out, "--boundary", "slide", "--report", report, *options)
                run = json.loads(Path(report).read_text())["optimization"]
                self.assertGreater(len(run["rounds"]), 1)
                after = cli_case.Mesh.read(out)
                self.assertGreater(min(after.volumes()), 0)
                moved = 0
                for v in {v for face in surface_faces(after) for v in face}:
                    p = after.points[v]
                    near = [t for t in triangles if dot(minus(p, t[0]), minus(p, t[0])) < 0.25]
                    self.assertLess(min(to_triangle(p, *t) for t in near), 1e-12)
                    moved += p not in before.points
                self.assertGreater(moved, 100)
                if "best" in options:  # which inserts vertices
                    continue
                for v in {v for line in lines for v in line}:
                    on_line = min(to_segment(after.points[v], before.points[a], before.points[b]) for a, b in lines)
                    self.assertLess(on_line, 1e-12)
                if "--max-deviation" in options:
                    change = self.compare(source, out)["change"]
                    for distance in ("distance_new_to_old", "distance_old_to_new"):
                        self.assertLess(change[distance] * mean_edge(before), 0.01)

    def test_a_rank_has_its_piece_of_the_surface_alone(self):
        most = {}
        for ranks in (2, 4):
            report = self.path("report.json")
            self.mpi(ranks, mpi_case.BRACKET, self.path("out.meshb"), "--boundary", "slide", "--report", report)
            most[ranks] = json.loads(Path(report).read_text())["optimization"]["surface_triangles"]
        whole = len(surface_faces(self.bracket_as_text()))
        # A cut's surroundings go to one of its ranks, which makes parts unequal.
        self.assertLess(most[2], 0.8 * whole)
        self.assertLess(most[4], 0.65 * whole)

    def bracket_as_text(self):
        text = self.path("edges.mesh")
        subprocess.run([mpi_case.TETUNE, "optimize", "--quiet", "--boundary", "fixed", "--effort", "fast",
                        mpi_case.BRACKET, "-o", text], check=True)
        return cli_case.Mesh.read(text)

    def test_vertices_inserted_and_removed(self):
        out, report = self.path("out.meshb"), self.path("report.json")
        self.mpi(3, mpi_case.BRACKET, out, "--effort", "best", "--report", report)
        run = json.loads(Path(report).read_text())["optimization"]
        self.assertGreater(run["vertices_inserted"] + run["vertices_removed"], 0)
        after = self.info(out)
        self.assertTrue(after["validity"]["valid"], after["validity"])
        before = self.info(mpi_case.BRACKET)
        self.assertEqual(after["counts"]["vertices"],
                         before["counts"]["vertices"] + run["vertices_inserted"] - run["vertices_removed"])
        self.assertLess(abs(after["quality"]["volume"] / before["quality"]["volume"] - 1), 1e-12)

    def test_growth_is_that_of_the_whole_mesh(self):
        source = self.put("in.mesh", cli_case.cube(8))
        out = self.path("out.mesh")
        before = len(cli_case.Mesh.read(source).tets)
        for ranks, growth in ((1, "1.02"), (2, "1.02"), (4, "1.02"), (4, "1.3")):
            with self.subTest(ranks=ranks, growth=growth):
                self.mpi(ranks, source, out, "--effort", "best", "--max-growth", growth, "--quiet")
                # Flips are not limited.
                self.assertLess(len(cli_case.Mesh.read(out).tets), (float(growth) + 0.01) * before)

    def test_required_and_frozen_stay(self):
        cube = cli_case.cube(8)
        inner = [i for i, p in enumerate(cube.points) if all(0.2 < x < 0.8 for x in p)][::3]
        cube.tet_tags = [7 if all(cube.points[v][0] < 0.3 for v in t) else 3 for t in cube.tets]
        listed = "RequiredVertices\n%d\n%s\nEnd" % (len(inner), "\n".join(str(v + 1) for v in inner))
        source = self.put("in.mesh", cube.text().replace("End", listed))
        out = self.path("out.mesh")
        frozen = {tuple(sorted(t)) for t, tag in zip(cube.tets, cube.tet_tags) if tag == 7}
        for options in ([], ["--boundary", "slide"], ["--boundary", "slide", "--max-deviation", "0.01"]):
            self.mpi(4, source, out, "--quiet", "--freeze", "tag=7", *options)
            after = cli_case.Mesh.read(out)
            kept = {tuple(sorted(t)) for t, tag in zip(after.tets, after.tet_tags) if tag == 7}
            self.assertEqual(frozen, kept)
            for v in set(inner) | {v for t in frozen for v in t}:
                self.assertEqual(cube.points[v], after.points[v])
            moved = sum(p != q for p, q in zip(cube.points, after.points))
            self.assertGreater(moved, 50)
            self.assertEqual(after.point_tags, cube.point_tags)

    def test_a_layer_whose_largest_angle_grows(self):
        done = self.mpi(1, self.put("in.mesh", cli_case.layer(8, 0.01)), self.path("out.mesh"))
        self.assertRegex(done.stderr, "tetune-mpi: warning: the worst elements improved at the expense of others .largest dihedral "
                                      "angle .*tetune optimize --only-below changes")
        done = self.mpi(1, self.put("in.mesh", cli_case.layer(8, 0.1)), self.path("out.mesh"))
        self.assertNotIn("expense", done.stderr)

    def test_inside_out_and_unused_vertices(self):
        cube = cli_case.cube(6)
        cube.tets = [(a, b, d, c) for a, b, c, d in cube.tets]
        cube.points.append((3.0, 3.0, 3.0))
        cube.point_tags.append(4)
        out = self.path("out.mesh")
        self.mpi(3, self.put("in.mesh", cube), out, "--quiet")
        after = cli_case.Mesh.read(out)
        self.assertEqual(after.points[-1], (3.0, 3.0, 3.0))
        self.assertEqual(after.point_tags, cube.point_tags)
        self.assertLess(max(after.volumes()), 0)

    def test_hdf5_and_xdmf(self):
        cube = cli_case.cube(6)
        cube.tet_tags = [7 if all(cube.points[v][0] < 0.5 for v in t) else 3 for t in cube.tets]
        faces = [(f, 10 + (cube.points[f[0]][2] == 0)) for f in sorted(cube.boundary_faces())]
        source = self.put("in.mesh", cli_case.with_triangles(cube, faces))
        self.mpi(3, source, self.path("out.mesh"), "--quiet")
        try:
            self.mpi(3, source, self.path("out.xmf"), "--quiet")
        except AssertionError as e:
            if "built without HDF5" in str(e):
                self.skipTest("PETSc without HDF5")
            raise
        expected = entities(self.path("out.mesh"))
        # With all frozen, what is read is what is written.
        self.mpi(2, self.path("out.h5"), self.path("back.mesh"), "--quiet", "--freeze", "tag=3,tag=7")
        self.assertEqual(entities(self.path("back.mesh")), expected)
        self.assertGreater(min(cli_case.Mesh.read(self.path("back.mesh")).volumes()), 0)
        self.mpi(2, self.path("out.h5"), self.path("again.h5"), "--quiet")

        grid = ElementTree.parse(self.path("out.xmf")).getroot().find("Domain/Grid")
        items = {item.text: item.get("Dimensions") for item in grid.iter("DataItem")}
        tets = len(cli_case.Mesh.read(self.path("out.mesh")).tets)
        self.assertEqual(items, {"out.h5:/viz/topology/cells": f"{tets} 4", "out.h5:/tags": str(tets),
                                 "out.h5:/geometry/vertices": f"{len(cube.points)} 3"})

    def test_more_ranks_than_the_mesh_has_room_for(self):
        cube = cli_case.cube(2)
        out = self.path("out.mesh")
        for boundary in ("preserve", "slide"):
            self.mpi(4, self.put("in.mesh", cube), out, "--quiet", "--boundary", boundary)
            after = cli_case.Mesh.read(out)
            self.assertGreater(min(after.volumes()), 0)
            self.assertAlmostEqual(sum(after.volumes()), 1, places=12)


mpi_case.main(__doc__)
