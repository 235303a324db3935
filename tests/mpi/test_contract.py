# SPDX-License-Identifier: Apache-2.0
"""What tetune-mpi promises, on the bracket of two materials: as on one machine, for 1 to 4 ranks."""

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
        self.mpi(3, mpi_case.BRACKET, a, "--quiet", "--effort", "fast")
        self.mpi(3, mpi_case.BRACKET, b, "--quiet", "--effort", "fast", "--threads", "2")
        self.assertEqual(Path(a).read_bytes(), Path(b).read_bytes())

    def test_text_and_binary_are_the_same_mesh(self):
        text = self.path("in.mesh")
        subprocess.run([mpi_case.TETUNE, "optimize", "--quiet", mpi_case.BRACKET, text, "--effort", "fast"], check=True)
        binary = self.path("in.meshb")
        subprocess.run([mpi_case.TETUNE, "optimize", "--quiet", mpi_case.BRACKET, binary, "--effort", "fast"], check=True)
        for source, name in ((text, "a.mesh"), (text, "b.meshb"), (binary, "c.mesh"), (binary, "d.meshb")):
            self.mpi(2, source, self.path(name), "--quiet", "--effort", "fast")
        self.assertEqual(Path(self.path("a.mesh")).read_bytes(), Path(self.path("c.mesh")).read_bytes())
        self.assertEqual(Path(self.path("b.meshb")).read_bytes(), Path(self.path("d.meshb")).read_bytes())

    def test_slide_keeps_the_distance(self):
        out = self.path("out.meshb")
        self.mpi(3, mpi_case.BRACKET, out, "--quiet", "--boundary", "slide", "--max-deviation", "0.05")
        self.judged(out, slide=True)
        change = self.compare(mpi_case.BRACKET, out)["change"]
        length = self.mean_edge()
        for distance in ("distance_new_to_old", "distance_old_to_new"):
            self.assertLess(change[distance] * length, 0.05)
        alone = self.on_one_machine(mpi_case.BRACKET, "--boundary", "slide", "--max-deviation", "0.05")["quality"]
        self.assertLess(abs(self.info(out)["quality"]["eta_sum"] / alone["eta_sum"] - 1), 0.005)

    def mean_edge(self):
        """Of the boundary: the unit of distances."""
        text = self.path("edges.mesh")
        subprocess.run([mpi_case.TETUNE, "optimize", "--quiet", "--boundary", "fixed", "--effort", "fast",
                        mpi_case.BRACKET, text], check=True)
        mesh = cli_case.Mesh.read(text)
        edges = {tuple(sorted(e)) for a, b, c in mesh.boundary_faces() for e in ((a, b), (b, c), (c, a))}
        return sum(sum((x - y) ** 2 for x, y in zip(mesh.points[a], mesh.points[b])) ** 0.5 for a, b in edges) / len(edges)

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

    def test_required_and_frozen_stay(self):
        cube = cli_case.cube(8)
        inner = [i for i, p in enumerate(cube.points) if all(0.2 < x < 0.8 for x in p)][::3]
        cube.tet_tags = [7 if all(cube.points[v][0] < 0.3 for v in t) else 3 for t in cube.tets]
        listed = "RequiredVertices\n%d\n%s\nEnd" % (len(inner), "\n".join(str(v + 1) for v in inner))
        source = self.put("in.mesh", cube.text().replace("End", listed))
        out = self.path("out.mesh")
        self.mpi(4, source, out, "--quiet", "--freeze", "tag=7")
        after = cli_case.Mesh.read(out)
        frozen = {tuple(sorted(t)) for t, tag in zip(cube.tets, cube.tet_tags) if tag == 7}
        kept = {tuple(sorted(t)) for t, tag in zip(after.tets, after.tet_tags) if tag == 7}
        self.assertEqual(frozen, kept)
        for v in set(inner) | {v for t in frozen for v in t}:
            self.assertEqual(cube.points[v], after.points[v])
        moved = sum(p != q for p, q in zip(cube.points, after.points))
        self.assertGreater(moved, 50)
        self.assertEqual(after.point_tags, cube.point_tags)

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
        self.mpi(4, self.put("in.mesh", cube), out, "--quiet")
        after = cli_case.Mesh.read(out)
        self.assertGreater(min(after.volumes()), 0)
        self.assertAlmostEqual(sum(after.volumes()), 1, places=12)


mpi_case.main(__doc__)
