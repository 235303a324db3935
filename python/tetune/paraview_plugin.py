# SPDX-License-Identifier: Apache-2.0
"""The filter "Tetune" of ParaView: it optimizes the tetrahedra of an unstructured grid.

In ParaView: Tools, Manage Plugins, Load New, this file; in a script: paraview.simple.LoadPlugin(). ParaView's Python must
find this package: PYTHONPATH, or pvpython --venv."""

from __future__ import annotations

from typing import Any

import numpy as np
from paraview.util.vtkAlgorithm import VTKPythonAlgorithmBase, smdomain, smproperty, smproxy
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDataArray, vtkPoints, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid

import tetune
from tetune._block_adapter import VTK_CELLS, Block, BlockAdapter
from tetune._point_data import transfer_point_data
from tetune._second_order import LINEAR_KIND
from tetune._tags import without_inserted

BOUNDARY = ("preserve", "slide", "fixed")
EFFORT = ("fast", "standard", "best")


def arrays_of(attributes: Any) -> dict[str, Any]:
    arrays = (attributes.GetAbstractArray(i) for i in range(attributes.GetNumberOfArrays()))
    return {a.GetName(): vtk_to_numpy(a) for a in arrays if isinstance(a, vtkDataArray)}


def add_array(attributes: Any, name: str, values: Any) -> None:
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    attributes.AddArray(array)


class GridAdapter(BlockAdapter[vtkUnstructuredGrid]):
    """As PyvistaAdapter, without pyvista, which ParaView does not have."""

    def __init__(self, grid: vtkUnstructuredGrid, tags: str | None) -> None:
        self._grid = grid
        if grid.GetNumberOfCells() == 0:
            raise tetune.MeshError("the input has no cells")
        types = vtk_to_numpy(grid.GetCellTypesArray())
        offsets = vtk_to_numpy(grid.GetCells().GetOffsetsArray())
        ids = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
        self._types = [int(t) for t in np.unique(types)]
        for t in self._types:
            if VTK_CELLS.get(t) is None or VTK_CELLS[t] in LINEAR_KIND:
                raise tetune.MeshError(f"cells of VTK type {t} are not supported; supported are the linear ones: "
                                       + ", ".join(f"{name} ({n})" for n, name in VTK_CELLS.items()
                                                   if name not in LINEAR_KIND))
        self._cells = [np.flatnonzero(types == t) for t in self._types]
        sizes = [offsets[c[0] + 1] - offsets[c[0]] for c in self._cells]
        self.blocks = [
            Block(VTK_CELLS[t], ids[offsets[c][:, None] + np.arange(n)]) for t, c, n in zip(self._types, self._cells, sizes)
        ]
        self._cell_data = arrays_of(grid.GetCellData())
        self._point_data = arrays_of(grid.GetPointData())
        self._find_constraints(tags, self._point_data, list(self._cell_data),
                               lambda name: [self._cell_data[name][c] for c in self._cells])

    def points(self) -> Any:
        return vtk_to_numpy(self._grid.GetPoints().GetData())

    def write(self, result: tetune.Result[tetune.TetMesh], out: vtkUnstructuredGrid) -> None:
        work, report = result.mesh, result.report
        blocks = self.new_blocks(work, report, self.nodes(work, report, result.vertex_map))
        counts = [len(b.vertices) for b in blocks]
        points = vtkPoints()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(work.points), deep=True))
        widths = np.repeat([b.vertices.shape[1] for b in blocks], counts)
        offsets = np.concatenate([[0], np.cumsum(widths)]).astype(np.int64)
        cells = vtkCellArray()
        cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(
            np.concatenate([b.vertices.reshape(-1) for b in blocks]).astype(np.int64), deep=True))
        kinds = vtkUnsignedCharArray()
        kinds.DeepCopy(numpy_to_vtk(np.repeat(np.array(self._types, np.uint8), counts), deep=True))
        out.SetPoints(points)
        out.SetCells(kinds, cells)
        parent = np.concatenate([c[b.rows] for c, b in zip(self._cells, blocks)])
        before = self._grid.GetNumberOfPoints()
        moved = transfer_point_data(self._point_data, work, report, result.vertex_map, before)
        for name, values in without_inserted(moved, self._point_data, result.vertex_map).items():
            add_array(out.GetPointData(), name, values)
        for name, values in self._cell_data.items():
            add_array(out.GetCellData(), name, values[parent])
        out.GetFieldData().ShallowCopy(self._grid.GetFieldData())


def choice(name: str, values: tuple[str, ...], default: str) -> Any:
    entries = "".join(f'<Entry text="{text}" value="{i}"/>' for i, text in enumerate(values))
    return smproperty.xml(
        f'<IntVectorProperty name="{name}" command="Set{name}" number_of_elements="1" '
        f'default_values="{values.index(default)}"><EnumerationDomain name="enum">{entries}</EnumerationDomain>'
        "</IntVectorProperty>"
    )


@smproxy.filter(name="Tetune", label="Tetune")
@smproperty.input(name="Input", port_index=0)
@smdomain.datatype(dataTypes=["vtkUnstructuredGrid"], composite_data_supported=False)
class TetuneFilter(VTKPythonAlgorithmBase):
    def __init__(self) -> None:
        super().__init__(nInputPorts=1, nOutputPorts=1, inputType="vtkUnstructuredGrid", outputType="vtkUnstructuredGrid")
        self._boundary: Any = "preserve"
        self._effort: Any = "standard"
        self._tags = ""

    @choice("Boundary", BOUNDARY, "preserve")
    def SetBoundary(self, value: int) -> None:
        self._boundary = BOUNDARY[value]
        self.Modified()

    @choice("Effort", EFFORT, "standard")
    def SetEffort(self, value: int) -> None:
        self._effort = EFFORT[value]
        self.Modified()

    @smproperty.stringvector(name="Regions", default_values="")
    def SetRegions(self, value: str) -> None:
        """The cell data that number the regions; empty: medit:ref or another of the names in docs/formats.md."""
        self._tags = value
        self.Modified()

    def RequestData(self, request: Any, inputs: Any, outputs: Any) -> int:
        grid = vtkUnstructuredGrid.GetData(inputs[0], 0)
        adapter = GridAdapter(grid, self._tags or None)
        result = tetune.optimize(adapter.tet_mesh(), boundary=self._boundary, effort=self._effort)
        adapter.write(result, vtkUnstructuredGrid.GetData(outputs, 0))
        return 1
