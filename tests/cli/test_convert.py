# SPDX-License-Identifier: Apache-2.0
"""tetune convert. Run: see cli_case.py."""

import json
import os
import shutil
import signal
import subprocess

import cli_case
from cli_case import CliTest, Mesh, cube, tangled, with_triangles

PERIODIC = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
3 8 "empty"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
$EndNodes
$Elements
1
1 4 2 7 1 1 2 3 4
$EndElements
$Periodic
1
0 2 1
1
2 1
$EndPeriodic
"""
BUILT_IN = ["mesh", "meshb", "msh", "ele"]


class Convert(CliTest):
    def source(self):
        mesh = cube(3)
        # A fifth of the tetrahedra in another region, and one face.
        mesh.tet_tags = [1 + (t % 5 == 0) for t in range(len(mesh.tets))]
        return mesh, self.put("in.mesh", with_triangles(mesh, [(mesh.tets[0][:3], 9)]))

    def test_from_every_format_to_every_other(self):
        mesh, source = self.source()
        for first in BUILT_IN:
            a = self.path(f"a.{first}")
            self.run_cli("convert", source, "-o", a)
            for second in BUILT_IN:
                with self.subTest(f"{first} to {second}"):
                    b, c = self.path(f"b.{second}"), self.path("c.mesh")
                    self.run_cli("convert", a, "-o", b)
                    self.run_cli("convert", b, "-o", c)
                    back = Mesh.read(c)
                    self.assertEqual(back.points, mesh.points)
                    self.assertEqual(dict(zip(map(frozenset, back.tets), back.tet_tags)),
                                     dict(zip(map(frozenset, mesh.tets), mesh.tet_tags)))
                    if "msh" not in (first, second):
                        self.assertEqual((back.point_tags, back.tets), (mesh.point_tags, mesh.tets))
        self.run_cli("convert", source, self.path("text.mesh"))
        self.run_cli("convert", self.path("text.mesh"), self.path("again.mesh"))
        self.assertEqual(self.read_bytes("text.mesh"), self.read_bytes("again.mesh"))

    def test_losses_are_named(self):
        _, source = self.source()
        done = self.run_cli("convert", source, self.path("a.msh"))
        self.assertIn(f"warning: {self.path('a.msh')}: the format cannot hold tags of vertices", done.stderr)
        self.assertEqual(done.stdout, "")
        done = self.run_cli("convert", self.path("a.msh"), self.path("b.ele"))
        self.assertIn("b.ele: the format cannot hold the data \"gmsh:geometrical\"", done.stderr)

    def test_volumes_of_one_group_that_touch_are_named(self):
        def text(tag, other):  # two tetrahedra with a common face, in volumes of their own
            return ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"m\"\n3 2 \"n\"\n$EndPhysicalNames\n$Nodes\n5\n"
                    "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n"
                    f"$Elements\n2\n1 4 2 {tag} 7 1 2 3 4\n2 4 2 {other} 8 2 3 4 5\n$EndElements\n")
        warning = "volumes in one physical group touch each other"
        for other, expected in ((1, True), (2, False)):
            with open(self.path("a.msh"), "w") as file:
                file.write(text(1, other))
            done = self.run_cli("optimize", self.path("a.msh"), "-o", self.path("b.msh"))
            self.assertEqual(warning in done.stderr, expected, done.stderr)

    def test_versions_of_msh(self):
        _, source = self.source()
        for word, head in (("2.2-text", b"2.2 0 8"), ("2.2-binary", b"2.2 1 8"), ("4.1-text", b"4.1 0 8"), ("4.1-binary", b"4.1 1 8")):
            self.run_cli("convert", source, "-o", self.path("a.msh"), "--msh", word)
            self.assertTrue(self.read_bytes("a.msh").startswith(b"$MeshFormat\n" + head))
            self.run_cli("convert", self.path("a.msh"), "-o", self.path("b.msh"))  # that of the input
            self.assertEqual(self.read_bytes("b.msh")[:20], self.read_bytes("a.msh")[:20])
        self.assertIn("--msh has no effect", self.run_cli("convert", source, "-o", self.path("c.mesh"), "--msh", word).stderr)
        self.refused("convert", source, "-o", self.path("a.msh"), "--msh", "1.0", said=["--msh", "1.0"])

    def test_periodic_links_are_counted(self):
        self.put("a.msh", PERIODIC)
        text = self.run_cli("info", self.path("a.msh")).stdout
        self.assertRegex(text, "periodic pairs +1\n")
        self.assertRegex(text, "group of dimension 3 +8   \"empty\", no elements\n")
        self.run_cli("convert", self.path("a.msh"), self.path("b.msh"), "--msh", "4.1-binary")
        counts = json.loads(self.run_cli("info", self.path("b.msh"), "--json").stdout)["counts"]
        self.assertEqual(counts["periodic_pairs"], 1)
        done = self.run_cli("convert", self.path("b.msh"), self.path("b.mesh"))
        self.assertIn("b.mesh: the format cannot hold periodic links", done.stderr)

    def test_no_mesh_is_overwritten_without_o(self):
        _, source = self.source()
        for name, other in (("b.mesh", "b.mesh"), ("b.node", "b.ele"), ("b.ele", "b.face")):
            self.put(other, "old")
            self.refused("convert", source, self.path(name), said=[other, "exists", "-o"])
            self.refused("optimize", source, self.path(name), said=[other, "exists", "-o"])
            self.assertEqual(self.read_bytes(other), b"old")
            os.remove(self.path(other))
        self.refused("convert", source, said=["-o"])
        self.refused("convert", source, self.path("b.mesh"), "-o", self.path("c.mesh"), said=["-o"])
        self.refused("convert", source, self.path("absent/b.mesh"), said=["absent"])
        self.refused("convert", source, self.path("b.stl"), said=["b.stl"])
        self.assertEqual(self.files(), ["in.mesh"])

    def test_meshes_that_are_not_valid_are_converted(self):
        self.put("in.mesh", cli_case.tangled(4))
        self.run_cli("convert", self.path("in.mesh"), self.path("out.meshb"))
        broken = cube(1)
        broken.tets[2] = (0, 1, 2, 1000)
        self.put("broken.mesh", broken)
        for name in ("out.mesh", "out.msh", "out.ele"):
            self.refused("convert", self.path("broken.mesh"), self.path(name), said=["1 of the tetrahedra has an index out of range (first, counted from 0: 2)"])
        self.assertEqual(self.files(), ["broken.mesh", "in.mesh", "out.meshb"])

    def test_order(self):
        mesh = cube(4, jitter=0)
        mesh.points = [(x, y, z * (1.3 - 0.5 * ((x / 4 - 0.5) ** 2 + (y / 4 - 0.5) ** 2))) for x, y, z in mesh.points]
        source = self.put("in.mesh", mesh.text())
        done = self.run_cli("convert", source, self.path("curved.msh"), "--order", "2")
        self.assertRegex(done.stderr, r"\d+ curved edges, \d+ curved tetrahedra, smallest scaled Jacobian 0\.\d+")
        done = self.run_cli("convert", source, self.path("plain.mesh"), "--feature-angle", "30")
        self.assertIn("--feature-angle has no effect without --order 2", done.stderr)
        # One warning, of tags of vertices, and no figures.
        self.assertEqual(self.run_cli("convert", source, "-o", self.path("curved.msh"), "--order", "2", "--quiet").stderr.count("\n"), 1)
        curved = json.loads(self.run_cli("info", self.path("curved.msh"), "--json").stdout)["quality"]["curved"]
        self.assertTrue(curved["curved_edges"] >= 3 * 16 and curved["valid"] == curved["tetrahedra"] > 0)
        self.refused("convert", self.path("curved.msh"), self.path("b.msh"), "--order", "2",
                     said=["tetune: " + self.path("curved.msh"), "curved edges already; make it straight first (--order 1)"])
        for name in ("b.mesh", "b.ele", "b.su2"):
            self.refused("convert", source, self.path(name), "--order", "2", "--quiet",
                         said=[name + ": the format has no nodes in the middles of edges; write one of .vtu", ".msh", ".bdf"])
        self.refused("convert", source, "-", "--order", "2", said=["--order 2", "standard output"])
        self.run_cli("convert", self.path("curved.msh"), self.path("linear.mesh"), "--order", "1")
        self.assertEqual(Mesh.read(self.path("linear.mesh")).points, Mesh.read(source).points)
        self.refused("convert", source, self.path("b.msh"), "--order", "3", said=["--order"])

    def test_order_of_a_mesh_that_is_not_valid(self):
        source = self.put("in.mesh", tangled(4))
        done = self.refused("convert", source, self.path("b.msh"), "--order", "2",
                            said=["tetune: " + source + ": the mesh is not valid", "counted from 1", "tetune optimize --untangle"])
        self.assertNotIn("untangle=true", done.stderr)

    def test_order_with_a_finer_surface(self):
        def dome(n, shift=0):
            mesh = cube(n, jitter=0)
            mesh.points = [(x + shift, y, z * (1.3 - 0.5 * (x - 0.5) ** 2)) for x, y, z in mesh.points]
            return mesh.text()
        source, finer, other = self.put("in.mesh", dome(2)), self.put("finer.mesh", dome(7)), self.put("other.mesh", dome(7, 0.2))
        self.run_cli("convert", source, self.path("curved.msh"), "--order", "2", "--surface", finer)
        curved = json.loads(self.run_cli("info", self.path("curved.msh"), "--json").stdout)["quality"]["curved"]
        self.assertTrue(curved["valid"] == curved["tetrahedra"] > 0)
        self.refused("convert", source, self.path("b.msh"), "--order", "2", "--surface", other,
                     said=["the finer surface is not that of the mesh", "the largest distance is 0.2"])
        self.refused("convert", source, self.path("b.msh"), "--surface", finer, said=["--order 2"])
        self.refused("convert", source, "-o", finer, "--order", "2", "--surface", finer, said=["finer.mesh", "is read as well"])
        self.refused("convert", source, self.path("b.msh"), "--order", "2", "--surface", self.path("none.mesh"), said=["none.mesh"])

    def test_pipes(self):
        mesh, source = self.source()
        done = subprocess.run([cli_case.TETUNE, "convert", "-", "-"], input=self.read_bytes("in.mesh"), capture_output=True)
        self.run_cli("convert", source, self.path("out.mesh"))
        self.assertEqual((done.returncode, done.stdout), (0, self.read_bytes("out.mesh")))

    def test_files_of_tetgen_are_one_mesh(self):
        """They are written together; two names of one mesh clash; an old .edge file does not stay beside a new mesh."""
        _, source = self.source()
        self.put("a.edge", "1 1\n1 1 2 7\n")
        self.run_cli("convert", source, self.path("a.node"), code=0)
        self.assertEqual(self.files(), ["a.edge", "a.ele", "a.face", "a.node", "in.mesh"])
        self.assertEqual(self.read_bytes("a.edge"), b"0 0\n")
        self.assertEqual(self.run_cli("info", self.path("a.node"), "--check").stderr, "")
        self.put("b.node", "4 3 2 0\n1 0 0 0 5 6\n2 1 0 0 5 6\n3 0 1 0 5 6\n4 0 0 1 5 6\n")
        self.put("b.ele", "1 4 2\n1 1 2 3 4 7 8\n")
        done = self.run_cli("info", self.path("b.node"), "--check")
        self.assertIn("b.node: the attributes of points are not kept", done.stderr)
        self.assertIn("b.ele: the attributes of tetrahedra after the first are not kept", done.stderr)
        self.refused("optimize", self.path("a.node"), self.path("a.ele"), "-o", self.path("new") + "/", said=["named twice"])
        self.put("new.mesh", cube(2))
        self.refused("optimize", self.path("new.mesh"), self.path("a.node"), "-o", self.path("a.ele"), said=["a.ele"])
        self.run_cli("optimize", self.path("a.node"), "-o", self.path("a.ele"), "--quiet")

    def test_a_failure_leaves_all_files(self):
        _, source = self.source()
        for name in ("a.ele", "a.node"):
            self.put(name, "old")
        os.mkdir(self.path("a.face"))
        self.refused("convert", source, "-o", self.path("a.ele"), said=["a.face", "folder"])
        self.assertEqual((self.read_bytes("a.ele"), self.read_bytes("a.node")), (b"old", b"old"))

    def test_a_signal_before_the_mesh_is_written(self):
        for sign in (signal.SIGINT, signal.SIGTERM):
            self.put("out.mesh", "old")
            words = [cli_case.TETUNE, "convert", "-", "-o", self.path("out.mesh")]
            process = subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
            process.stdin.write(b"# reads on\n" * 50000)  # more than the pipe holds: it reads already
            process.stdin.flush()
            process.send_signal(sign)
            self.assertEqual(process.wait(timeout=cli_case.HANG), 2)
            process.stdin.close()
            self.assertEqual(process.stderr.read(), b"\ntetune: interrupted, nothing was written\n")
            process.stderr.close()
            self.assertEqual((self.files(), self.read_bytes("out.mesh")), (["out.mesh"], b"old"))

    def test_tetgen_takes_what_is_written(self):
        program = shutil.which("tetgen")
        if program is None:
            self.skipTest("no tetgen")
        mesh, source = self.source()
        self.run_cli("convert", source, self.path("a.ele"))
        done = subprocess.run([program, "-rCN", self.path("a.ele")], capture_output=True, text=True, timeout=cli_case.HANG)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertRegex(done.stdout, rf"Mesh tetrahedra: {len(mesh.tets)}\n")
        self.assertNotRegex(done.stdout, "(?i)error|warning")


if __name__ == "__main__":
    cli_case.main(__doc__)
