# SPDX-License-Identifier: Apache-2.0
"""Formats through plugins, seen from the command line: damaged files, losses, measures, tags. Run: see cli_case.py."""

import json

import cli_case
from cli_case import Mesh, cube
from format_case import ConversionTest, FormatTest

# One tetrahedron with data on its vertices.
HEAT = """# vtk DataFile Version 3.0
one
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 double
0 0 0 1 0 0 0 1 0 0 0 1
CELLS 1 5
4 0 1 2 3
CELL_TYPES 1
10
POINT_DATA 4
SCALARS heat double 1
LOOKUP_TABLE default
1 2 3 4
"""


class Nastran(FormatTest):
    def test_content_that_is_not_read_is_named(self):
        self.run_tetune("convert", "cube.mesh", "a.bdf")
        self.assertEqual(self.run_tetune("info", "a.bdf").stderr, "")
        bulk = (self.folder / "a.bdf").read_text()
        nodes, ends = bulk[bulk.index("GRID"):], "ENDDATA"
        (self.folder / "b.bdf").write_text("SOL 101\nCEND\nLOAD = 1\nBEGIN BULK\nMAT1,1,2.1+5,,0.3\n+,1.,2.\n"
                                           "PSOLID  1       1\nFORCE*  1\n" + nodes)
        done = self.run_tetune("info", "b.bdf")
        self.assertIn("the statements before BEGIN BULK are not kept", done.stderr)
        self.assertIn("the cards MAT1, PSOLID, FORCE are not kept", done.stderr)
        (self.folder / "b.bdf").write_text(bulk.replace(ends, ""))
        self.assertIn("may be cut short", self.run_tetune("info", "b.bdf").stderr)
        for node in ("GRID,900,7,1.,90.,0.\n", "GRID    900     7       1.      90.     0.\n"):
            (self.folder / "b.bdf").write_text(node + nodes)
            done = self.run_tetune("info", "b.bdf")
            self.assertEqual(done.returncode, 2)
            self.assertIn("b.bdf:1: the coordinate system 7 is used here, and no card defines it", done.stderr)

    def test_a_file_that_the_input_includes_is_not_replaced(self):
        self.run_tetune("convert", "cube.mesh", "mesh.bdf")
        before = (self.folder / "mesh.bdf").read_bytes()
        (self.folder / "job.bdf").write_text("SOL 101\nCEND\nBEGIN BULK\nINCLUDE 'mesh.bdf'\n")
        done = self.run_tetune("optimize", "job.bdf", "-o", "mesh.bdf")
        self.assertEqual(done.returncode, 2)
        self.assertIn("mesh.bdf", done.stderr)
        self.assertEqual((self.folder / "mesh.bdf").read_bytes(), before)
        # The output of an unchanged mesh has its nodes, and no name of another file.
        (self.folder / "sub").mkdir()
        done = self.run_tetune("optimize", "job.bdf", "-o", "sub/out.bdf", "--max-iterations", "0", "--no-flips")
        self.assertEqual(done.returncode, 0, done.stderr)
        out = (self.folder / "sub/out.bdf").read_text()
        self.assertNotIn("INCLUDE", out)
        self.assertEqual(out.count("GRID*"), 5)


