# SPDX-License-Identifier: Apache-2.0
"""Mid-side nodes of second-order cells of meshio and pyvista, which number them alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._core import MeshError, TetMesh
from ._vtk_stream import CELLS, CURVED, OTHERS, SECOND

if TYPE_CHECKING:
    from typing import TypeAlias

Array: TypeAlias = NDArray[Any]

# The linear kind of each second-order one.
LINEAR_KIND = {"tetra10": "tetra", "triangle6": "triangle", "line3": "line",
               "quad8": "quad", "pyramid13": "pyramid", "wedge15": "wedge", "hexahedron20": "hexahedron"}
# Second-order kinds that are kept unchanged, with the library's names.
OTHER_KIND = {CELLS[numbers[0]][1]: name for name, _, numbers, edges in OTHERS if edges}
# The ends of the edges of each kind, in the order of their mid-side nodes.
EDGES = {CELLS[number][1]: edges for number, (_, _, edges) in SECOND.items()}
# The number of vertices of each kind; the mid-side nodes follow.
CORNERS = {CELLS[number][1]: corners for number, (corners, _, _) in SECOND.items()}


class Nodes(NamedTuple):
    """The nodes of a result."""

    points: Array
    origin: NDArray[np.int32]
    """Per node that of the input, -1 for an inserted one."""
    middles: ResultMiddles | None = None


def edges_of(kind: str, cells: Array) -> Array:
    return cells[:, np.array(EDGES[kind])].reshape(-1, 2)


def keys_of(edges: Array, vertices: int) -> NDArray[np.int64]:
    """A number per edge, whatever the order of its ends."""
    wide = np.sort(edges.astype(np.int64), axis=1)
    keys: NDArray[np.int64] = wide[:, 0] * vertices + wide[:, 1]
    return keys


class Middles:
    """The mid-side nodes of a mesh: `cells` are its blocks by kind."""

    def __init__(self, points: Array, cells: Sequence[tuple[str, Array]]) -> None:
        kinds = {kind for kind, _ in cells}
        for second, linear in LINEAR_KIND.items():
            if second in kinds and (linear in kinds if linear == "tetra" else "tetra10" not in kinds):
                other = "beside" if linear == "tetra" else "without tetra10 beside"
                raise MeshError(f"cells of type {second} {other} {'tetra' if linear == 'tetra' else 'them'} are not "
                                "supported; convert the mesh to one order")
        self.points = np.asarray(points, dtype=np.float64)
        none = np.zeros((0, 2), dtype=np.int64)  # a linear mesh has no mid-side nodes
        pairs = np.concatenate([none, *(edges_of(k, c[:, :CORNERS[k]]) for k, c in cells if k in EDGES)])
        nodes = np.concatenate([none[:, 0], *(c[:, CORNERS[k]:].reshape(-1) for k, c in cells if k in EDGES)])
        if nodes.size and not (0 <= nodes.min() and nodes.max() < len(points)):
            raise MeshError(f"a mid-side node is {nodes.min() if nodes.min() < 0 else nodes.max()}; "
                            f"the mesh has {len(points)} points")
        is_middle = np.zeros(len(points), dtype=bool)
        is_middle[nodes] = True
        for kind, c in cells:
            corners = c[:, :CORNERS.get(kind, c.shape[1])]
            inside = corners[(corners >= 0) & (corners < len(points))]
            if is_middle[inside].any():
                node = inside[is_middle[inside]][0]
                raise MeshError(f"node {node} is a mid-side node of one cell and a vertex of another")
        self.vertices = np.flatnonzero(~is_middle)
        """Per vertex, its node in the input."""
        self.node2vertex = np.where(is_middle, -1, np.cumsum(~is_middle) - 1)
        keys, first, inverse = np.unique(keys_of(pairs, len(points)), return_index=True, return_inverse=True)
        self.nodes = nodes[first]
        twice = np.flatnonzero(self.nodes[inverse] != nodes)
        if twice.size or len(np.unique(self.nodes)) < len(self.nodes):
            raise MeshError("a node is a mid-side node of two edges, or one of two nodes of the same edge")
        ends = self.node2vertex[pairs[first]]
        self.edges = np.sort(ends, axis=1)
        """The edges by vertices, in the order of `nodes`."""
        a, b = self.points[self.vertices[self.edges[:, 0]]], self.points[self.vertices[self.edges[:, 1]]]
        off = self.points[self.nodes] - (a + b) / 2
        with np.errstate(invalid="ignore"):
            straight = np.linalg.norm(off, axis=1) <= CURVED * np.linalg.norm(b - a, axis=1)
        self.curved = np.flatnonzero((off != 0).any(axis=1)) if not straight.all() else np.array([], dtype=int)
        """The rows of the edges that are curved."""

    def linear(self, kind: str, cells: Array) -> Array:
        """Cells by their vertices."""
        corners = cells[:, :CORNERS.get(kind, cells.shape[1])]
        inside = (corners >= 0) & (corners < len(self.points))
        if not inside.all():
            raise MeshError(f"a vertex of a cell of type {kind} is {corners[~inside][0]}; the mesh has {len(self.points)} points")
        result: Array = self.node2vertex[corners]
        return result

    def curved_arguments(self) -> dict[str, Any]:
        """Arguments of TetMesh()."""
        return {
            "second_order": True,
            "curved_edges": self.edges[self.curved],
            "curved_middles": self.points[self.nodes[self.curved]],
        }

    def result(self, work: TetMesh, vertex_map: NDArray[np.int32], cells: Sequence[tuple[str, Array]]) -> Nodes:
        """The nodes of a result with these linear cells, each with the kind that it shall have. Nodes of the input keep
        their order, and inserted ones follow."""
        n = max(len(work.points), len(self.vertices))
        all_edges = [edges_of(kind, c) for kind, c in cells if kind in EDGES]
        keys = np.unique(keys_of(np.concatenate(all_edges), n))
        ends = np.stack([keys // n, keys % n], axis=1)
        old_ends = np.where(vertex_map[ends] < 0, -1, vertex_map[ends])
        old_keys = keys_of(self.edges, n)
        order = np.argsort(old_keys)
        wanted = keys_of(np.maximum(old_ends, 0), n)
        at = np.minimum(np.searchsorted(old_keys[order], wanted), max(len(order) - 1, 0))
        found = np.zeros(len(keys), dtype=bool)
        origin_of_middle = np.full(len(keys), -1)
        if len(order) > 0:
            found = (old_ends >= 0).all(axis=1) & (old_keys[order][at] == wanted)
            origin_of_middle = np.where(found, self.nodes[order][at], -1)
        positions = (work.points[ends[:, 0]] + work.points[ends[:, 1]]) / 2
        if len(work.curved_edges) > 0:
            positions[np.searchsorted(keys, keys_of(work.curved_edges, n))] = work.curved_middles
        elif self.curved.size == 0:
            # Rounding of the input stays where both ends did.
            same = found & (work.points[ends] == self.points[self.vertices[np.maximum(old_ends, 0)]]).all(axis=(1, 2))
            positions[same] = self.points[origin_of_middle[same]]
        origin_of_vertex = np.where(vertex_map < 0, -1, self.vertices[np.maximum(vertex_map, 0)])
        origin = np.concatenate([origin_of_vertex, origin_of_middle])
        place2node = np.argsort(np.where(origin < 0, len(self.points), origin), kind="stable")
        node2place = np.empty_like(place2node)
        node2place[place2node] = np.arange(len(place2node))
        points = np.concatenate([work.points, positions])
        middles = ResultMiddles(self, keys, n, ends, len(vertex_map), place2node, node2place)
        return Nodes(points[place2node], origin[place2node].astype(np.int32), middles)


class ResultMiddles:
    """The vertices of a result and, after them, the nodes on its edges, at their places among the nodes."""

    def __init__(self, input: Middles, keys: Array, base: int, ends: Array, vertices: int,
                 place2node: Array, node2place: Array) -> None:
        self.input = input
        self._keys, self._base, self._ends, self._vertices = keys, base, ends, vertices
        self._place2node, self._node2place = place2node, node2place

    def cells(self, kind: str, cells: Array) -> Array:
        """Linear cells as cells of the kind, by nodes."""
        corners = self._node2place[cells]
        if kind not in EDGES:
            return corners
        rows = np.searchsorted(self._keys, keys_of(edges_of(kind, cells), self._base))
        return np.hstack([corners, self._node2place[self._vertices + rows].reshape(len(cells), len(EDGES[kind]))])

    def transfer(self, data: Mapping[str, Any], of_vertices: Mapping[str, Array], nodes: Nodes, interpolate: bool) -> dict[str, Array]:
        """Data of all nodes: those of a mid-side node whose edge was kept, else means of both ends or, of integers, the
        value of one. With `interpolate` a node that has moved has the means."""
        kept = nodes.origin >= 0
        if interpolate:
            kept &= (nodes.points == self.input.points[np.maximum(nodes.origin, 0)]).all(axis=1)
        is_middle = self._place2node >= self._vertices
        result = {}
        for name, values in of_vertices.items():
            first, second = values[self._ends[:, 0]], values[self._ends[:, 1]]
            on_edges = ((first + second) / 2).astype(values.dtype) if np.issubdtype(values.dtype, np.inexact) else first
            new = np.concatenate([values, on_edges])[self._place2node]
            stay = kept & is_middle
            new[stay] = np.asarray(data[name])[nodes.origin[stay]]
            result[name] = new
        return result
