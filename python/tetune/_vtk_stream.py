# SPDX-License-Identifier: Apache-2.0
"""A mesh of VTK's files as the bytes that the library exchanges with its plugins: src/io/mesh_stream.hpp.

docs/formats.md says which arrays are tags and required entities."""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

import numpy as np

VERSION = 0x7465_7475_6E65_0005
# In the order of DataValues.
TYPES = ("f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8")
TAG_NAMES = ("medit:ref", "gmsh:physical", "tetgen:ref", "refs", "gmsh:geometrical")
# Flags of points and of cells, with the kind of these: the lists of TetMesh, in the order of the stream, and the names
# of the arrays.
POINT_FLAGS = {"corners": "mmg_corners", "required_vertices": "mmg_required_vertices"}
CELL_FLAGS = {"ridges": ("mmg_ridge_edges", "edge"), "required_edges": ("mmg_required_edges", "edge"),
              "required_triangles": ("mmg_required_triangles", "triangle"),
              "required_tets": ("mmg_required_tetrahedra", "tet")}
REQUIRED_QUADS = "mmg_required_quadrilaterals"
# VTK's number of a kind of cells: vertices, and meshio's name.
CELLS = {1: (1, "vertex"), 3: (2, "line"), 5: (3, "triangle"), 8: (4, "pixel"), 9: (4, "quad"), 10: (4, "tetra"),
         11: (8, "voxel"), 12: (8, "hexahedron"), 13: (6, "wedge"), 14: (5, "pyramid"),
         21: (3, "line3"), 22: (6, "triangle6"), 23: (8, "quad8"), 24: (10, "tetra10"), 25: (20, "hexahedron20"),
         26: (15, "wedge15"), 27: (13, "pyramid13")}
ORDERS = {8: [0, 1, 3, 2], 11: [0, 1, 3, 2, 4, 5, 7, 6]}  # pixels and voxels as quadrilaterals and hexahedra
# Kinds that are kept unchanged, in the order in which they are written: name, corners, VTK's numbers, and of second order
# the edges in the order of their nodes.
QUAD = ((0, 1), (1, 2), (2, 3), (3, 0))
OTHERS = (("Points", 1, (1,), ()), ("Quadrilaterals", 4, (9, 8), ()), ("Pyramids", 5, (14,), ()), ("Prisms", 6, (13,), ()),
          ("Hexahedra", 8, (12, 11), ()), ("Quadrilaterals", 4, (23,), QUAD),
          ("Pyramids", 5, (27,), (*QUAD, (0, 4), (1, 4), (2, 4), (3, 4))),
          ("Prisms", 6, (26,), ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))),
          ("Hexahedra", 8, (25,), (*QUAD, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))))
# Edges, triangles, tetrahedra: corners, VTK's numbers of first and second order, edges in the order of their nodes.
PAIRS = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
SIMPLICES = {"edge": (2, 3, 21, PAIRS[:1]), "triangle": (3, 5, 22, PAIRS[:3]), "tet": (4, 10, 24, PAIRS)}
# Kinds of second order: VTK's number; corners, the number by which cells without their mid-side nodes are known here,
# and edges.
SECOND = {second: (corners, first, pairs) for corners, first, second, pairs in SIMPLICES.values()} | {
    numbers[0]: (corners, numbers[0], pairs) for _, corners, numbers, pairs in OTHERS if pairs}
# A node farther than this part of its edge from the midpoint makes a mesh curved: src/io/second_order.cpp.
CURVED = 1e-4


class Refused(Exception):
    """Why a file is not read or written; without its name, which the library adds."""


class Grid(NamedTuple):
    """Cells by VTK's number, with their rows in the data of cells."""

    points: Any
    cells: list[tuple[int, Any, Any]]
    point_data: dict[str, Any]
    cell_data: dict[str, Any]


# ---- The stream.


