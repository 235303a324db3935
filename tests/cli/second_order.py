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
