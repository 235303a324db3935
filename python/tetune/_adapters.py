# SPDX-License-Identifier: Apache-2.0
"""Conversion of meshes of other packages to a TetMesh, and back with all their data."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Generic, Literal, NamedTuple, TypeVar, Union

import numpy as np
from numpy.typing import NDArray

from ._core import MeshError, OptionError, Report, TetMesh
from ._core import carry_point_data as carried

if TYPE_CHECKING:
    from typing import TypeAlias

    import meshio
    import pyvista as pv

Tags: TypeAlias = Union[str, Literal[False], None]
M = TypeVar("M")
Array: TypeAlias = NDArray[Any]

# Cell data that number regions, patches and lines in files of these programs, as meshio names them.
KNOWN_TAGS = ("medit:ref", "gmsh:physical", "gmsh:geometrical")
# Linear cells: meshio's name and VTK's number.
VTK_CELLS = {
    1: "vertex",
    3: "line",
    5: "triangle",
    9: "quad",
    10: "tetra",
    12: "hexahedron",
    13: "wedge",
    14: "pyramid",
}


class Block(NamedTuple):
    """Cells of one kind, given by their vertices."""

    kind: str
    vertices: Array


class NewBlock(NamedTuple):
    """A block of the result, with the rows of the input's block from which its cells come."""

    kind: str
    vertices: Array
    rows: Array


class Adapter(Generic[M]):
    """A mesh given as arrays, for which the result is a TetMesh. Base of the other adapters."""

    def tet_mesh(self) -> TetMesh:
        raise NotImplementedError

    def points(self) -> Array:
        raise NotImplementedError

    def point_data(self, name: str) -> Array:
        """A displacement: point data with three numbers per vertex."""
        raise TypeError(f"to is {name!r}, the name of point data, which a meshio or pyvista mesh has; "
                        "give the positions as an array")

    def result(self, work: TetMesh, report: Report, vertex_map: NDArray[np.int32]) -> Any:
        return work


class OwnAdapter(Adapter[TetMesh]):
    def __init__(self, mesh: TetMesh) -> None:
        self._mesh = mesh

    def tet_mesh(self) -> TetMesh:
        return self._mesh.copy()

    def points(self) -> Array:
        return self._mesh.points


class BlockAdapter(Adapter[M]):
    """A mesh of blocks of cells, with tags for each block or without tags."""

    blocks: list[Block]
    tags: list[Array] | None

    def tet_mesh(self) -> TetMesh:
        tets = self._joined("tetra")
        if tets is None:
            kinds = ", ".join(sorted({b.kind for b in self.blocks})) or "none"
            raise MeshError(f"there is no tetrahedron in this mesh; its cells are: {kinds}")
        return TetMesh(
            self.points(),
            tets,
            tet_tags=self._joined_tags("tetra"),
            triangles=self._joined("triangle"),
            triangle_tags=self._joined_tags("triangle"),
            edges=self._joined("line"),
            edge_tags=self._joined_tags("line"),
            others=[(b.kind, b.vertices) for b in self.blocks if b.kind not in ("tetra", "triangle", "line")],
        )

    def _joined(self, kind: str) -> Array | None:
        return _joined([b.vertices for b in self.blocks if b.kind == kind])

    def _joined_tags(self, kind: str) -> Array | None:
        if self.tags is None:
            return None
        return _joined([tags for b, tags in zip(self.blocks, self.tags) if b.kind == kind])

    def new_blocks(self, work: TetMesh, report: Report) -> list[NewBlock]:
        """The blocks of the result, in the order of those of the input."""
        cells = {"tetra": work.tets, "triangle": work.triangles, "line": work.edges}
        parents = {"tetra": report.tet2original, "triangle": report.triangle2original, "line": report.edge2original}
        others = iter(work.others)
        first = dict.fromkeys(cells, 0)
        blocks: list[NewBlock] = []
        for b in self.blocks:
            if b.kind not in cells:
                blocks.append(NewBlock(b.kind, next(others)[1], np.arange(len(b.vertices))))
                continue
            begin, end = first[b.kind], first[b.kind] + len(b.vertices)
            first[b.kind] = end
            parent = parents[b.kind]
            if len(parent) == 0 and report.tets_after > 0:  # all were kept
                blocks.append(NewBlock(b.kind, cells[b.kind][begin:end], np.arange(len(b.vertices))))
                continue
            mine = (parent >= begin) & (parent < end)
            if mine.all():
                blocks.append(NewBlock(b.kind, cells[b.kind], parent - begin))
            else:
                blocks.append(NewBlock(b.kind, cells[b.kind][mine], parent[mine] - begin))
        return blocks


