# SPDX-License-Identifier: Apache-2.0
"""A closed surface as TetGen takes it: points, and facets, each a list of loops of point indices in one plane."""

import math


class Surface:
    def __init__(self):
        self.points = []
        self.facets = []  # (loops, holes): the first loop is the outline; a hole is a point in a part to leave out
        self._index = {}

    def point(self, *xyz):
        """Index of a point; the same coordinates are the same point."""
        xyz = tuple(float(x) + 0.0 for x in xyz)  # + 0.0: no negative zero
        if xyz not in self._index:
            self._index[xyz] = len(self.points)
            self.points.append(xyz)
        return self._index[xyz]

    def facet(self, outline, inner=()):
        """A plane polygon with convex openings; returns its number."""
        holes = [tuple(sum(self.points[i][k] for i in loop) / len(loop) for k in range(3)) for loop in inner]
        self.facets.append(([list(outline), *map(list, inner)], holes))
        return len(self.facets) - 1

    def skewed(self):
        """Leaning by about a degree: of exact symmetry TetGen makes tetrahedra that are flat to the last bits."""
        def skew(x, y, z):
            return x + 0.013 * y + 0.017 * z, y + 0.011 * z, z

        self.points = [skew(*p) for p in self.points]
        self.facets = [(loops, [skew(*h) for h in holes]) for loops, holes in self.facets]
        return self

    def write(self, path):
        """As a TetGen .poly file, counted from 0."""
        lines = [f"{len(self.points)} 3 0 0"]
        lines += [f"{i} {p[0]!r} {p[1]!r} {p[2]!r}" for i, p in enumerate(self.points)]
        lines.append(f"{len(self.facets)} 0")
        for loops, holes in self.facets:
            lines.append(f"{len(loops)} {len(holes)}")
            lines += [f"{len(loop)} {' '.join(map(str, loop))}" for loop in loops]
            lines += [f"{i + 1} {h[0]!r} {h[1]!r} {h[2]!r}" for i, h in enumerate(holes)]
        path.write_text("\n".join([*lines, "0", "0"]) + "\n")


def from_triangles(points, triangles):
    """From arrays. Nine decimals, so that the last bits of a machine's sine do not show in the mesh."""
    surface = Surface()
    surface.points = [tuple(p) for p in (points.round(9) + 0.0).tolist()]
    surface.facets = [([t], []) for t in triangles.tolist()]
    return surface


def circle(n, radius, x=0.0, y=0.0):
    """A regular n-gon."""
    angles = [2 * math.pi * k / n for k in range(n)]
    return [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]