class Conversions(ConversionTest):
    def test_damaged_files_touch_nothing(self):
        for ending in ("vtu", "vtk", "e", "msh"):
            self.assertEqual(self.run_tetune("optimize", "cube.mesh", "-o", f"a.{ending}").returncode, 0)
            whole = (self.folder / f"a.{ending}").read_bytes()
            for part in (0.33, 0.6, 0.9, 0.97):
                (self.folder / f"bad.{ending}").write_bytes(whole[:int(part * len(whole))])
                (self.folder / "out.mesh").write_text("old")
                done = self.run_tetune("optimize", f"bad.{ending}", "-o", "out.mesh")
                self.assertEqual(done.returncode, 2, (ending, part))
                self.assertIn(f"bad.{ending}", done.stderr)
                self.assertNotIn("vtkInformation", done.stderr)
                self.assertEqual((self.folder / "out.mesh").read_text(), "old")

    def test_formats_that_this_build_of_gmsh_lacks_are_refused_before_the_work(self):
        for ending in ("med", "cgns"):
            done = self.run_tetune("optimize", "absent.mesh", "-o", f"out.{ending}")
            if "absent.mesh" in done.stderr:
                self.skipTest("this build of Gmsh has them")
            self.assertEqual(done.returncode, 2)
            self.assertIn(f"out.{ending}: this build of Gmsh has no ", done.stderr)

    def test_measures_come_with_the_mesh(self):
        info = json.loads(self.run_tetune("info", "--json", "cube.mesh").stdout)["quality"]
        for ending in ("vtu", "vtk", "e", "msh"):
            done = self.run_tetune("info", "cube.mesh", "--cell-data", f"q.{ending}")
            self.assertEqual(done.returncode, 0, done.stderr)
            done = self.run_tetune("info", f"q.{ending}")
            for measure in info["measures"]:
                self.assertIn(measure, done.stdout.split("data on tetrahedra")[1].splitlines()[0], ending)
            again = json.loads(self.run_tetune("info", "--json", f"q.{ending}").stdout)["quality"]
            self.assertEqual(again["measures"], info["measures"], ending)

    def test_data_sets_of_ideas_that_are_not_read_are_named(self):
        self.run_tetune("convert", "cube.mesh", "a.unv")
        self.assertEqual(self.run_tetune("info", "a.unv").stderr, "")
        whole = (self.folder / "a.unv").read_text()
        (self.folder / "b.unv").write_text(whole + "    -1\n  2414\n         1\n    -1\n    -1\n   790\n    -1\n")
        self.assertIn("the data sets 2414 (results), 790 (loads) are not kept", self.run_tetune("info", "b.unv").stderr)

    def test_groups_of_ideas_come_to_gmsh(self):
        self.run_tetune("convert", "cube.mesh", "a.unv")
        text = (self.folder / "a.unv").read_text().replace("Volume1\n", "hot part\n")
        self.assertIn("hot part", text)
        (self.folder / "b.unv").write_text(text)
        done = self.run_tetune("convert", "b.unv", "c.msh")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn(b'"hot part"', (self.folder / "c.msh").read_bytes())
        done = self.run_tetune("convert", "c.msh", "d.unv")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.folder / "d.unv").read_text(), text)

    def test_a_file_of_ideas_that_ends_within_a_data_set_is_refused(self):
        self.run_tetune("convert", "cube.mesh", "a.unv")
        whole = (self.folder / "a.unv").read_text()
        end = whole.rindex("    -1")
        for cut in (whole[:len(whole) // 3], whole[:2 * len(whole) // 3], whole[:end], whole[:end - 20]):
            (self.folder / "b.unv").write_text(cut)
            done = self.run_tetune("optimize", "b.unv", "out.unv")
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, r"b\.unv:\d+: it ends within the data set (2411|2412|2467|2477), before the -1 .* cut short")
            self.assertFalse((self.folder / "out.unv").exists())
        # Where only the mark of another data set is left, the mesh is whole.
        (self.folder / "b.unv").write_text(whole + "    -1\n")
        done = self.run_tetune("info", "b.unv")
        self.assertEqual(done.returncode, 0)
        self.assertIn("may be cut short", done.stderr)

    def test_losses_are_named(self):
        (self.folder / "in.vtk").write_text(HEAT)
        for output, named in (("out.vtu", None), ("out.mesh", "out.mesh"), ("-", "standard output")):
            done = self.run_tetune("optimize", "in.vtk", output)
            self.assertEqual(done.returncode, 0, done.stderr)
            warnings = [line for line in done.stderr.splitlines() if "heat" in line]
            self.assertEqual(warnings, [] if named is None else
                             [f'tetune: warning: {named}: the format cannot hold the data "heat"'])
            self.assertEqual(done.stdout.startswith("MeshVersionFormatted"), output == "-")

    def test_data_of_any_name_number_the_regions(self):
        """--tags: interfaces stay, and so do the data; without it there is a warning."""
        mesh = cube(4)
        regions = [1 + (sum(mesh.points[v][0] for v in t) > 2) for t in mesh.tets]
        lines = ["# vtk DataFile Version 3.0", "cube", "ASCII", "DATASET UNSTRUCTURED_GRID", f"POINTS {len(mesh.points)} double",
                 *(" ".join(map(repr, p)) for p in mesh.points), f"CELLS {len(mesh.tets)} {5 * len(mesh.tets)}",
                 *("4 " + " ".join(map(str, t)) for t in mesh.tets), f"CELL_TYPES {len(mesh.tets)}", *["10"] * len(mesh.tets),
                 f"CELL_DATA {len(mesh.tets)}", "SCALARS steel int 1", "LOOKUP_TABLE default", *map(str, regions)]
        (self.folder / "in.vtk").write_text("\n".join(lines) + "\n")

        def volume_change(output):
            output_text = self.run_tetune("compare", "in.vtk", output, "--json", "--tags", "steel").stdout
            return json.loads(output_text)["change"]["region_volume_change"]

        done = self.run_tetune("optimize", "in.vtk", "-o", "plain.vtu")
        self.assertIn('the cell data "steel" look like numbers of regions', done.stderr)
        self.assertGreater(volume_change("plain.vtu"), 1e-6)
        for output in ("out.vtu", "out.mesh"):
            done = self.run_tetune("optimize", "in.vtk", "-o", output, "--tags", "steel")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("look like", done.stderr)
            self.assertLess(volume_change(output), 1e-12)
        # A reader of the result finds the regions without --tags.
        done = self.run_tetune("optimize", "out.vtu", "-o", "again.vtu")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertLess(volume_change("again.vtu"), 1e-12)
        self.assertEqual(set(Mesh.read(self.folder / "out.mesh").tet_tags), {1, 2})

        # Names may hold any bytes: the report is written all the same.
        (self.folder / "latin.vtk").write_bytes((self.folder / "in.vtk").read_bytes().replace(b"steel", b"st\xe9el"))
        done = self.run_tetune("optimize", "latin.vtk", "-o", "latin.vtu", "--report", "latin.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("look like numbers of regions", json.loads((self.folder / "latin.json").read_text())["warnings"][0])
        # Those that are the tags already may be named.
        done = self.run_tetune("optimize", "again.vtu", "-o", "named.vtu", "--tags", "medit:ref")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

        done = self.run_tetune("optimize", "in.vtk", "-o", "no.mesh", "--tags", "iron")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--tags \"iron\": in.vtk: the tetrahedra have no data \"iron\"; their data are: steel", done.stderr)
        self.assertFalse((self.folder / "no.mesh").exists())


if __name__ == "__main__":
    cli_case.main(__doc__)
