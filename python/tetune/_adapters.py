# SPDX-License-Identifier: Apache-2.0
"""Conversion of meshes of other packages to a TetMesh, and back with all their data."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._core import MeshError, Report, TetMesh, conserve_data
from ._point_data import Unchanged, as_rows, displacement_of, interpolated, is_smooth, transfer_point_data
from ._second_order import LINEAR_KIND, Middles, Nodes
from ._tags import Tags, required_of, tags_of, without_inserted
from ._vtk_stream import CELLS, ORDERS, POINT_FLAGS, TAG_NAMES

if TYPE_CHECKING:
    from typing import TypeAlias

    import meshio
    import pyvista as pv

M = TypeVar("M")
Array: TypeAlias = NDArray[Any]

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


class Adapter(Generic[M]):
    """A mesh given as arrays, for which the result is a TetMesh. Base of the other adapters."""

    conserves = False
    """Whether the result is of a run with data="conserve"."""

    def tet_mesh(self) -> TetMesh:
        raise NotImplementedError

    def points(self) -> Array:
        raise NotImplementedError

    def point_data(self, name: str) -> Array:
        """A displacement: point data with three numbers per vertex."""
        raise TypeError(f"to is {name!r}, the name of point data, which a meshio or pyvista mesh has; "
                        "give the positions as an array")

    def fields(self) -> list[str]:
        """The names of floating-point data of the vertices."""
        return []

    def vertices(self) -> Array | None:
        """The points that are vertices, or None for all: the others are mid-side nodes."""
        return None

    def nodes(self, work: TetMesh, report: Report | Unchanged, vertex_map: NDArray[np.int32]) -> Nodes:
        """The nodes of the result."""
        return Nodes(work.points, vertex_map)

    def result(self, work: TetMesh, report: Report | Unchanged, nodes: Nodes) -> Any:
        return work

    def second_order(self, work: TetMesh) -> Any:
        """The result for the mesh of which curve() has made `work`."""
        return work


class OwnAdapter(Adapter[TetMesh]):
    def __init__(self, mesh: TetMesh) -> None:
        self._mesh = mesh

    def tet_mesh(self) -> TetMesh:
        return self._mesh.copy()

    def points(self) -> Array:
        return self._mesh.points


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
            others=[(b.kind, self._linear(b)) for b in others],
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


def adapter_of(mesh: Any, tags: Tags) -> Adapter[Any]:
    """The adapter for `mesh`. It imports no package that is not imported already."""
    if isinstance(mesh, TetMesh):
        if tags is not None:
            raise TypeError("tags names data of a meshio or pyvista mesh; a TetMesh has tet_tags")
        return OwnAdapter(mesh)
    for package, kind, adapter in (
        ("meshio", "Mesh", MeshioAdapter),
        ("pyvista", "UnstructuredGrid", PyvistaAdapter),
    ):
        module = sys.modules.get(package)
        if module is not None and isinstance(mesh, getattr(module, kind)):
            return adapter(mesh, tags)
    raise TypeError(
        "a mesh is given as points and tets, or as a tetune.TetMesh, meshio.Mesh or pyvista.UnstructuredGrid; "
        f"this is a {type(mesh).__module__}.{type(mesh).__qualname__}"
    )
