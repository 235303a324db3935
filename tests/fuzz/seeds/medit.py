# SPDX-License-Identifier: Apache-2.0
"""MEDIT files."""

import struct

EXTRA = [("Edges", 5, [(1, 2, 7)]), ("Triangles", 6, [(1, 2, 3, 5)]), ("Corners", 13, [(1,)]), ("Ridges", 14, [(1,)]),
         ("RequiredVertices", 15, [(2,)]), ("RequiredEdges", 16, [(1,)]), ("RequiredTriangles", 17, [(1,)]),
         ("RequiredTetrahedra", 12, [(1,)]), ("Quadrilaterals", 7, [(1, 2, 3, 4, 0)]),
         ("Pyramids", 49, [(1, 2, 3, 4, 5, 0)]), ("RequiredQuadrilaterals", 18, [(1,)])]


def sections(points, tets, extra):
    listed = [("Vertices", 4, [(*map(float, p), i % 3) for i, p in enumerate(points)]),
              ("Tetrahedra", 8, [(*(v + 1 for v in t), i % 2) for i, t in enumerate(tets)])]
    return listed + (EXTRA if extra else [])


def text(points, tets, extra):
    lines = "MeshVersionFormatted 2\nDimension\n3\n# a comment\n"
    for name, _, rows in sections(points, tets, extra):
        lines += f"{name}\n{len(rows)}\n" + "".join(" ".join(map(str, row)) + "\n" for row in rows)
    return (lines + "End\n").encode()


def binary(points, tets, extra, version=2, order="<"):
    real, integer = order + ("f" if version == 1 else "d"), order + ("q" if version == 4 else "i")
    position = order + ("q" if version >= 3 else "i")
    out = struct.pack(order + "ii", 1, version)

    def add(code, body):
        start = len(out) + 4 + struct.calcsize(position)
        return struct.pack(order + "i", code) + struct.pack(position, start + len(body)) + body

    out += add(3, struct.pack(order + "i", 3))
    for _, code, rows in sections(points, tets, extra):
        body = struct.pack(integer, len(rows))
        for row in rows:
            body += b"".join(struct.pack(real if isinstance(x, float) else integer, x) for x in row)
        out += add(code, body)
    return out + struct.pack(order + "i", 54) + struct.pack(position, 0)
