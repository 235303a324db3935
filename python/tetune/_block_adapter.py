# SPDX-License-Identifier: Apache-2.0
"""Meshes of blocks of cells with data: what those of meshio, pyvista and ParaView have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._adapter import Adapter, Array, M
from ._core import MeshError, Report, TetMesh, conserve_data
from ._point_data import Unchanged, as_rows, interpolated, is_smooth, transfer_point_data
from ._second_order import LINEAR_KIND, OTHER_KIND, Middles, Nodes
from ._tags import Tags, required_of, tags_of, without_inserted
from ._vtk_stream import CELLS, ORDERS, POINT_FLAGS, TAG_NAMES

# Point data that are no fields.
NO_FIELDS = (*TAG_NAMES, *POINT_FLAGS.values())
# Cells: VTK's number and meshio's name. Pixels and voxels are in files alone.
VTK_CELLS = {number: name for number, (_, name) in CELLS.items() if number not in ORDERS}


class Block(NamedTuple):
    """Cells of one kind, given by their nodes."""

    kind: str
    vertices: Array


class NewBlock(NamedTuple):
    """A block of the result, with the rows of the input's block from which its cells come, and the positions of the cells
    among all of their kind."""

    kind: str
    vertices: Array
    rows: Array
    cells: Array


class BlockAdapter(Adapter[M]):
    """A mesh of blocks of cells, with tags for each block or without tags, and required entities."""

    blocks: list[Block]
    _middles: Middles | None = None
    _tags: list[Array] | None = None
    _required: Mapping[str, Any] = {}

    def _find_middles(self) -> None:
        if any(b.kind in LINEAR_KIND for b in self.blocks):
            self._middles = Middles(self.points(), [(b.kind, b.vertices) for b in self.blocks])

    def _find_constraints(
        self, tags: Tags, point_data: Mapping[str, Any], names: list[str], values_of: Callable[[str], Sequence[Any]]
    ) -> None:
        """Tags and required entities. `values_of` gives the cell data of a name, one array per block."""
        self._tags = tags_of(tags, names, values_of)
        self._required = required_of(point_data, self.vertices(), [_linear_kind(b) for b in self.blocks], names, values_of)

    def tet_mesh(self) -> TetMesh:
        tets = self._joined("tetra")
        if tets is None:
            kinds = ", ".join(sorted({b.kind for b in self.blocks})) or "none"
            raise MeshError(f"there is no tetrahedron in this mesh; its cells are: {kinds}")
        middles = self._middles
        others = [b for b in self.blocks if _linear_kind(b) not in ("tetra", "triangle", "line")]
        return TetMesh(
            self.points() if middles is None else self.points()[middles.vertices],
            tets,
            tet_tags=self._joined_tags("tetra"),
            triangles=self._joined("triangle"),
            triangle_tags=self._joined_tags("triangle"),
            edges=self._joined("line"),
            edge_tags=self._joined_tags("line"),
            others=[(OTHER_KIND.get(b.kind, b.kind), self._linear(b)) for b in others],
            second_order_others=[b.kind in OTHER_KIND for b in others],
            **self._required,
            **({} if middles is None else middles.curved_arguments()),
        )

    def vertices(self) -> Array | None:
        return None if self._middles is None else self._middles.vertices

    def second_order(self, work: TetMesh) -> Any:
        if self._middles is not None:
            return self.result(work, Unchanged(), self.nodes(work, Unchanged(), self._all_vertices(work)))
        second = {linear: kind for kind, linear in LINEAR_KIND.items()}
        self._middles = Middles(self.points(), [(b.kind, b.vertices) for b in self.blocks])
        self.blocks = [Block(second.get(b.kind, b.kind), b.vertices) for b in self.blocks]
        return self.result(work, Unchanged(), self.nodes(work, Unchanged(), self._all_vertices(work)))

    @staticmethod
    def _all_vertices(work: TetMesh) -> NDArray[np.int32]:
        return np.arange(len(work.points), dtype=np.int32)

    def _linear(self, block: Block) -> Array:
        return block.vertices if self._middles is None else self._middles.linear(block.kind, block.vertices)

    def _joined(self, kind: str) -> Array | None:
        return _joined([self._linear(b) for b in self.blocks if _linear_kind(b) == kind])

    def _joined_tags(self, kind: str) -> Array | None:
        return _joined([tags for b, tags in zip(self.blocks, self._tags or []) if _linear_kind(b) == kind])

    def nodes(self, work: TetMesh, report: Report | Unchanged, vertex_map: NDArray[np.int32]) -> Nodes:
        if self._middles is None:
            return Nodes(work.points, vertex_map)
        return self._middles.result(work, vertex_map, [(b.kind, b.vertices) for b in self._linear_blocks(work, report)])

    def new_blocks(self, work: TetMesh, report: Report | Unchanged, nodes: Nodes) -> list[NewBlock]:
        """The blocks of the result, in the order of those of the input."""
        blocks = self._linear_blocks(work, report)
        if nodes.middles is None:
            return blocks
        return [NewBlock(b.kind, nodes.middles.cells(b.kind, b.vertices), b.rows, b.cells) for b in blocks]

    def new_point_data(self, data: Mapping[str, Any], work: TetMesh, report: Report | Unchanged, nodes: Nodes) -> dict[str, Array]:
        """Data of the nodes of the result, as the option `data` says."""
        points = len(self.points())
        if nodes.middles is None:
            return without_inserted(transfer_point_data(data, work, report, nodes.origin, points), data, nodes.origin)
        vertices = nodes.middles.input.vertices
        vertex_map = report.vertex2original if len(report.vertex2original) else self._all_vertices(work)
        of_vertices = {name: np.asarray(values)[vertices] for name, values in data.items()}
        new = transfer_point_data(of_vertices, work, report, vertex_map, len(vertices))
        return without_inserted(nodes.middles.transfer(data, new, nodes, len(report.place_weights) > 0), data, nodes.origin)

    def _linear_blocks(self, work: TetMesh, report: Report | Unchanged) -> list[NewBlock]:
        """The blocks of the result by vertices, of the kinds of the input."""
        cells = {"tetra": work.tets, "triangle": work.triangles, "line": work.edges}
        parents = {"tetra": report.tet2original, "triangle": report.triangle2original, "line": report.edge2original}
        given = {kind: sum(len(b.vertices) for b in self.blocks if _linear_kind(b) == kind) for kind in cells}
        others = iter(work.others)
        first = dict.fromkeys(cells, 0)
        blocks: list[NewBlock] = []
        for b in self.blocks:
            kind = _linear_kind(b)
            if kind not in cells:
                rows = np.arange(len(b.vertices))
                blocks.append(NewBlock(b.kind, next(others)[1], rows, rows))
                continue
            begin, end = first[kind], first[kind] + len(b.vertices)
            first[kind] = end
            parent = parents[kind]
            # An empty map says that all were kept, or that none was.
            if len(parent) == 0 and len(cells[kind]) == given[kind]:
                blocks.append(NewBlock(b.kind, cells[kind][begin:end], np.arange(len(b.vertices)), np.arange(begin, end)))
                continue
            mine = (parent >= begin) & (parent < end)
            if mine.all():
                blocks.append(NewBlock(b.kind, cells[kind], parent - begin, np.arange(len(parent))))
            else:
                blocks.append(NewBlock(b.kind, cells[kind][mine], parent[mine] - begin, np.flatnonzero(mine)))
        return blocks

    def conserved(
        self, point_data: Mapping[str, Any], tet_data: Mapping[str, Array], work: TetMesh, report: Report
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Data of the vertices and of all tetrahedra of the result, with data="conserve"."""
        points = {name: np.asarray(values) for name, values in point_data.items()}
        smooth = [name for name, values in points.items() if is_smooth(values)]
        smooth_tets = [name for name, values in tet_data.items() if is_smooth(values)]
        before = self.tet_mesh()
        rows = np.arange(len(before.tets), dtype=np.int32)
        new_points, (source, *new_tets) = conserve_data(
            before, work, report,
            [as_rows(points[name]) for name in smooth],
            [as_rows(v) for v in (rows, *(tet_data[name] for name in smooth_tets))],
        )
        smooth_of = dict(zip(smooth, new_points))
        smooth_of_tets = dict(zip(smooth_tets, new_tets))
        places, weights = report.place_vertices, report.place_weights
        vertex_map = report.vertex2original if len(report.vertex2original) else self._all_vertices(work)
        new = {
            name: smooth_of[name].reshape(-1, *v.shape[1:]) if name in smooth_of else interpolated(v, places, weights)
            for name, v in points.items()
        }
        return (
            without_inserted(new, points, vertex_map),
            {
                name: smooth_of_tets[name].reshape(-1, *v.shape[1:]) if name in smooth_of_tets else v[source[:, 0]]
                for name, v in tet_data.items()
            },
        )


def _linear_kind(block: Block) -> str:
    return LINEAR_KIND.get(block.kind, block.kind)


def _joined(parts: list[Array]) -> Array | None:
    if len(parts) == 0:
        return None
    return parts[0] if len(parts) == 1 else np.concatenate(parts)
