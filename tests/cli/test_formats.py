# SPDX-License-Identifier: Apache-2.0
"""Formats through plugins, seen from the command line: what is missing or fails is an error with exit code 2, and what
other programs write and read goes through.

Run:  python3 test_formats.py path/to/tetune [names of tests]

Conversions are checked with meshio, pyvista and the gmsh module where $TETUNE_PEERS_PYTHON (or this Python) has them.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from cli_case import Mesh, cube

TETUNE = ""
CUBE = """MeshVersionFormatted 2 Dimension 3
Vertices 5  0 0 0 0  1 0 0 0  0 1 0 0  0 0 1 0  1 1 1 0
Tetrahedra 2  1 2 3 4 1  2 3 4 5 2
Triangles 2  2 3 4 7  1 2 3 8
End
"""
# Two boxes side by side with named groups; one surface group, one line and one point.
BOXES = """import gmsh
gmsh.initialize(); gmsh.option.setNumber("General.Terminal", 0)
m, o = gmsh.model, gmsh.model.occ
o.addBox(0, 0, 0, 1, 1, 1); o.addBox(1, 0, 0, 1, 1, 1)
o.fragment([(3, 1)], [(3, 2)]); o.synchronize()
m.addPhysicalGroup(3, [1], 10); m.setPhysicalName(3, 10, "steel")
m.addPhysicalGroup(3, [2], 11); m.setPhysicalName(3, 11, "air gap")
m.addPhysicalGroup(3, [1, 2], 12); m.setPhysicalName(3, 12, "all of it")
outer = [t for _, t in m.getBoundary([(3, 1), (3, 2)], True, False)]
m.addPhysicalGroup(2, outer[:2], 1); m.setPhysicalName(2, 1, "inlet")
m.addPhysicalGroup(2, outer[2:], 2); m.setPhysicalName(2, 2, "wall")
m.addPhysicalGroup(1, [1], 5); m.setPhysicalName(1, 5, "rim")
m.addPhysicalGroup(0, [1], 7); m.setPhysicalName(0, 7, "probe")
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.25)
m.mesh.generate(3)
for version in (2.2, 4.1):
    gmsh.option.setNumber("Mesh.MshFileVersion", version); gmsh.write(f"{version}.msh")
"""
# A periodic box with an inclusion, in every version and encoding: elements of groups and all elements, with parametric
# coordinates, of second order, in partitions.
PERIODIC = """import gmsh
gmsh.initialize(); gmsh.option.setNumber("General.Terminal", 0)
m, o = gmsh.model, gmsh.model.occ
o.addBox(0, 0, 0, 1, 1, 1); o.addSphere(.5, .5, .5, .25); o.fragment([(3, 1)], [(3, 2)]); o.synchronize()
volumes = [t for _, t in m.getEntities(3)]
m.addPhysicalGroup(3, [volumes[0]], 10); m.setPhysicalName(3, 10, "inclusion")
m.addPhysicalGroup(3, [volumes[1]], 11); m.setPhysicalName(3, 11, "matrix")
m.addPhysicalGroup(3, volumes, 12); m.setPhysicalName(3, 12, "all of it")
m.addPhysicalGroup(2, [t for _, t in m.getEntities(2)], 3)
for axis in range(3):
    def faces(x):
        low, high = [-1e-3] * 3, [1.001] * 3
        low[axis], high[axis] = x - 1e-3, x + 1e-3
        return [t for _, t in m.getEntitiesInBoundingBox(*low, *high, 2)]
    move = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]; move[4 * axis + 3] = 1
    m.mesh.setPeriodic(2, faces(1), faces(0), move)
gmsh.option.setNumber("Mesh.MeshSizeMax", .4)
m.mesh.generate(3)
def save(name):
    for version in (2.2, 4.1):
        for binary in (0, 1):
            gmsh.option.setNumber("Mesh.MshFileVersion", version); gmsh.option.setNumber("Mesh.Binary", binary)
            gmsh.write(f"{name}_{version}_{binary}.msh")
