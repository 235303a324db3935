# SPDX-License-Identifier: Apache-2.0
"""Grids of pyvista."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ._adapter import Array
from ._block_adapter import NO_FIELDS, VTK_CELLS, Block, BlockAdapter
from ._core import MeshError, Report, TetMesh
from ._point_data import Unchanged, displacement_of, is_smooth
from ._second_order import Nodes
from ._tags import Tags

if TYPE_CHECKING:
    import pyvista as pv


class PyvistaAdapter(BlockAdapter["pv.UnstructuredGrid"]):
    def __init__(self, grid: pv.UnstructuredGrid, tags: Tags) -> None:
        self._grid = grid
        types = grid.celltypes
        present = [int(t) for t in np.unique(types)]
        for t in present:
            if t not in VTK_CELLS:
                raise MeshError(f"cells of VTK type {t} are not supported; supported are: "
                                + ", ".join(f"{name} ({n})" for n, name in VTK_CELLS.items()))
        if len(present) == 1:
            self.blocks = [Block(VTK_CELLS[present[0]], grid.cell_connectivity.reshape(grid.n_cells, -1))]
            self._cells = [np.arange(grid.n_cells)]
        else:
            cells = {int(t): np.asarray(vertices) for t, vertices in grid.cells_dict.items()}
            self.blocks = [Block(VTK_CELLS[t], cells[t]) for t in present]
            self._cells = [np.flatnonzero(types == t) for t in present]
        self._find_middles()
        self._find_constraints(tags, dict(grid.point_data), list(grid.cell_data.keys()),
                               lambda name: [np.asarray(grid.cell_data[name])[c] for c in self._cells])

    def points(self) -> Array:
        return np.asarray(self._grid.points)

    def point_data(self, name: str) -> Array:
        return displacement_of(dict(self._grid.point_data), name)

    def fields(self) -> list[str]:
        data = self._grid.point_data.items()
        return [name for name, values in data if name not in NO_FIELDS and is_smooth(np.asarray(values))]

    def result(self, work: TetMesh, report: Report | Unchanged, nodes: Nodes) -> pv.UnstructuredGrid:
        import pyvista as pv

        old = self._grid
        blocks = self.new_blocks(work, report, nodes)
        numbers = {name: number for number, name in VTK_CELLS.items()}
        counts = [len(b.vertices) for b in blocks]
        widths = np.repeat([b.vertices.shape[1] for b in blocks], counts)
        offsets = np.concatenate([[0], np.cumsum(widths)])
        connectivity = np.concatenate([b.vertices.reshape(-1) for b in blocks])
        new = pv.UnstructuredGrid()
        # Doubles also where the input has single precision: rounding could turn an element inside out.
        new.points = nodes.points
        new.SetCells(
            pv.convert_array(np.repeat(np.array([numbers[b.kind] for b in blocks], dtype=np.uint8), counts)),
            pv.CellArray.from_arrays(offsets, connectivity.astype(offsets.dtype)),
        )
        parent = np.concatenate([c[b.rows] for c, b in zip(self._cells, blocks)])
        cell_data = {name: np.asarray(values)[parent] for name, values in old.cell_data.items()}
        if self.conserves and isinstance(report, Report):
            tets = next(i for i, b in enumerate(blocks) if b.kind == "tetra")
            tet_data = {name: np.asarray(values)[self._cells[tets]] for name, values in old.cell_data.items()}
            point_data, tet_data = self.conserved(dict(old.point_data), tet_data, work, report)
            begin = sum(counts[:tets])
            for name, values in tet_data.items():
                cell_data[name][begin : begin + counts[tets]] = values
        else:
            point_data = self.new_point_data(dict(old.point_data), work, report, nodes)
        for name, values in point_data.items():
            new.point_data[name] = values
        for name, values in cell_data.items():
            new.cell_data[name] = values
        for name, values in old.field_data.items():
            new.field_data[name] = values
        for a, b in ((old.point_data, new.point_data), (old.cell_data, new.cell_data)):
            b.active_scalars_name = a.active_scalars_name
            b.active_vectors_name = a.active_vectors_name
        return new
