# SPDX-License-Identifier: Apache-2.0
"""Files of tetune-mpi: replaced as by tetune, with the same warnings of what they do not keep."""

import json
import os
import struct
import subprocess
from pathlib import Path

import mpi_case
from mpi_case import MpiTest, cli_case
from second_order import TET10, Middles


class Files(MpiTest):
    def warnings(self, done):
        return [line.split("warning: ", 1)[1] for line in done.stderr.splitlines() if "warning: " in line]

    def same_warnings(self, source, said):
        """Of both programs, from `source` to .meshb."""
        out = self.path("out.meshb")
        done = subprocess.run([mpi_case.TETUNE, "optimize", source, "-o", out, "--effort", "fast"], capture_output=True,
                              text=True, check=True)
        alone = self.warnings(done)
        self.assertTrue(any(said in warning for warning in alone), alone)
        self.assertEqual(self.warnings(self.mpi(2, source, out, "--effort", "fast")), alone)

    def writes_hdf5(self):
        done = subprocess.run([mpi_case.PROGRAM, mpi_case.BRACKET, "-o", self.path("trial.h5"), "--effort", "fast"],
                              capture_output=True, text=True, check=False)
        return "built without HDF5" not in done.stderr

    def regions(self, path):
        """Tags of the tetrahedra with their volumes, and the area between different ones."""
        mesh = cli_case.Mesh.read(path)
        volumes, sides, area = {}, {}, 0
        for tet, tag, volume in zip(mesh.tets, mesh.tet_tags, mesh.volumes()):
            volumes[tag] = volumes.get(tag, 0) + volume
            for i in range(4):
                sides.setdefault(tuple(sorted(tet[:i] + tet[i + 1:])), set()).add(tag)
        for face in (face for face, tags in sides.items() if len(tags) > 1):
            (ax, ay, _), (bx, by, _), (cx, cy, _) = (mesh.points[v] for v in face)
            area += abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2
        return {tag: round(volume, 9) for tag, volume in volumes.items()}, round(area, 9)

    def with_tag_minus_1(self):
        """Two regions that meet in a plane, and patches; no other tag than 0 and -1."""
        cube = cli_case.cube(6, two_regions=True)
        cube.tet_tags = [-1 if sum(cube.points[v][2] for v in tet) < 2 else 0 for tet in cube.tets]
        cube.point_tags = [0 if any(x in (0, 1) for x in p) else -1 for p in cube.points]
        faces = [(f, -1 if all(cube.points[v][2] == 0 for v in f) else 0) for f in sorted(cube.boundary_faces())]
        return self.put("minus.mesh", cli_case.with_triangles(cube, faces)), sum(tag == -1 for _, tag in faces)

    def listed(self, path):
        """Tags of the listed triangles."""
        words = Path(path).read_text().split()
        if "Triangles" not in words:
            return []
        at = words.index("Triangles") + 2
        return [int(tag) for tag in words[at + 3:at + 4 * int(words[at - 1]):4]]

    def test_regions_with_tag_minus_1_and_without(self):
        source, _ = self.with_tag_minus_1()
        for ranks in (1, 2, 3):
            self.mpi(ranks, source, self.path("out.mesh"))
            self.assertEqual(self.regions(self.path("out.mesh")), ({-1: 0.5, 0: 0.5}, 1.0))

    def test_tag_minus_1_has_another_number_in_hdf5(self):
        """It is the default value of a DMLabel, which stands for none."""
        if not self.writes_hdf5():
            self.skipTest("PETSc without HDF5")
        source, patch = self.with_tag_minus_1()
        h5, back = self.path("out.h5"), self.path("back.mesh")
        for ranks in (1, 2):
            said = self.warnings(self.mpi(ranks, source, h5))
            for name in ("Cell Sets", "Face Sets", "Vertex Sets"):
                self.assertIn(f"{h5}: a label of a DMPlex cannot have the value -1: the tag -1 is 1 in \"{name}\"", said)
            self.assertIn(f"{h5}: a DMPlex lists no triangles and edges with tag 0", said)
            self.assertEqual(len(said), 4, said)
            self.assertEqual(self.warnings(self.mpi(ranks, h5, back)), [])
            self.assertEqual(self.regions(back), ({1: 0.5, 0: 0.5}, 1.0))
            self.assertEqual(self.listed(back), [1] * patch)
            mesh = cli_case.Mesh.read(back)
            self.assertEqual([tag == 1 for tag in mesh.point_tags],
                             [all(0 < x < 1 for x in p) for p in mesh.points])
            self.assertEqual(set(mesh.point_tags), {0, 1})

    def test_numbers_in_use_are_not_taken_for_tag_minus_1(self):
        if not self.writes_hdf5():
            self.skipTest("PETSc without HDF5")
        cube = cli_case.cube(4, two_regions=True)
        cube.tet_tags = [-1 if sum(cube.points[v][2] for v in tet) < 2 else 1 for tet in cube.tets]
        h5, back = self.path("out.h5"), self.path("back.mesh")
        self.assertIn("the tag -1 is 2 in \"Cell Sets\"", self.mpi(2, self.put("in.mesh", cube), h5).stderr)
        self.mpi(2, h5, back)
        self.assertEqual(self.regions(back), ({2: 0.5, 1: 0.5}, 1.0))

    def test_names_of_groups_are_lost_in_hdf5_with_a_warning(self):
        if not self.writes_hdf5():
            self.skipTest("PETSc without HDF5")
        cube = cli_case.cube(3)
        names = '$PhysicalNames\n1\n3 7 "rotor"\n$EndPhysicalNames\n'
        source = self.put("in.msh", cli_case.msh_text(cube.points, [(4, 7, tet) for tet in cube.tets], names=names))
        for ending in ("h5", "xmf"):
            out = self.path(f"out.{ending}")
            for ranks in (1, 2):
                said = self.warnings(self.mpi(ranks, source, out, "--effort", "fast"))
                self.assertEqual(said.count(f"{out}: the format cannot hold the names of groups"), 1, said)

    def positions_of_others(self, path):
        """Of the vertices of each prism and hexahedron."""
        words, found = Path(path).read_text().split(), []
        points = cli_case.Mesh.read(path).points
        for name, each in (("Prisms", 6), ("Hexahedra", 8)):
            at = words.index(name) + 2
            rows = words[at:at + int(words[at - 1]) * (each + 1)]
            found += [[points[int(v) - 1] for v in rows[i:i + each]] for i in range(0, len(rows), each + 1)]
        return found

    def test_elements_of_other_kinds_keep_their_vertices_where_inner_ones_are_removed(self):
        cube = cli_case.cube(6, jitter=0.3)
        first = len(cube.points)
        # A prism apart from the cube, which shares an edge with a hexahedron; this has vertices of the cube too.
        apart = [(5, 0, 0), (6, 0, 0), (5, 1, 0), (5, 0, 1), (6, 0, 1), (5, 1, 1), (7, 0, 0), (7, 0, 1)]
        cube.points += [tuple(map(float, p)) for p in apart]
        cube.point_tags += [0] * len(apart)
        corners = [v for v, p in enumerate(cube.points[:first]) if p[0] == 1 and set(p[1:]) <= {0.0, 1.0}]
        hexahedron = [*corners, first + 1, first + 6, first + 7, first + 4]
        lines = ["Prisms", "1", " ".join(str(first + k + 1) for k in range(6)) + " 7",
                 "Hexahedra", "1", " ".join(str(v + 1) for v in hexahedron) + " 8", "End"]
        source, out = self.put("in.mesh", cube.text().replace("End", "\n".join(lines))), self.path("out.mesh")
        expected = self.positions_of_others(source)
        for ranks in (1, 2, 3):
            with self.subTest(ranks=ranks):
                self.mpi(ranks, source, out, "--effort", "best", "--report", self.path("report.json"))
                run = json.loads(Path(self.path("report.json")).read_text())
                self.assertGreater(run["optimization"]["vertices_removed"], 0)
                self.assertEqual(self.positions_of_others(out), expected)

    def test_coordinates_whose_volumes_are_below_the_range_of_doubles(self):
        cube = cli_case.cube(4)
        cube.points = [tuple(1e-110 * x for x in p) for p in cube.points]
        source = self.put("in.mesh", cube)
        for ranks in (1, 2):
            self.mpi(ranks, source, self.path("out.mesh"), "--effort", "fast")
            self.assertTrue(self.info(self.path("out.mesh"))["validity"]["valid"])

    def test_files_that_an_earlier_run_has_left(self):
        source = self.put("in.mesh", cli_case.cube(4))
        out = self.path("out.meshb")
        self.mpi(2, source, out, "--effort", "fast")
        expected = Path(out).read_bytes()
        left = Path(out + ".tetune-mpi.tmp")
        left.write_bytes(b"left" * 100_000)
        self.mpi(2, source, out, "--effort", "fast")
        self.assertEqual(Path(out).read_bytes(), expected)
        self.assertEqual(left.stat().st_size, 400_000)
        self.assertEqual(self.files(), ["in.mesh", "out.meshb", left.name])

    def test_permissions_are_kept(self):
        endings = ["meshb", "mesh"] + ["h5"] * self.writes_hdf5()
        for ending in endings:
            out = self.put(f"out.{ending}", "old")
            for mode in (0o640, 0o604):
                with self.subTest(ending=ending, mode=mode):
                    os.chmod(out, mode)
                    self.mpi(2, mpi_case.BRACKET, out, "--effort", "fast")
                    self.assertNotEqual(Path(out).read_bytes(), b"old")
                    self.assertEqual(os.stat(out).st_mode & 0o777, mode)

    def test_the_mesh_is_written_and_the_report_is_not(self):
        report = self.path("long" * 75 + ".json")
        for ranks in (1, 3):
            out = self.put("out.meshb", "old")
            done = self.mpi(ranks, mpi_case.BRACKET, out, "--effort", "fast", "--report", report, code=1)
            self.assertIn("; the mesh was written", done.stderr)
            self.assertIn("dihedral min", done.stdout)
            self.assertTrue(self.info(out)["validity"]["valid"])
            self.assertEqual(self.files(), ["out.meshb"])

    def test_nodes_in_the_middles_of_edges_are_lost_with_a_warning(self):
        mesh = cli_case.cube(3)
        points = [*mesh.points]
        middles = Middles(points)
        elements = [(TET10, 7, middles.nodes_of(tet)) for tet in mesh.tets]
        source = self.put("in.msh", cli_case.msh_text(points, elements))
        for ending in ["meshb"] + ["h5"] * self.writes_hdf5():
            out = self.path(f"out.{ending}")
            lost = f"{out}: written as linear elements, without the nodes in the middles of edges"
            self.assertIn(lost, self.warnings(self.mpi(2, source, out, "--effort", "fast")))

    def test_xdmf_is_written_and_not_read(self):
        words = " ".join(subprocess.run([mpi_case.PROGRAM, "--help"], capture_output=True, text=True, check=True).stdout.split())
        self.assertIn("Mesh to read: a format of `tetune`, or .h5; and mesh to write, also .xmf", words)
        source = self.put("in.xmf", "")
        self.assertIn("XDMF is written, not read", self.mpi(1, source, self.path("out.mesh"), code=2).stderr)

    def test_sections_that_are_not_kept(self):
        data = Path(mpi_case.BRACKET).read_bytes()
        # Version 2: the section End is its code and a position, of 32 bits each.
        self.assertEqual((struct.unpack("<i", data[4:8])[0], struct.unpack("<i", data[-8:-4])[0]), (2, 54))
        normals = struct.pack("<iiifff", 60, len(data) - 8 + 24, 1, 0, 0, 1)
        source = self.path("in.meshb")
        Path(source).write_bytes(data[:-8] + normals + data[-8:])
        self.same_warnings(source, "section with code 60 is not kept by tetune; skipped")

    def test_a_file_without_an_end(self):
        source = self.path("in.meshb")
        Path(source).write_bytes(Path(mpi_case.BRACKET).read_bytes()[:-8])
        self.same_warnings(source, "the section End is missing")


mpi_case.main(__doc__)