def displacement_of(data: Mapping[str, Any], name: str) -> Array:
    if name not in data:
        raise OptionError(f"to is {name!r}; the point data of this mesh are: {', '.join(data) or 'none'}")
    values = np.asarray(data[name])
    if values.ndim != 2 or values.shape[1] != 3:
        raise OptionError(f"to is {name!r}, which has the shape {values.shape}; a displacement has three numbers a vertex")
    return values


def _joined(parts: list[Array]) -> Array | None:
    if len(parts) == 0:
        return None
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def transfer_point_data(
    data: Mapping[str, Any], work: TetMesh, report: Report, vertex_map: NDArray[np.int32], vertices: int
) -> dict[str, Array]:
    """Data of the vertices of the result, as the option `data` says."""
    if len(report.place_weights) == 0:
        return carry_point_data(data, work, vertex_map, vertices)
    places, weights = report.place_vertices, report.place_weights
    return {name: interpolated(np.asarray(values), places, weights) for name, values in data.items()}


def interpolated(values: Array, places: Array, weights: Array) -> Array:
    """Floating-point data at places in the input, within the values of their four vertices; other data of the vertex of
    the largest weight."""
    nearest: Array = values[places[np.arange(len(places)), weights.argmax(axis=1)]]
    if values.dtype not in (np.float64, np.float32) or values.size == 0:
        return nearest
    corners = values.reshape(len(values), -1)[places].astype(np.float64)
    w = weights[:, :, None]
    counts = w > 0
    with np.errstate(invalid="ignore"):
        mean = np.where(counts, w * corners, 0).sum(axis=1)
    low = np.where(counts, corners, np.inf).min(axis=1)
    high = np.where(counts, corners, -np.inf).max(axis=1)
    mean = np.clip(mean, low, high).reshape(nearest.shape)
    result: Array = np.where(np.isfinite(mean), mean, nearest).astype(values.dtype)
    return result


def carry_point_data(
    data: Mapping[str, Any], work: TetMesh, vertex_map: NDArray[np.int32], vertices: int
) -> dict[str, Array]:
    """Data of the vertices of the result. An inserted vertex gets means of its neighbors' floating-point data, and
    other data of the nearest vertex of the input."""
    old = {name: np.asarray(values) for name, values in data.items()}
    if len(old) == 0 or (vertex_map >= 0).all():
        return {name: values[vertex_map] for name, values in old.items()}
    smooth = [name for name, values in old.items() if values.size and values.dtype in (np.float64, np.float32)]
    rows = np.arange(vertices, dtype=np.int32)
    source, *means = carried(
        work, vertex_map, [np.ascontiguousarray(v).reshape(vertices, -1) for v in (rows, *(old[name] for name in smooth))]
    )
    mean_of = dict(zip(smooth, means))
    return {
        name: mean_of[name].reshape(-1, *values.shape[1:]) if name in mean_of else values[source[:, 0]]
        for name, values in old.items()
    }


def chosen_tags(tags: Tags, names: list[str]) -> str | None:
    """The name of the cell data that are used as tags, or None."""
    if tags is False:
        return None
    if tags is None:
        return next((name for name in KNOWN_TAGS if name in names), None)
    if tags not in names:
        raise OptionError(f"tags is {tags!r}; the cell data of this mesh are: {', '.join(names) or 'none'}")
    return tags


