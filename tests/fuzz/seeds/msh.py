# SPDX-License-Identifier: Apache-2.0
"""Files of Gmsh."""

import struct

from seeds.meshes import hexahedron


class Msh:
    """An .msh file of version 2.2 or 4.1, text or binary."""

    def __init__(self, old, binary):
        self.old, self.binary = old, binary
        self.out = f"$MeshFormat\n{'2.2' if old else '4.1'} {int(binary)} 8\n".encode()
        self.put("i", 1) if binary else None
        self.text(("\n" if binary else "") + "$EndMeshFormat\n")

    def text(self, text):
        self.out += text.encode()

    def put(self, form, *values):
        """Numbers of struct's form, and the end of a line."""
        if self.binary:
            self.out += struct.pack("<" + form, *values)
        else:
            self.text(" ".join(map(str, values)) + "\n")

    def end(self, name):
        self.text(("\n" if self.binary else "") + f"$End{name}\n")


def msh_elements(tets, extra):
    """Type, dimension, entity, group and vertices."""
    listed = [(4, 3, 1 + i % 2, 1, *(v + 1 for v in t)) for i, t in enumerate(tets)]
    return listed + ([(2, 2, 4, 5, 1, 2, 3), (1, 1, 2, 7, 1, 2), (15, 0, 1, 0, 1), (2, 2, 4, 6, 1, 2, 3)] if extra else [])


def msh(points, tets, extra, old, binary):
    m = Msh(old, binary)
    if extra:
        m.text('$PhysicalNames\n2\n3 1 "steel"\n2 5 "inlet"\n$EndPhysicalNames\n$Comments\na comment\n$EndComments\n')
    elements = msh_elements(tets, extra)
    cells = sorted({(dimension, entity, group) for _, dimension, entity, group, *_ in elements})
    if not old:
        m.text("$Entities\n")
        entities = sorted({(dimension, entity) for dimension, entity, _ in cells})
        m.put("4Q", *(sum(d == dimension for d, _ in entities) for dimension in range(4)))
        for dimension, entity in entities:
            groups = [g for d, e, g in cells if (d, e) == (dimension, entity) and g]
            box = [0.0] * (3 if dimension == 0 else 6)
            bounds = [0] if dimension > 0 else []
            m.put(f"i{len(box)}dQ{len(groups)}i" + "Q" * len(bounds), entity, *box, len(groups), *groups, *bounds)
        m.end("Entities")
    m.text("$Nodes\n" + (f"{len(points)}\n" if old else ""))
    if old:
        for i, p in enumerate(points):
            m.put("i3d", i + 1, *map(float, p))
    else:
        m.put("4Q", 1, len(points), 1, len(points))
        m.put("iiiQ", 3, 1, 0, len(points))
        for i in range(len(points)):
            m.put("Q", i + 1)
        for p in points:
            m.put("3d", *map(float, p))
    m.end("Nodes")
    m.text("$Elements\n" + (f"{len(elements)}\n" if old else ""))
    if not old:
        m.put("4Q", len(elements), len(elements), 1, len(elements))
    for i, (kind, dimension, entity, group, *v) in enumerate(elements):
        if old and binary:
            m.put("3i", kind, 1, 2)
        if old:
            head = (i + 1, group, entity) if binary else (i + 1, kind, 2, group, entity)
            m.put(f"{len(head) + len(v)}i", *head, *v)
        else:
            m.put("3iQ", dimension, entity, kind, 1)
            m.put(f"{1 + len(v)}Q", i + 1, *v)
    m.end("Elements")
    if extra:
        m.text("$Periodic\n")
        if old:
            m.text("1\n2 4 3\nAffine 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1\n1\n1 2\n$EndPeriodic\n")
        else:
            m.put("QiiiQ16dQQQ", 1, 2, 4, 3, 16, *([1.0] * 16), 1, 1, 2)
            m.end("Periodic")
        for name, count in (("NodeData", len(points)), ("ElementData", len(tets))):
            m.text(f'${name}\n1\n"heat"\n1\n0\n3\n0\n1\n{count}\n')
            for i in range(count):
                m.put("id", i + 1, 0.5)
            m.end(name)
    return bytes(m.out)


def msh_second_order(points):
    """A hexahedron of 20 nodes beside points, as version 2.2 has it."""
    edges = ((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7))
    nodes = [*enumerate(points, 1), *hexahedron(len(points) + 1, edges)]
    text = f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(nodes)}\n"
    text += "".join(f"{n} {x} {y} {z}\n" for n, (x, y, z) in nodes)
    return (text + "$EndNodes\n$Elements\n1\n1 17 2 1 1 " + " ".join(str(n) for n, _ in nodes[-20:])
            + "\n$EndElements\n").encode()