class Writer:
    def __init__(self) -> None:
        self.parts: list[bytes] = []

    def number(self, kind: str, value: int) -> None:
        self.parts.append(struct.pack("=" + kind, value))

    def items(self, values: Any, kind: Any, width: int = 1) -> None:
        array = np.ascontiguousarray(values, kind)
        self.number("Q", array.size // width)
        self.parts.append(array.tobytes())

    def text(self, value: str) -> None:
        encoded = value.encode()
        self.number("Q", len(encoded))
        self.parts.append(encoded)

    def data(self, arrays: dict[str, Any]) -> None:
        self.number("Q", len(arrays))
        for name, values in arrays.items():
            self.text(name)
            self.number("i", values[0].size if len(values) else 1)
            kind = values.dtype.kind + str(values.dtype.itemsize)
            self.number("Q", TYPES.index(kind))
            self.items(values, kind)


class Reader:
    def __init__(self, content: bytes) -> None:
        self.content, self.at = content, 0

    def number(self, kind: str) -> int:
        (value,) = struct.unpack_from("=" + kind, self.content, self.at)
        self.at += struct.calcsize("=" + kind)
        return int(value)

    def items(self, kind: Any, width: int = 1) -> Any:
        count = self.number("Q") * width
        values = np.frombuffer(self.content, kind, count, self.at)
        self.at += values.nbytes
        return values.reshape(-1, width) if width > 1 else values

    def text(self) -> str:
        return bytes(self.items("u1")).decode(errors="replace")

    def data(self) -> dict[str, Any]:
        arrays = {}
        for _ in range(self.number("Q")):
            name, width = self.text(), self.number("i")
            values = self.items(TYPES[self.number("Q")])
            arrays[name] = values.reshape(-1, width) if width > 1 else values
        return arrays


# ---- From a grid to the stream.


def plain_data(data: dict[str, Any], warnings: list[str]) -> dict[str, Any]:
    """Arrays of numbers, in two dimensions at most."""
    kept = {}
    for name, values in data.items():
        values = np.asarray(values)
        if values.dtype.kind == "b":
            values = values.astype("u1")
        if values.dtype.kind + str(values.dtype.itemsize) not in TYPES:
            warnings.append(f'the data "{name}" is not an array of numbers; it is not kept')
        elif name != "vtkGhostType":
            kept[name] = values.reshape(len(values), -1)[:, 0] if values[:1].size == 1 else values.reshape(len(values), -1)
    return kept


def whole_numbers(values: Any) -> Any:
    """The values as integers of 32 bits; None where they are not one such number per entry."""
    if values.ndim != 1 or values.dtype.kind not in "biuf":
        return None
    with np.errstate(invalid="ignore"):
        whole = values.astype("i4")
    return whole if np.array_equal(whole, values) else None


def take_tags(data: dict[str, Any], size: int, warnings: list[str]) -> tuple[str, Any]:
    """Removes the first array that holds tags, and returns its name with its values."""
    for name in TAG_NAMES:
        if name not in data:
            continue
        tags = whole_numbers(data[name])
        if tags is not None:
            del data[name]
            return name, tags
        warnings.append(f'"{name}" does not hold integers of 32 bits: kept as data, not as tags')
    return "", np.zeros(size, "i4")


def take_flags(data: dict[str, Any], name: str) -> Any:
    """Removes an array of flags, and returns it; None where there is none."""
    return data.pop(name) if name in data and data[name].ndim == 1 else None


def flagged(flags: Any, rows: Any = None) -> Any:
    """The positions, of all or of `rows`, whose flag is not 0."""
    if flags is None:
        return np.zeros(0, "i4")
    return np.flatnonzero(flags if rows is None else flags[rows])


def without_middles(grid: Grid) -> tuple[Grid, bool, Any, Any]:
    """The grid of first order, whether it was of second, and the curved edges: vertices and positions of their nodes."""
    straight, ends, nodes = [], [], []
    for kind, ids, rows in grid.cells:
        if kind in SECOND:
            corners, first, pairs = SECOND[kind]
            ends += [ids[:, pair] for pair in map(list, pairs)]
            nodes += [ids[:, corners + i] for i in range(len(pairs))]
            kind, ids = first, ids[:, :corners]
        straight.append((kind, ids, rows))
    if not nodes:
        return grid, False, np.zeros((0, 2), "i4"), np.zeros((0, 3))
    kinds = {kind for kind, _, _ in grid.cells}
    others = [CELLS[numbers[0]][1] for _, _, numbers, pairs in OTHERS if pairs and numbers[0] in kinds]
    if others and 10 in kinds and not kinds & {21, 22, 24}:
        raise Refused(f"the tetrahedra are of first order, but cells of type {others[0]} have mid-side nodes; give the "
                      "tetrahedra mid-side nodes, or take those of the other cells out")
    end, node = np.concatenate(ends), np.concatenate(nodes)
    kept = np.ones(len(grid.points), bool)
    kept[node] = False
    new = np.cumsum(kept) - 1
    a, b, middle = grid.points[end[:, 0]], grid.points[end[:, 1]], grid.points[node]
    off = np.linalg.norm(middle - (a + b) / 2, axis=1)
    pairs_of, first_at = np.unique(np.sort(new[end], axis=1), axis=0, return_index=True)
    curved = np.zeros(len(first_at), bool)
    if (off > CURVED * np.linalg.norm(a - b, axis=1)).any():
        if len(np.unique(np.column_stack([np.sort(new[end], axis=1), node]), axis=0)) > min(len(first_at), len(np.unique(node))):
            raise Refused("a node is a mid-side node of two edges, or one of two nodes of the same edge; repair the "
                          "second-order elements in the program that made them")
        curved = (middle != (a + b) / 2).any(axis=1)[first_at]
    for kind, ids, _ in straight:
        if not kept[ids].all():
            raise Refused("a mid-side node is a vertex of another cell")
    cells = [(kind, new[ids], rows) for kind, ids, rows in straight]
    points = {name: np.asarray(values)[kept] for name, values in grid.point_data.items()}
    return Grid(grid.points[kept], cells, points, grid.cell_data), True, pairs_of[curved], middle[first_at][curved]


def encode(grid: Grid, warnings: list[str], out: Writer) -> None:
    for _, ids, _ in grid.cells:
        if ids.size and (ids.min() < 0 or ids.max() >= len(grid.points)):
            raise Refused(f"a cell has a point that does not exist; there are {len(grid.points)}")
    grid, second_order, curved, middles = without_middles(grid)
    if not np.isfinite(grid.points).all():
        raise Refused("a coordinate is not a finite number")
    of_points, of_cells = plain_data(grid.point_data, warnings), plain_data(grid.cell_data, warnings)
    point_name, point_tags = take_tags(of_points, len(grid.points), warnings)
    cell_name, cell_tags = take_tags(of_cells, sum(len(rows) for _, _, rows in grid.cells), warnings)

    def cells_of(kinds: tuple[int, ...], width: int) -> tuple[Any, Any]:
        parts = [(ids[:, ORDERS[kind]] if kind in ORDERS else ids, rows) for kind, ids, rows in grid.cells if kind in kinds]
        if not parts:
            return np.zeros((0, width), "i4"), np.zeros(0, int)
        ids, rows = np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
        order = np.argsort(rows, kind="stable")
        return ids[order], rows[order]

    simplices = {kind: cells_of((SIMPLICES[kind][1],), SIMPLICES[kind][0]) for kind in ("tet", "triangle", "edge")}
    out.items(grid.points, "f8", 3)
    out.items(point_tags, "i4")
    for kind, (ids, rows) in simplices.items():
        out.items(ids, "i4", SIMPLICES[kind][0])
        out.items(cell_tags[rows], "i4")
    for name in POINT_FLAGS.values():
        out.items(flagged(take_flags(of_points, name)), "i4")
    for name, kind in CELL_FLAGS.values():
        out.items(flagged(take_flags(of_cells, name), simplices[kind][1]), "i4")
    quads_required = take_flags(of_cells, REQUIRED_QUADS)
    others = [(name, width, *cells_of(kinds, width), bool(pairs)) for name, width, kinds, pairs in OTHERS]
    others = [block for block in others if len(block[3])]
    out.number("Q", len(others))
    for name, width, ids, rows, has_middles in others:
        out.text(name)
        out.number("i", width)
        out.items(ids, "i4")
        out.items(cell_tags[rows], "i4")
        out.items(flagged(quads_required, rows) if name == "Quadrilaterals" else [], "i4")
        out.data({name: values[rows] for name, values in of_cells.items()})
        out.number("B", has_middles)
    out.data(of_points)
    for _, rows in simplices.values():
        out.data({name: values[rows] for name, values in of_cells.items()} if len(rows) else {})
    out.number("Q", 0)  # groups
    out.number("Q", 0)  # periodic links
    for text in (point_name, cell_name, ""):
        out.text(text)
    out.number("B", second_order)
    curved_edges = np.zeros(len(curved), [("vertices", "i4", 2), ("middle", "f8", 3)])
    curved_edges["vertices"], curved_edges["middle"] = curved, middles
    out.items(curved_edges, curved_edges.dtype)
    out.number("B", 0)


# ---- From the stream to a grid.


def decode(s: Reader, warnings: list[str]) -> Grid:
    points, point_tags = s.items("f8", 3), s.items("i4")
    blocks = {}
    for kind, width in (("tet", 4), ("triangle", 3), ("edge", 2)):
        blocks[kind] = [s.items("i4", width), s.items("i4"), {}]
    of_points = [(name, s.items("i4")) for name in POINT_FLAGS.values()]
    of_cells = [(name, kind, s.items("i4")) for name, kind in CELL_FLAGS.values()]
    others = []
    for _ in range(s.number("Q")):
        name, width = s.text(), s.number("i")
        others.append((name, s.items("i4").reshape(-1, width), s.items("i4"), s.items("i4"), s.data(), s.number("B") != 0))
    point_data = s.data()
    for kind in ("tet", "triangle", "edge"):
        blocks[kind][2] = s.data()
    has_names = False
    for _ in range(s.number("Q")):
        s.number("i"), s.number("i")
        has_names |= s.text() != ""
        s.items("i4")
    if has_names:
        warnings.append("the format cannot hold the names of groups")
    for _ in range(s.number("Q")):
        s.number("i"), s.number("i"), s.number("i"), s.items("f8"), s.items("i4", 2)
    point_name, cell_name, _ = s.text(), s.text(), s.text()
    second_order = s.number("B") != 0
    curved = s.items(np.dtype([("vertices", "i4", 2), ("middle", "f8", 3)]))
    if s.number("B"):  # listed inside out: the orientation of the caller's file
        blocks["tet"][0] = blocks["tet"][0][:, [0, 1, 3, 2]]

    kinds = [(SIMPLICES[k][1], *blocks[k]) for k in ("edge", "triangle", "tet")]
    numbers = {(name, bool(pairs)): kinds_of[0] for name, _, kinds_of, pairs in OTHERS}
    number_of = [numbers[name, has_middles and second_order] for name, *_, has_middles in others]
    kinds += [(number, *block[1:3], block[4]) for number, block in zip(number_of, others)]
    sizes = [len(ids) for _, ids, _, _ in kinds]
    first = dict(zip([k[0] for k in kinds], np.cumsum([0, *sizes])))
    cell_data = merged([k[3] for k in kinds], sizes)
    tags = np.concatenate([k[2] for k in kinds])
    if tags.any() or cell_name:
        cell_data = with_tags(tags, cell_name, "cell", cell_data, warnings)
    cells = [(k[0], k[1].astype("i8"), None) for k in kinds if len(k[1])]
    if second_order:
        points, cells, point_data = with_middles(points, cells, point_data, curved)
    if point_tags.any() or point_name:
        tags = np.zeros(len(points), "i4")
        tags[: len(point_tags)] = point_tags
        point_data = with_tags(tags, point_name, "point", point_data, warnings)

    def flags(data: dict[str, Any], name: str, positions: Any, size: int) -> None:
        if len(positions):
            data[name] = np.zeros(size, "u1")
            data[name][positions] = 1

    for name, positions in of_points:
        flags(point_data, name, positions, len(points))
    for name, kind, positions in of_cells:
        flags(cell_data, name, positions + first[SIMPLICES[kind][1]], sum(sizes))
    required_quads = [required + first[number] for number, (_, _, _, required, *_) in zip(number_of, others)
                      if number in (9, 23)]
    if required_quads:
        flags(cell_data, REQUIRED_QUADS, np.concatenate(required_quads), sum(sizes))
    return Grid(points, cells, point_data, cell_data)


def with_tags(tags: Any, own_name: str, entities: str, data: dict[str, Any], warnings: list[str]) -> dict[str, Any]:
    """The tags before the data, of which one with their name is renamed."""
    name = own_name or TAG_NAMES[0]
    other = name
    while other in data:
        other += ":before"
    if other != name:
        warnings.append(f'the {entities} data "{name}" are renamed to "{other}", as tags have this name')
    return {name: tags, **{other if key == name else key: values for key, values in data.items()}}


def merged(parts: list[dict[str, Any]], sizes: list[int]) -> dict[str, Any]:
    """Each array over all cells; 0, or not a number, for kinds without data of that name."""
    result = {}
    for name in {name: None for part, size in zip(parts, sizes) if size for name in part}:
        model = next(part[name] for part, size in zip(parts, sizes) if size and name in part)
        filling = np.nan if model.dtype.kind == "f" else 0
        rows = []
        for part, size in zip(parts, sizes):
            values = part[name] if size and name in part else np.full((size, *model.shape[1:]), filling, model.dtype)
            if values.dtype != model.dtype or values.shape[1:] != model.shape[1:]:
                raise Refused(f'the data "{name}" has another type or number of components on elements of another kind; '
                              "rename one of them")
            rows.append(values)
        result[name] = np.concatenate(rows)
    return result


def with_middles(points: Any, cells: list[tuple[int, Any, Any]], point_data: dict[str, Any],
                 curved: Any) -> tuple[Any, list[tuple[int, Any, Any]], dict[str, Any]]:
    """Points, cells and data of second order: the node of each edge, behind all vertices. Its data are
    means of both ends, or integers of the first, as of Middles in src/io/second_order.cpp but for sets of nodes."""
    of_kind = {first: (second, [list(p) for p in pairs]) for second, (_, first, pairs) in SECOND.items()}
    ends = [np.sort(ids[:, pair], axis=1) for kind, ids, _ in cells if kind in of_kind for pair in of_kind[kind][1]]
    edges, number = np.unique(np.concatenate(ends), axis=0, return_inverse=True)
    number = number.reshape(-1) + len(points)

    def on_edges(values: Any) -> Any:
        first, second = values[edges[:, 0]], values[edges[:, 1]]
        return (first + second) / 2 if values.dtype.kind == "f" else first

    middle = on_edges(points)
    key = edges[:, 0] * len(points) + edges[:, 1]
    wanted = curved["vertices"].astype("i8")
    wanted_key = wanted[:, 0] * len(points) + wanted[:, 1]
    at = np.minimum(np.searchsorted(key, wanted_key), len(key) - 1)
    found = key[at] == wanted_key
    middle[at[found]] = curved["middle"][found]
    new, done = [], 0
    for kind, ids, rows in cells:
        if kind in of_kind:
            second, pairs = of_kind[kind]
            nodes = number[done : done + len(pairs) * len(ids)].reshape(len(pairs), -1).T
            done += len(pairs) * len(ids)
            kind, ids = second, np.hstack([ids, nodes])
        new.append((kind, ids, rows))
    data = {name: np.concatenate([values, on_edges(values)]) for name, values in point_data.items()}
    return np.concatenate([points, middle]), new, data
