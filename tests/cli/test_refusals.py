# SPDX-License-Identifier: Apache-2.0
"""Input and options that tetune refuses, without a loss of data. Run: see cli_case.py."""

import json
import os
import resource
import shutil
import signal
import subprocess
import unittest
from pathlib import Path

import cli_case
from cli_case import CliTest, Mesh, cube, tangled


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

    def test_mesh_that_overlaps_itself(self):
        source = self.put("overlapping.mesh", cli_case.OVERLAPPING)
        self.optimize_refused(source, said=["overlapping.mesh", "overlaps itself", "first, counted from 1: ", "--no-flips"])
        self.run_cli("optimize", source, "-o", self.path("kept.mesh"), "--no-flips", "--keep-vertices")

    def test_empty_names(self):
        for words in (["", "out.mesh"], ["in.mesh", ""], ["in.mesh", "", "-o", "out/"]):
            self.refused("optimize", *words, said=["name of a mesh is empty"])
        self.refused("info", "", said=["name of a mesh is empty"])

    def test_empty_values(self):
        self.put("in.mesh", cube(2))
        self.put("other.mesh", cube(2))
        for name in ("-o", "--max-deviation", "--target-dihedral", "--tags", "--report", "--map", "--trace"):
            self.refused("optimize", self.path("in.mesh"), self.path("other.mesh"), name, "",
                         said=["is empty (a variable of the shell that is not set?)"])
        self.refused("info", self.path("in.mesh"), "--cell-data", "", said=["is empty"])

    def test_outputs_that_are_read_too(self):
        source = self.put("in.mesh", cube(2))
        pairs, limits = self.put("pairs.txt", "1 2\n"), self.put("limits.toml", "")
        for words, file in ((["--periodic-map", pairs, "--map", pairs], pairs), (["--geometry", limits, "--report", limits], limits),
                            (["--periodic-map", pairs, "--trace", pairs], pairs)):
            self.refused("optimize", source, "-o", self.path("out.mesh"), *words, said=[file, "is read as well"])
        self.refused("move", source, "--to", self.path("in.mesh"), "-o", self.path("b.mesh"), "--map", self.path("in.mesh"),
                     said=["in.mesh", "is read as well"])
        self.assertEqual(self.read_bytes("pairs.txt"), b"1 2\n")

    def test_outputs_over_a_file_that_the_input_includes(self):
        mesh = cube(2)
        nodes = "*NODE\n" + "".join(f"{i + 1}, {', '.join(map(repr, p))}\n" for i, p in enumerate(mesh.points))
        deck = "*HEADING\n*Include, input=more.inc\n*ELEMENT, TYPE=C3D4, ELSET=ALL\n" + "".join(
            f"{i + 1}, {', '.join(str(v + 1) for v in t)}\n" for i, t in enumerate(mesh.tets))
        source, part = self.put("in.inp", deck), self.put("part.inp", nodes)
        self.put("more.inc", "*INCLUDE, INPUT=part.inp\n")
        said = ["part.inp would be written for", "is read as well"]
        self.refused("optimize", source, "-o", part, said=said)
        self.refused("optimize", source, "-o", self.path("out.inp"), "--report", part, said=said)
        self.refused("convert", source, "-o", part, said=said)
        self.refused("move", source, "--to", source, "-o", part, said=said)
        # A deck that another one includes cannot be replaced by its own result either.
        self.put("part.inp", nodes + deck.split("more.inc\n")[1])
        self.put("in.inp", "*INCLUDE, INPUT=part.inp\n")
        before = self.read_bytes("part.inp")
        self.refused("optimize", part, source, "-o", self.path("") + "/", said=["part.inp would be written for"])
        self.assertEqual(self.read_bytes("part.inp"), before)
        self.run_cli("optimize", source, "-o", source)
        self.assertEqual(self.read_bytes("part.inp"), before)

    def test_outputs_over_pieces_of_a_file_of_vtk(self):
        pieces = "".join(f'<Piece Source="piece{i}.vtu"/>' for i in range(2))
        source = self.put("all.pvtu", '<?xml version="1.0"?>\n<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid>'
                          f"<FieldData><DataArray>1 2</DataArray></FieldData>{pieces}</PUnstructuredGrid></VTKFile>\n")
        series = self.put("in.pvd", '<VTKFile type="Collection"><Collection>'
                          '<DataSet timestep="0" file="all.pvtu"/></Collection></VTKFile>\n')
        piece = self.put("piece1.vtu", "a piece")
        self.refused("optimize", source, "-o", piece, said=["piece1.vtu would be written for", "is read as well"])
        self.refused("move", series, "-o", self.path("out.pvd"), "--report", piece,
                     said=["piece1.vtu would be written for", "is read as well"])
        self.refused("move", series, "-o", self.path("out.pvd"), "--report", source,
                     said=["all.pvtu would be written for", "is read as well"])
        self.assertEqual(self.read_bytes("piece1.vtu"), b"a piece")

    def test_report_that_cannot_be_written(self):
        source = self.put("in.mesh", cube(2))
        self.refused("optimize", source, "-o", self.path("out.mesh"), "--report", "/proc/none.json", said=["/proc/none.json: "])
        self.assertFalse(os.path.exists(self.path("out.mesh")))

    def test_no_bound_on_the_deviation(self):
        source = self.put("in.mesh", cube(2))
        self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--boundary", "slide", "--max-deviation", "0")
        self.refused("optimize", source, "-o", self.path("out.mesh"), "--boundary", "slide", "--max-deviation", "-1",
                     said=["is not a length"])

    def test_comparison_without_tetrahedra(self):
        empty = self.put("empty.mesh", Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], []))
        self.run_cli("compare", empty, empty, code=1)

    def test_inverted_tetrahedra(self):
        self.optimize_refused(self.put("in.mesh", tangled(4)), said=[
            self.path("in.mesh"), " are inverted (negative volume) (first, counted from 1: ", ", the first near ", "--untangle"])

    def test_untangle(self):
        name, out = self.put("in.mesh", tangled(4)), self.path("out.mesh")
        text = self.run_cli("optimize", name, "-o", out, "--untangle").stdout
        self.assertIn("inverted or flat tetrahedra made positive", text)
        self.assertTrue(json.loads(self.run_cli("info", "--json", out).stdout)["validity"]["valid"])

    def test_untangling_may_fail(self):
        """Exit code 1, which ones are left, and nothing written."""
        mesh = cube(2)
        mesh.points[4] = (0.5, 0.5, 1.5)  # from the middle of the bottom through the top
        run = self.run_cli("optimize", self.put("in.mesh", mesh), "-o", self.path("out.mesh"), "--untangle", code=1)
        self.assertRegex(run.stderr, r"of \d+ inverted or flat tetrahedra some could not be made positive: the surface of "
                                     r"the mesh crosses itself or is folded onto itself at \d+ tetrahedra \(first, counted from 1: ")
        # No vertex may move, and an inner one is out of place.
        mesh = cube(4, jitter=0)
        mesh.points[mesh.points.index((0.5, 0.5, 0.5))] = (0.5, 0.5, 0.9)
        required = [f"RequiredVertices\n{len(mesh.points)}", *(str(i + 1) for i in range(len(mesh.points)))]
        name = self.put("in.mesh", mesh.text().replace("End", "\n".join([*required, "End"])))
        self.put("out.mesh", "an old file")
        run = self.run_cli("optimize", name, "-o", self.path("out.mesh"), "--untangle", "--boundary", "fixed", code=1)
        self.assertRegex(run.stderr, r"of \d+ inverted or flat tetrahedra some could not be made positive, or not without "
                                     r"folding the surface: \d+ tetrahedra there \(first, counted from 1: ")
        self.assertIn("The first is near ", run.stderr)
        self.assertIn("let the boundary slide", run.stderr)
        self.assertEqual(self.read_bytes("out.mesh").decode(), "an old file")
        # The report lists all that are left; a dry run writes none.
        report = ("--report", self.path("r.json"), "--untangle", "--boundary", "fixed")
        self.run_cli("optimize", name, "-o", self.path("out.mesh"), *report, "--dry-run", code=1)
        self.assertEqual(self.files(), ["in.mesh", "out.mesh"])
        self.run_cli("optimize", name, "-o", self.path("out.mesh"), *report, code=1)
        listed = json.loads(self.read_bytes("r.json"))["untangling"]
        self.assertEqual(listed["left"], sorted(set(listed["left"])))
        self.assertIn(f"{len(listed['left'])} tetrahedra there", run.stderr)

    def test_mixed_orientation_is_made_one(self):
        mesh = cube(3)
        for t in (4, 9, 30, 31, 77, 100):
            a, b, c, d = mesh.tets[t]
            mesh.tets[t] = (a, b, d, c)
        name, out = self.put("in.mesh", mesh), self.path("out.mesh")
        run = self.run_cli("optimize", name, "-o", out)
        self.assertIn("6 of 162 tetrahedra are listed inside out, unlike their neighbors; they were reversed", run.stderr)
        self.assertTrue(json.loads(self.run_cli("info", "--json", out).stdout)["validity"]["valid"])

    def test_flat_tetrahedron(self):
        mesh = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [(0, 1, 2, 3)])
        self.optimize_refused(self.put("in.mesh", mesh), said=["1 of the tetrahedra is flat (zero volume) (first, counted from 1: 1)"])

    def test_index_out_of_range(self):
        mesh = cube(2)
        mesh.tets[6] = (0, 1, 2, 1000)
        self.optimize_refused(self.put("in.mesh", mesh), said=["1 of the tetrahedra has an index out of range (first, counted from 1: 7): index 1001, but there are 27 vertices (1 to 27)"])

    def test_a_cut_binary_mesh(self):
        self.put("in.mesh", cube(2))
        self.run_cli("convert", self.path("in.mesh"), self.path("whole.meshb"))
        whole = self.read_bytes("whole.meshb")
        Path(self.path("cut.meshb")).write_bytes(whole[:len(whole) // 2])
        self.refused("info", self.path("cut.meshb"), said=["cut.meshb", "outside the file, which may be cut off"])

    def test_a_coordinate_that_is_far_too_large(self):
        mesh = cube(2)
        mesh.points[4] = (1e200, *mesh.points[4][1:])
        self.refused("optimize", self.put("in.mesh", mesh), "-o", self.path("out.mesh"),
                     said=["too small for arithmetic", "; the largest coordinate is 1e+200, of vertex 5, which may be wrong"])

    def test_no_tetrahedra(self):
        self.optimize_refused(self.put("in.mesh", Mesh([(0, 0, 0)], [])), said=["no tetrahedron"])

    def test_broken_file(self):
        text = cube(2).text().split("\n")
        text[6] = "0.5 half 0.5 1"
        self.optimize_refused(self.put("in.mesh", "\n".join(text)), said=["in.mesh:7: ", '"half"'])

    def test_absent_file(self):
        self.optimize_refused(self.path("absent.mesh"), said=["absent.mesh", "No such file"])

    def test_unknown_endings(self):
        self.optimize_refused(self.put("in.stl", "solid"), said=["in.stl", ".mesh"])
        self.refused("optimize", self.put("in.mesh", cube(1)), "-o", self.path("out.stl"), said=["out.stl", ".mesh"])

    def test_endings_of_other_programs_have_advice(self):
        for name, advice in (("in.cdb", "mapdl-archive"), ("in.fem", "name it .bdf"), ("in.dat", ".inp; known endings")):
            self.optimize_refused(self.put(name, "x"), said=[advice])

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
                        ["-v", "11"]):
            self.optimize_refused(source, *options, said=[options[-1]])
        self.refused("optimize", "-o", self.path("out.mesh"), said=["input"])

    def test_contradictory_options(self):
        source = self.put("in.mesh", cube(1))
        self.optimize_refused(source, "--quiet", "-v", "2", said=["--quiet", "-v"])

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
            process = subprocess.Popen([cli_case.TETUNE, "optimize", source, "-o", self.path("out.mesh"), "--quiet"])
            try:
                process.wait(timeout=delay)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
            self.assertIn(self.read_bytes("out.mesh"), (b"an old file", self.read_bytes("whole.mesh")))


if __name__ == "__main__":
    cli_case.main(__doc__)