save("groups")
gmsh.option.setNumber("Mesh.SaveAll", 1); save("all"); gmsh.option.setNumber("Mesh.SaveAll", 0)
gmsh.option.setNumber("Mesh.SaveParametric", 1); save("parametric"); gmsh.option.setNumber("Mesh.SaveParametric", 0)
gmsh.option.setNumber("Mesh.SecondOrderLinear", 1); m.mesh.setOrder(2); save("second"); m.mesh.setOrder(1)
m.mesh.partition(3); save("parts")
"""
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
# Groups, names, their entities, and elements of the lower dimensions of a file, as JSON.
SUMMARY = """import gmsh, json, sys
gmsh.initialize(); gmsh.option.setNumber("General.Terminal", 0); gmsh.open(sys.argv[1])
m = gmsh.model
groups = [[d, t, m.getPhysicalName(d, t), sorted(map(int, m.getEntitiesForPhysicalGroup(d, t)))]
          for d, t in m.getPhysicalGroups()]
counts = {f"{d} {t}": sum(map(len, m.mesh.getElements(d, t)[1])) for d, t in m.getEntities() if d < 3}
links = {}
for d, t in m.getEntities(2):
    master, nodes, masters, affine = m.mesh.getPeriodicNodes(2, t)
    if len(nodes):
        place = lambda n: m.mesh.getNode(n)[0]
        gap = max(abs(x - y - move) for a, b in zip(nodes, masters)
                  for x, y, move in zip(place(a), place(b), affine[3:12:4]))
        links[t] = [master, len(nodes), bool(gap < 1e-9), list(affine)]
print(json.dumps([groups, {k: n for k, n in counts.items() if n}, links]))
"""

# Whether meshio finds the same names, and the same numbers of triangles by group, in two files.
MESHIO = """import collections, meshio, sys
def summary(name):
    m = meshio.read(name)
    counts = collections.Counter()
    for block, tags in zip(m.cells, m.cell_data.get("gmsh:physical", [])):
        if block.type in ("triangle", "triangle6"):
            counts.update(map(int, tags))
    return {k: list(map(int, v)) for k, v in m.field_data.items()}, counts
