# SPDX-License-Identifier: Apache-2.0
"""The filter in ParaView: pvpython python/tests/paraview_run.py, with tetune and this folder on the path. Writes nothing.

By hand: Debian's python3-paraview cannot be installed together with libvtk9-dev."""

import inspect

# ParaView 5.11 of Debian 12 takes it from inspect, which Python 3.11 does not have any more.
if not hasattr(inspect, "getargspec"):
    inspect.getargspec = inspect.getfullargspec

import numpy as np
import tetune
from paraview.simple import LoadPlugin, TrivialProducer
from paraview import servermanager
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, VTK_TRIANGLE, vtkUnstructuredGrid

from meshes import BRACKET

mesh = tetune.read_mesh(str(BRACKET))
grid = vtkUnstructuredGrid()
points = vtkPoints()
points.SetData(numpy_to_vtk(mesh.points.copy(), deep=True))
grid.SetPoints(points)
for tet in mesh.tets.tolist():
    grid.InsertNextCell(VTK_TETRA, 4, tet)
for triangle in mesh.triangles.tolist():
    grid.InsertNextCell(VTK_TRIANGLE, 3, triangle)
for name, values, data in (
    ("medit:ref", np.concatenate([mesh.tet_tags, mesh.triangle_tags]), grid.GetCellData()),
    ("x", mesh.points[:, 0].copy(), grid.GetPointData()),
):
    array = numpy_to_vtk(values, deep=True)
    array.SetName(name)
    data.AddArray(array)

LoadPlugin(str(tetune.__path__[0]) + "/paraview_plugin.py", ns=globals(), remote=False)
source = TrivialProducer()
source.GetClientSideObject().SetOutput(grid)
expected = tetune.optimize(tetune.TetMesh(mesh.points, mesh.tets, tet_tags=mesh.tet_tags, triangles=mesh.triangles,
                                          triangle_tags=mesh.triangle_tags), effort="fast").mesh
out = servermanager.Fetch(globals()["Tetune"](Input=source, Effort="fast"))
assert np.array_equal(vtk_to_numpy(out.GetPoints().GetData()), expected.points)
assert out.GetNumberOfCells() == len(expected.tets) + len(expected.triangles)
tags = vtk_to_numpy(out.GetCellData().GetArray("medit:ref"))
kinds = vtk_to_numpy(out.GetCellTypesArray())
assert np.array_equal(tags[kinds == VTK_TETRA], expected.tet_tags)
assert np.array_equal(vtk_to_numpy(out.GetPointData().GetArray("x")), mesh.points[:, 0])
print("the filter gives the mesh of tetune.optimize()")
