# SPDX-License-Identifier: Apache-2.0
"""The meshes of the seeds, and elements of second order. Ids count from 0."""

CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
# A cube as six tetrahedra around its diagonal, and as five; the second has flat quadrilaterals to flip across.
SIX = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]
FIVE = [(0, 1, 2, 4), (3, 2, 1, 7), (5, 1, 4, 7), (6, 4, 2, 7), (1, 2, 4, 7)]
# Two tetrahedra with an inner face, as three around an edge.
SPINDLE = [(0, 0, .6), (0, 0, -.6), (1, 0, 0), (-.5, .9, 0), (-.5, -.9, 0)]
THREE = [(0, 2, 4, 1), (0, 4, 3, 1), (0, 3, 2, 1)]
# The cube with a vertex inside, which can move.
INNER = CORNERS + [(.4, .55, .6)]
STAR = [(a, b, c, 8) for a, b, c in (
    (0, 1, 3), (0, 3, 2), (4, 7, 5), (4, 6, 7), (0, 5, 1), (0, 4, 5), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
    (1, 5, 7), (1, 7, 3))]


def volume(points, tet):
    p, q, r, s = (points[v] for v in tet)
    a, b, c = ([x - y for x, y in zip(v, p)] for v in (q, r, s))
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))


def upright(points, tets):
    """Turns a tetrahedron of negative volume."""
    return [t if volume(points, t) > 0 else (t[0], t[1], t[3], t[2]) for t in tets]


MESHES = {name: (points, upright(points, tets)) for name, points, tets in (
    ("six", CORNERS, SIX), ("five", CORNERS, FIVE), ("three", SPINDLE, THREE), ("star", INNER, STAR))}


# The edges of a hexahedron: of its base, of its top, and between both.
BASE, TOP, UPRIGHT = (((0, 1), (1, 2), (2, 3), (3, 0)), ((4, 5), (5, 6), (6, 7), (7, 4)), ((0, 4), (1, 5), (2, 6), (3, 7)))


def hexahedron(first, edges):
    """Numbers from `first` and places of the nodes of a hexahedron apart from the others: vertices, then the middles of
    `edges`."""
    corners = [(x + 5, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    middles = [tuple((p + q) / 2 for p, q in zip(corners[a], corners[b])) for a, b in edges]
    return list(enumerate((*corners, *middles), first))


def second_order(points, tets):
    """The nodes and tetrahedra of 10 nodes, in the order of Abaqus and Nastran."""
    pairs = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
    nodes, middles, rows = list(points), {}, []
    for tet in tets:
        row = list(tet)
        for i, j in pairs:
            ends = tuple(sorted((tet[i], tet[j])))
            if ends not in middles:
                middles[ends] = len(nodes)
                nodes.append(tuple((p + q) / 2 for p, q in zip(points[ends[0]], points[ends[1]])))
            row.append(middles[ends])
        rows.append(row)
    return nodes, rows