before, after = map(summary, sys.argv[1:])
assert before == after, (before, after)
"""


def has_plugin(name):
    return (Path(TETUNE).parent / "../libexec/tetune" / name).is_file()


def peers(*modules):
    """A Python with the modules, or None."""
    for python in filter(None, [os.environ.get("TETUNE_PEERS_PYTHON"), sys.executable, "/usr/bin/python3"]):
        code = "import " + ", ".join(modules)
        if subprocess.run([python, "-c", code], capture_output=True).returncode == 0:
            return python
    return None


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="tetune_formats_"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "cube.mesh").write_text(CUBE)

    def run_tetune(self, *arguments, program=None, env=None):
        return subprocess.run([program or TETUNE, *arguments], cwd=self.folder, capture_output=True, text=True,
                              errors="replace", timeout=300, env=env)

    def python(self, python, code, *arguments):
        done = subprocess.run([python, "-c", code, *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def installation(self, plugin=None):
        """A copy of the program alone, with this text as its VTK plugin."""
        (self.folder / "prefix/bin").mkdir(parents=True)
        program = Path(shutil.copy(TETUNE, self.folder / "prefix/bin/tetune"))
        if plugin is not None:
            self.executable(self.folder / "prefix/libexec/tetune/tetune-vtk", plugin)
        return str(program)

    def executable(self, path, text):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("#!/bin/sh\n" + text + "\n")
        path.chmod(0o755)


class Plugins(Case):
    def setUp(self):
        super().setUp()
        if Path(TETUNE).read_bytes().startswith(b"#!"):
            self.skipTest("an emulator starts the program from the place where it was built")

    def expect_refused(self, program, *parts, env=None):
        (self.folder / "out.vtu").write_text("old")
        done = self.run_tetune("optimize", "cube.mesh", "-o", "out.vtu", program=program, env=env)
        self.assertEqual(done.returncode, 2, done.stderr)
        for part in ("out.vtu",) + parts:
            self.assertIn(part, done.stderr)
        self.assertEqual((self.folder / "out.vtu").read_text(), "old")
        self.assertEqual(list(self.folder.glob("*.tmp*")), [])

    def test_a_missing_plugin_is_named_with_its_package(self):
        self.expect_refused(self.installation(), "install VTK with its headers")

    def test_plugins_are_taken_from_the_installation_alone(self):
        program = self.installation()
        for folder in (".", "libexec/tetune", "bin/../libexec/tetune", "path"):
            self.executable(self.folder / folder / "tetune-vtk", f"touch {self.folder}/ran")
        env = dict(os.environ, PATH=f"{self.folder}/path:{os.environ['PATH']}", LD_LIBRARY_PATH=str(self.folder))
        self.expect_refused(program, "install VTK with its headers", env=env)
        self.assertFalse((self.folder / "ran").exists())

    def test_a_missing_library_is_named_with_its_package(self):
        self.expect_refused(self.installation("exit 127"), "library is missing; install VTK")

    def test_a_crash_of_the_library_is_an_error(self):
        self.expect_refused(self.installation("kill -SEGV $$"), "VTK failed")

    def test_no_answer_is_an_error(self):
        self.expect_refused(self.installation("true"), "no answer")

    def test_a_bad_answer_is_an_error(self):
        self.expect_refused(self.installation("head -c 200 /dev/zero >/proc/self/fd/3"), "another build")

    def test_a_medit_run_starts_no_plugin(self):
        program = self.installation(f"touch {self.folder}/ran")
        done = self.run_tetune("optimize", "cube.mesh", "-o", "out.mesh", program=program)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertFalse((self.folder / "ran").exists())


class Nastran(Case):
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
            self.assertIn("b.bdf:1: a node is in the coordinate system 7", done.stderr)

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


class Conversions(Case):
    def setUp(self):
        super().setUp()
        if not (has_plugin("tetune-vtk") and has_plugin("tetune-gmsh")):
            self.skipTest("built without VTK or Gmsh: install libvtk9-dev and libgmsh-dev")

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

    def test_content_that_gmsh_ignores_is_named(self):
        self.run_tetune("convert", "cube.mesh", "a.unv")
        self.assertEqual(self.run_tetune("info", "a.unv").stderr, "")
        whole = (self.folder / "a.unv").read_text()
        (self.folder / "b.unv").write_text(whole + "    -1\n   164\n         1\n    -1\n    -1\n  2467\n    -1\n")
        self.assertIn("the data sets 164, 2467 are not kept", self.run_tetune("info", "b.unv").stderr)

    def test_a_file_of_ideas_that_ends_within_a_data_set_is_refused(self):
        self.run_tetune("convert", "cube.mesh", "a.unv")
        whole = (self.folder / "a.unv").read_text()
        end = whole.rindex("    -1")
        for cut in (whole[:len(whole) // 3], whole[:2 * len(whole) // 3], whole[:end], whole[:end - 20]):
            (self.folder / "b.unv").write_text(cut)
            done = self.run_tetune("optimize", "b.unv", "out.unv")
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, r"b\.unv: it ends within the data set (2411|2412|2467|2477), before the -1 .* cut short")
            self.assertFalse((self.folder / "out.unv").exists())
        # Where only the mark of another data set is left, the mesh is whole.
        (self.folder / "b.unv").write_text(whole + "    -1\n")
        done = self.run_tetune("info", "b.unv")
        self.assertEqual(done.returncode, 0)
        self.assertIn("may be cut short", done.stderr)

    def test_what_has_no_room_is_told(self):
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

    def test_gmsh_finds_its_groups_names_and_entities_again(self):
        python = peers("gmsh")
        if python is None:
            self.skipTest("no Python with the gmsh module: set TETUNE_PEERS_PYTHON")
        self.python(python, BOXES)
        for version in ("2.2", "4.1"):
            done = self.run_tetune("optimize", f"{version}.msh", "-o", f"out{version}.msh")
            self.assertEqual(done.returncode, 0, done.stderr)
            before, after = (json.loads(self.python(python, SUMMARY, f)) for f in (f"{version}.msh", f"out{version}.msh"))
            self.assertEqual(len(before[0]), 7)
            self.assertEqual(before, after)

    def test_gmsh_and_meshio_read_every_version(self):
        """The same groups, entities, numbers of elements and periodic pairs before and after an optimization."""
        python = peers("gmsh", "meshio")
        if python is None:
            self.skipTest("no Python with the gmsh module and meshio: set TETUNE_PEERS_PYTHON")
        self.python(python, PERIODIC)
        for source in sorted(self.folder.glob("*_*_*.msh")):
            with self.subTest(source.name):
                out = f"out_{source.name}"
                done = self.run_tetune("optimize", source.name, "-o", out, "--effort", "fast", "--threads", "1")
                self.assertEqual(done.returncode, 0, done.stderr)
                warnings = {"parametric": "parametric coordinates", "parts": "the partitions are kept as the data"}
                for word, text in warnings.items():
                    self.assertEqual(source.name.startswith(word), text in done.stderr, done.stderr)
                heads = [(self.folder / name).read_bytes()[:20] for name in (source.name, out)]
                self.assertEqual(heads[0], heads[1])
                before, after = (json.loads(self.python(python, SUMMARY, name)) for name in (source.name, out))
                if source.name.startswith("parts"):  # become one again
                    self.assertEqual([g[:3] for g in before[0]], [g[:3] for g in after[0]])
                    continue
                self.assertEqual(before, after)
                self.assertEqual(len(after[2]), 3 if "4.1" in source.name else 0)  # those that Gmsh reads
                if source.name.startswith(("groups", "second")):  # meshio does not read Gmsh's others
                    self.python(python, MESHIO, source.name, out)

    def test_meshio_and_pyvista_read_what_is_written(self):
        python = peers("meshio", "pyvista")
        if python is None:
            self.skipTest("no Python with meshio and pyvista: set TETUNE_PEERS_PYTHON")
        # Data of every kind, as meshio writes them.
        self.python(python, """import meshio, numpy as np
