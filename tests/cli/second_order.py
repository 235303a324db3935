# SPDX-License-Identifier: Apache-2.0
"""Shared by the tests of second-order elements."""

import math

TET10 = 11  # Gmsh's number of tetrahedra of ten nodes
# The order of the nodes of these in Gmsh's files.
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (2, 3), (1, 3))


def bend(p):
    x, y, z = p
    bent = (x + 0.08 * math.sin(2 * y), y + 0.05 * math.sin(3 * z), z + 0.06 * x * x)
    return tuple(round(x, 12) for x in bent)  # decks hold 20 characters


class Middles:
    """Appends a node in the middle of each edge to `points`; `edge2node` has it by the edge's ends in increasing order."""

    def __init__(self, points):
        self.points = points
        self.edge2node = {}

    def nodes_of(self, corners, edges=EDGES):
        """The corners of an element and the nodes of its edges, which are pairs of corners."""
        return [*corners, *(self.of_edge(corners[a], corners[b]) for a, b in edges)]

    def of_edge(self, *ends):
        edge = tuple(sorted(ends))
        if edge not in self.edge2node:
            self.edge2node[edge] = len(self.points)
            self.points.append(tuple((x + y) / 2 for x, y in zip(*(self.points[v] for v in edge))))
        return self.edge2node[edge]
