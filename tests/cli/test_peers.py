# SPDX-License-Identifier: Apache-2.0
"""What other programs write and read goes through tetune. Run: see cli_case.py.

The programs are meshio, pyvista and the gmsh module, where $TETUNE_PEERS_PYTHON (or this Python) has them.
"""

import json
import os
import subprocess
import sys

import cli_case
from format_case import ConversionTest

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


def peers(*modules):
    """A Python with the modules, or None."""
    for python in filter(None, [os.environ.get("TETUNE_PEERS_PYTHON"), sys.executable, "/usr/bin/python3"]):
        code = "import " + ", ".join(modules)
        if subprocess.run([python, "-c", code], capture_output=True).returncode == 0:
            return python
    return None


class Peers(ConversionTest):
    def python(self, python, code, *arguments):
        done = subprocess.run([python, "-c", code, *arguments], cwd=self.folder, capture_output=True, text=True,
                              timeout=cli_case.HANG)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

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
    cli_case.main(__doc__)