def as_tags(name: str, values: Array) -> Array:
    values = np.asarray(values)
    if values.ndim != 1:
        raise OptionError(f"tags is {name!r}, which has {values.shape[1]} numbers a cell; it must have one")
    whole = values.astype(np.int64)
    if not np.array_equal(whole, values):
        raise OptionError(f"tags is {name!r}, which has numbers that are not whole; tags must be")
    return whole


class MeshioAdapter(BlockAdapter["meshio.Mesh"]):
    def __init__(self, mesh: meshio.Mesh, tags: Tags) -> None:
        self._mesh = mesh
        for b in mesh.cells:
            if b.type not in VTK_CELLS.values():
                raise MeshError(f"cells of type {b.type} are not supported; supported are the linear ones: "
                                f"{', '.join(VTK_CELLS.values())}")
        self.blocks = [Block(b.type, np.asarray(b.data)) for b in mesh.cells]
        name = chosen_tags(tags, list(mesh.cell_data))
        self.tags = None if name is None else [as_tags(name, v) for v in mesh.cell_data[name]]

    def points(self) -> Array:
        return np.asarray(self._mesh.points)

    def point_data(self, name: str) -> Array:
        return displacement_of(self._mesh.point_data, name)

    def result(self, work: TetMesh, report: Report, vertex_map: NDArray[np.int32]) -> meshio.Mesh:
        import meshio

        old = self._mesh
        blocks = self.new_blocks(work, report)
        place = np.full(len(old.points), -1)
        place[vertex_map[vertex_map >= 0]] = np.flatnonzero(vertex_map >= 0)
        new = meshio.Mesh(
            work.points,
            [(b.kind, b.vertices) for b in blocks],
            point_data=transfer_point_data(old.point_data, work, report, vertex_map, len(old.points)),
            cell_data={
                name: [np.asarray(v)[b.rows] for v, b in zip(values, blocks)]
                for name, values in old.cell_data.items()
            },
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
                raise MeshError(f"cells of VTK type {t} are not supported; supported are the linear ones: "
                                + ", ".join(f"{name} ({n})" for n, name in VTK_CELLS.items()))
        if len(present) == 1:
            self.blocks = [Block(VTK_CELLS[present[0]], grid.cell_connectivity.reshape(grid.n_cells, -1))]
            self._cells = [np.arange(grid.n_cells)]
        else:
            cells = {int(t): np.asarray(vertices) for t, vertices in grid.cells_dict.items()}
            self.blocks = [Block(VTK_CELLS[t], cells[t]) for t in present]
            self._cells = [np.flatnonzero(types == t) for t in present]
        self._types = present
        name = chosen_tags(tags, list(grid.cell_data.keys()))
        self.tags = None
        if name is not None:
            values = as_tags(name, grid.cell_data[name])
            self.tags = [values[c] for c in self._cells]

    def points(self) -> Array:
        return np.asarray(self._grid.points)

    def point_data(self, name: str) -> Array:
        return displacement_of(dict(self._grid.point_data), name)

    def result(self, work: TetMesh, report: Report, vertex_map: NDArray[np.int32]) -> pv.UnstructuredGrid:
        import pyvista as pv

        old = self._grid
        blocks = self.new_blocks(work, report)
        counts = [len(b.vertices) for b in blocks]
        widths = np.repeat([b.vertices.shape[1] for b in blocks], counts)
        offsets = np.concatenate([[0], np.cumsum(widths)])
        connectivity = np.concatenate([b.vertices.reshape(-1) for b in blocks])
        new = pv.UnstructuredGrid()
        # Doubles also where the input has single precision: rounding could turn an element inside out.
        new.points = work.points
        new.SetCells(
            pv.convert_array(np.repeat(np.array(self._types, dtype=np.uint8), counts)),
            pv.CellArray.from_arrays(offsets, connectivity.astype(offsets.dtype)),
        )
        parent = np.concatenate([c[b.rows] for c, b in zip(self._cells, blocks)])
        for name, values in transfer_point_data(dict(old.point_data), work, report, vertex_map, old.n_points).items():
            new.point_data[name] = values
        for name, values in old.cell_data.items():
            new.cell_data[name] = values[parent]
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
