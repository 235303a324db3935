# SPDX-License-Identifier: Apache-2.0
"""Meshes of meshio."""

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
    import meshio


class MeshioAdapter(BlockAdapter["meshio.Mesh"]):
    def __init__(self, mesh: meshio.Mesh, tags: Tags) -> None:
        self._mesh = mesh
        for b in mesh.cells:
            if b.type not in VTK_CELLS.values():
                raise MeshError(f"cells of type {b.type} are not supported; supported are: "
                                f"{', '.join(VTK_CELLS.values())}")
        self.blocks = [Block(b.type, np.asarray(b.data)) for b in mesh.cells]
        self._find_middles()
        self._find_constraints(tags, mesh.point_data, list(mesh.cell_data), lambda name: list(mesh.cell_data[name]))

    def points(self) -> Array:
        return np.asarray(self._mesh.points)

    def point_data(self, name: str) -> Array:
        return displacement_of(self._mesh.point_data, name)

    def fields(self) -> list[str]:
        data = self._mesh.point_data.items()
        return [name for name, values in data if name not in NO_FIELDS and is_smooth(np.asarray(values))]

    def result(self, work: TetMesh, report: Report | Unchanged, nodes: Nodes) -> meshio.Mesh:
        import meshio

        old = self._mesh
        blocks = self.new_blocks(work, report, nodes)
        cell_data = {
            name: [np.asarray(v)[b.rows] for v, b in zip(values, blocks)]
            for name, values in old.cell_data.items()
        }
        if self.conserves and isinstance(report, Report):
            tet_data = {
                name: np.concatenate([np.asarray(v) for v, b in zip(values, blocks) if b.kind == "tetra"])
                for name, values in old.cell_data.items()
            }
            point_data, tet_data = self.conserved(old.point_data, tet_data, work, report)
            for name, parts in cell_data.items():
                for i, b in enumerate(blocks):
                    if b.kind == "tetra":
                        parts[i] = tet_data[name][b.cells]
        else:
            point_data = self.new_point_data(old.point_data, work, report, nodes)
        place = np.full(len(old.points), -1)
        place[nodes.origin[nodes.origin >= 0]] = np.flatnonzero(nodes.origin >= 0)
        new = meshio.Mesh(
            nodes.points,
            [(b.kind, b.vertices) for b in blocks],
            point_data=point_data,
            cell_data=cell_data,
            field_data=old.field_data,
            point_sets={name: place[v][place[v] >= 0] for name, v in old.point_sets.items()},
            info=old.info,
        )
        for name, sets in old.cell_sets.items():
            # Gmsh's reader stores ids of entities under this name, not of cells.
            new.cell_sets[name] = sets if name == "gmsh:bounding_entities" else [
                None if ids is None else np.flatnonzero(np.isin(b.rows, ids)) for ids, b in zip(sets, blocks)
            ]
        return new