n = 4
g = np.stack(np.meshgrid(*[np.linspace(0, 1, n)] * 3, indexing="ij"), -1).reshape(-1, 3)
import scipy.spatial
tets = scipy.spatial.Delaunay(g + 1e-3 * np.random.default_rng(1).random(g.shape)).simplices
x = g[tets]
v = np.einsum("ij,ij->i", np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), x[:, 3] - x[:, 0])
tets = tets[np.abs(v) > 1e-9]; v = v[np.abs(v) > 1e-9]
tets[v < 0] = tets[v < 0][:, [0, 1, 3, 2]]
m = meshio.Mesh(g, [("tetra", tets)], point_data={"temperature": g[:, 0], "id": np.arange(len(g))},
                cell_data={"gmsh:physical": [(g[tets].mean(1)[:, 0] > .5).astype(int) + 1]})
m.write("in.vtu")""")
        for ending in ("vtu", "vtk", "msh", "mesh"):
            done = self.run_tetune("optimize", "in.vtu", "-o", f"out.{ending}")
            if "not valid" in done.stderr:
                self.skipTest("this scipy makes another triangulation")
            self.assertEqual(done.returncode, 0, done.stderr)
        self.python(python, """import meshio, numpy as np, pyvista
a = meshio.read("in.vtu")
for name in ("out.vtu", "out.vtk", "out.msh"):
    b = meshio.read(name)
    assert np.array_equal(a.point_data["id"].ravel(), b.point_data["id"].ravel()), name
    assert np.array_equal(a.point_data["temperature"].ravel(), b.point_data["temperature"].ravel()), name
    assert set(np.concatenate(b.cell_data["gmsh:physical"])) == {1, 2}, name
assert set(np.concatenate(meshio.read("out.mesh").cell_data["medit:ref"])) == {1, 2}
for name in ("out.vtu", "out.vtk"):
    g = pyvista.read(name)
    assert set(g.cell_data["gmsh:physical"]) == {1, 2} and "temperature" in g.point_data, name""")


if __name__ == "__main__":
    TETUNE = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()
