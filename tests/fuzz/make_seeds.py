# SPDX-License-Identifier: Apache-2.0
"""Writes a few small inputs for each fuzz target.   python3 make_seeds.py FOLDER"""

import random
import struct
import sys
from pathlib import Path

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
EXTRA = [("Edges", 5, [(1, 2, 7)]), ("Triangles", 6, [(1, 2, 3, 5)]), ("Corners", 13, [(1,)]), ("Ridges", 14, [(1,)]),
         ("RequiredVertices", 15, [(2,)]), ("RequiredEdges", 16, [(1,)]), ("RequiredTriangles", 17, [(1,)]),
         ("RequiredTetrahedra", 12, [(1,)]), ("Quadrilaterals", 7, [(1, 2, 3, 4, 0)]),
         ("Pyramids", 49, [(1, 2, 3, 4, 5, 0)]), ("RequiredQuadrilaterals", 18, [(1,)])]


def sections(points, tets, extra):
    listed = [("Vertices", 4, [(*map(float, p), i % 3) for i, p in enumerate(points)]),
              ("Tetrahedra", 8, [(*(v + 1 for v in t), i % 2) for i, t in enumerate(tets)])]
    return listed + (EXTRA if extra else [])


def medit_text(points, tets, extra):
    text = "MeshVersionFormatted 2\nDimension\n3\n# a comment\n"
    for name, _, rows in sections(points, tets, extra):
        text += f"{name}\n{len(rows)}\n" + "".join(" ".join(map(str, row)) + "\n" for row in rows)
    return (text + "End\n").encode()


def medit_binary(points, tets, extra, version=2, order="<"):
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


def su2(points, tets, extra):
    rows = [(10, *t) for t in tets] + ([(14, 0, 1, 3, 2, 4)] if extra else [])
    text = f"NDIME= 3\nNELEM= {len(rows)}\n" + "".join(" ".join(map(str, (*row, i))) + "\n" for i, row in enumerate(rows))
    text += f"NPOIN= {len(points)}\n" + "".join(f"{x} {y} {z} {i}\n" for i, (x, y, z) in enumerate(points))
    if extra:
        text += "NMARK= 1\nMARKER_TAG= wall\nMARKER_ELEMS= 2\n5 0 1 2\n9 0 1 3 2\n"
    return text.encode()


def nastran(points, tets, extra):
    """In small fields; `extra`: in large and free fields, with other elements and cards."""
    def card(width, name, *fields):
        return name.ljust(8) + "".join(str(field).ljust(width) for field in fields) + "\n"

    text = "" if extra else "$ small fields\nCEND\nBEGIN BULK\n"
    for i, point in enumerate(points, 1):
        x, y, z = map(float, point)
        text += card(16, "GRID*", 10 * i, "", x, y) + card(16, "*", z) if extra else card(8, "GRID", i, "", x, y, z)
    for i, tet in enumerate(tets, 1):
        nodes = [(10 if extra else 1) * (v + 1) for v in tet]
        text += ",".join(map(str, ("CTETRA", i, 1, *nodes))) + "\n" if extra else card(8, "CTETRA", i, 1, *nodes)
    if extra:
        text += "CTRIA3\t900\t3\t10\t20\t30\nCROD,901,4,10,20\nCQUAD4,902,5,10,20,40,30\nFORCE,1,10\n,1.5-3\n"
    return (text + "ENDDATA\n").encode()


BASE, TOP, UPRIGHT = (((0, 1), (1, 2), (2, 3), (3, 0)), ((4, 5), (5, 6), (6, 7), (7, 4)), ((0, 4), (1, 5), (2, 6), (3, 7)))


def hexahedron(first, edges):
    """The nodes of a hexahedron of 20 nodes apart from the others, numbered from `first`: vertices, then the middles."""
    corners = [(x + 5, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    middles = [tuple((p + q) / 2 for p, q in zip(corners[a], corners[b])) for a, b in edges]
    return list(enumerate((*corners, *middles), first))


def msh_second_order(points, tets):
    """A hexahedron of 20 nodes beside points, as version 2.2 has it."""
    edges = ((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7))
    nodes = [*enumerate(points, 1), *hexahedron(len(points) + 1, edges)]
    text = f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(nodes)}\n"
    text += "".join(f"{n} {x} {y} {z}\n" for n, (x, y, z) in nodes)
    return (text + "$EndNodes\n$Elements\n1\n1 17 2 1 1 " + " ".join(str(n) for n, _ in nodes[-20:])
            + "\n$EndElements\n").encode()


def nastran_second_order(points, tets):
    """Tetrahedra of 10 nodes, from a deck of them, and a hexahedron of 20."""
    lines = inp_second_order(points, tets).decode().splitlines()
    begin, end = next(i for i, line in enumerate(lines) if line.startswith("*ELEM")), lines.index(
        next(line for line in lines if line.startswith("*NSET")))
    text = "".join("GRID,{},,{},{},{}\n".format(*(line.split(", ")[:1] + [repr(float(x)) for x in line.split(", ")[1:]]))
                   for line in lines[1:begin])
    for line in lines[begin + 1:end]:
        number, *nodes = line.split(", ")
        text += ",".join(("CTETRA", number, "1", *nodes[:6], "+A")) + "\n" + ",".join(("+A", *nodes[6:])) + "\n"
    nodes = hexahedron(5001, BASE + UPRIGHT + TOP)
    text += "".join("GRID,{},,{},{},{}\n".format(n, *map(float, p)) for n, p in nodes)
    numbers = [str(n) for n, _ in nodes]
    text += ",".join(("CHEXA,900,2", *numbers[:6], "+B\n+B", *numbers[6:14], "+C\n+C", *numbers[14:])) + "\n"
    return (text + "ENDDATA\n").encode()


def unv(points, tets, extra):
    """Universal files; `extra`: with units, coordinate systems, old data sets, other elements and groups."""
    def data_set(number, *lines):
        return "".join(f"{line}\n" for line in ("    -1", f"{number:6}", *lines, "    -1"))

    def columns(*numbers):
        return "".join(f"{number:10}" for number in numbers)

    nodes = [line for i, p in enumerate(points, 1)
             for line in (columns(i, 1, 1, 11), "".join(f"{float(x):25.16E}".replace("E", "D") for x in p))]
    elements = [line for i, tet in enumerate(tets, 1)
                for line in (columns(i, 111, 1 + i % 2, 1, 7, 4), columns(*(v + 1 for v in tet)))]
    if not extra:
        return (data_set(2411, *nodes) + data_set(2412, *elements)).encode()
    old = [columns(900, 91, 1, 3, 1, 1, 7, 3), columns(1, 2, 3), columns(901, 21, 1, 4, 1, 1, 7, 2), columns(0, 1, 1, 1, 1),
           columns(1, 2)]
    system = ["         1", "part", columns(1, 0, 0), "global", " 1. 0. 0.", " 0. 1. 0.", " 0. 0. 1.", " 0. 0. 0."]
    groups = [columns(1, 0, 0, 0, 0, 0, 0, 3), "the wall", columns(8, 900, 0, 0, 7, 1, 0, 0), columns(8, 1, 0, 0)]
    return (data_set(164, columns(5) + "mm", " 1.D3 1.D3 1.D0", " 2.73D2") + data_set(2420, *system) + data_set(781, *nodes) +
            data_set(2412, *elements) + data_set(780, *old) + data_set(2467, *groups) + data_set(2414, "         1")).encode()


def unv_second_order(points, tets):
    """Tetrahedra of 10 nodes, from a deck of them, and a hexahedron of 20."""
    lines = inp_second_order(points, tets).decode().splitlines()
    begin, end = next(i for i, line in enumerate(lines) if line.startswith("*ELEM")), lines.index(
        next(line for line in lines if line.startswith("*NSET")))
    text = "    -1\n  2411\n"
    for line in lines[1:begin]:
        number, *x = line.split(", ")
        text += f"{number} 1 1 11\n" + " ".join(repr(float(value)) for value in x) + "\n"
    hexahedron_nodes = hexahedron(5001, BASE + UPRIGHT + TOP)
    text += "".join("{} 1 1 11\n{} {} {}\n".format(n, *map(float, p)) for n, p in hexahedron_nodes)
    text += "    -1\n    -1\n  2412\n"
    for line in lines[begin + 1:end]:
        number, *nodes = line.split(", ")
        nodes = [nodes[k] for k in (0, 4, 1, 5, 2, 6, 7, 8, 9, 3)]
        text += f"{number} 118 1 1 7 10\n" + " ".join(nodes[:8]) + "\n" + " ".join(nodes[8:]) + "\n"
    places = (0, 8, 1, 9, 2, 10, 3, 11, 12, 13, 14, 15, 4, 16, 5, 17, 6, 18, 7, 19)
    numbers = [str(hexahedron_nodes[k][0]) for k in places]
    text += "900 116 2 1 7 20\n" + "".join(" ".join(numbers[k:k + 8]) + "\n" for k in (0, 8, 16))
    return (text + "    -1\n").encode()


def netgen(points, tets, extra):
    """Edges in the form of older files, or with descriptions."""
    text = "mesh3d\ndimension\n3\ngeomtype\n0\nsurfaceelements\n1\n1 1 1 0 3 1 2 3\n"
    text += f"volumeelements\n{len(tets)}\n" + "".join("1 4 " + " ".join(str(t[k] + 1) for k in (0, 2, 1, 3)) + "\n" for t in tets)
    text += "edgesegmentsgi3\n1\n1 2 -1 -1 0 1 0\n" if extra else "edgesegmentsgi2\n1\n1 0 1 2 -1 -1 0 0 1 0 1 1\n"
    text += f"points\n{len(points)}\n" + "".join(f"{x} {y} {z}\n" for x, y, z in points)
    if extra:
        text += ("pointelements\n1\n1 1\nmaterials\n1\n1 steel\nbcnames\n1\n1 a wall\ncd2names\n1\n1 rim\nedgedescriptors\n"
                 "1\n1 0 4 0 0 -1 0 -1 rim\nidentifications\n1\n1 2 1\nidentificationtypes\n1\n2\nface_colours\n1\n1 0 1 0\n")
    return (text + "endmesh\n").encode()


def tetgen(points, tets, extra, base):
    nodes = "".join(f"{i + base} {x} {y} {z} 0.5 {i}\n" for i, (x, y, z) in enumerate(points))
    cells = "".join(f"{i + base} {' '.join(str(v + base) for v in t)} {i}\n" for i, t in enumerate(tets))
    text = f"{len(points)} 3 1 1\n{nodes}%{len(tets)} 4 1\n{cells}"
    if extra:
        text += f"%1 1\n{base} {base} {base + 1} {base + 2} 5\n%1 1\n{base} {base} {base + 1} 7\n"
    return text.encode()


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


def inp(points, tets, extra):
    """A deck; `extra`: with sets, surfaces, loads and other elements."""
    def rows(numbered):
        return "".join(", ".join(map(str, row)) + "\n" for row in numbered)

    elements = [(3 * i + 7, *(10 * v + 1 for v in t)) for i, t in enumerate(tets)]
    text = "*HEADING\na deck\n*NODE, NSET=ALL\n" + rows((10 * i + 1, *p) for i, p in enumerate(points))
    if not extra:
        return (text + "*ELEMENT, TYPE=C3D4\n" + rows(elements)).encode()
    half = len(elements) // 2
    text += ("*ELEMENT, TYPE=C3D4, ELSET=A\n" + rows(elements[:half]) + "** the rest\n*element, type=c3d4\n" + rows(elements[half:])
             + "*ELEMENT, TYPE=S3, ELSET=SKIN\n1000, 1, 11, 21\n*ELEMENT, TYPE=MASS\n1001, 1\n"
             + "*ELSET, ELSET=B, GENERATE\n7, 9, 3\n*ELSET, ELSET=C\nA, B, 10\n*ELSET, ELSET=_S1\n7\n"
             + "*NSET, NSET=N\n1, 11, 21, 31\n*NSET, NSET=M, UNSORTED\n41, N\n*NSET, NSET=E, ELSET=B\n"
             + "*SURFACE, NAME=TOP\n_S1, S1\n10, S2\n*SURFACE, NAME=P, TYPE=NODE\nN,\n"
             + "*STEP\n*BOUNDARY\nN, 1, 3\n11, 1\n*DLOAD\n7, P3, 2.\nC, GRAV, 9.81, 0, 0, -1\n*EQUATION\n2\n1, 1, 1., 11, 1, -1.\n"
             + "*TEMPERATURE\nN, 3.\n" + rows((10 * v + 1, 20 + p[0], 1.5) for v, p in enumerate(points)) + "*END STEP\n")
    return text.encode()


def inp_second_order(points, tets):
    """A deck of tetrahedra of 10 nodes and a hexahedron of 20, with sets, a load on a face and one on a mid-side node."""
    pairs = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
    nodes, middles = list(points), {}
    for tet in tets:
        for i, j in pairs:
            ends = tuple(sorted((tet[i], tet[j])))
            if ends not in middles:
                middles[ends] = len(nodes)
                nodes.append(tuple((p + q) / 2 for p, q in zip(points[ends[0]], points[ends[1]])))
    text = "*NODE, NSET=ALL\n" + "".join(", ".join(map(str, (v + 1, *p))) + "\n" for v, p in enumerate(nodes))
    text += "*ELEMENT, TYPE=C3D10, ELSET=E\n"
    for number, tet in enumerate(tets, 1):
        row = [*tet, *(middles[tuple(sorted((tet[i], tet[j])))] for i, j in pairs)]
        text += ", ".join(map(str, (number, *(v + 1 for v in row)))) + "\n"
    text += f"*NSET, NSET=SOME, GENERATE\n1, {len(nodes)}, 2\n*DLOAD\n1, P1, 2.\n*CLOAD\n{len(nodes)}, 1, 1.\n"
    added = hexahedron(5001, BASE + TOP + UPRIGHT)
    text += "*NODE\n" + "".join(", ".join(map(str, (n, *p))) + "\n" for n, p in added)
    numbers = [str(n) for n, _ in added]
    text += "*ELEMENT, TYPE=C3D20\n900, " + ", ".join(numbers[:15]) + ",\n" + ", ".join(numbers[15:]) + "\n"
    return text.encode()


def plugin_answer(points, tets, extra):
    """No error, a warning, and the mesh, as src/io/mesh_stream.hpp has them."""
    out = bytearray()

    def array(form, rows):
        flat = [x for row in rows for x in (row if isinstance(row, tuple) else (row,))]
        out.extend(struct.pack("<Q", len(rows)) + struct.pack(f"<{len(flat)}{form}", *flat))

    def string(text):
        out.extend(struct.pack("<Q", len(text)) + text.encode())

    def data(count):
        out.extend(struct.pack("<Q", 1 if extra else 0))
        if extra:
            string("heat")
            out.extend(struct.pack("<iQ", 1, 0))
            array("d", [0.5] * count)

    triangles = [(0, 1, 2)] if extra else []
    edges = [(0, 1)] if extra else []
    string("")
    out.extend(struct.pack("<Q", 1))
    string("a warning")
    for form, rows in (("d", [tuple(map(float, p)) for p in points]), ("i", [0] * len(points)), ("i", tets),
                       ("i", [1] * len(tets)), ("i", triangles), ("i", [5] * len(triangles)), ("i", edges),
                       ("i", [7] * len(edges))):
        array(form, rows)
    for rows in ([0], [1], [0], [0], [0], [0]) if extra else [[]] * 6:
        array("i", rows)
    out.extend(struct.pack("<Q", 1 if extra else 0))
    if extra:
        string("Quadrilaterals")
        out.extend(struct.pack("<i", 4))
        for rows in ([0, 1, 3, 2], [9], [0]):
            array("i", rows)
        out.extend(struct.pack("<Q?", 0, False))
    for count in (len(points), len(tets), len(triangles), len(edges)):
        data(count)
    out.extend(struct.pack("<Q", 1 if extra else 0))
    if extra:
        out.extend(struct.pack("<ii", 3, 1))
        string("steel")
        array("i", [1])
    out.extend(struct.pack("<Q", 1 if extra else 0))
    if extra:
        out.extend(struct.pack("<iii", 2, 4, 3))
        array("d", [])
        array("i", [(0, 1)])
    for text in ("medit:ref", "", "msh 4.1 binary"):
        string(text)
    return bytes(out) + struct.pack("<?Q?", False, 0, False)


COMMAND_LINES = ("in.mesh out.mesh --boundary slide --feature-angle 30 --max-deviation 0.1%", "a.mesh b.mesh -o x/ --report {}.json",
                 "in.mesh -nr -nosurf -hausd 1e-3 -v 5 -m 100", "- - --freeze tag=1,2,patch=7 --target-quality 0.2 mean_ratio",
                 "in.mesh out.meshb --effort best --keep-vertices --target-dihedral 15 --time-limit 5")


def main(folder):
    def put(target, name, content):
        path = folder / target
        path.mkdir(parents=True, exist_ok=True)
        (path / name).write_bytes(content)

    for name, (points, tets) in MESHES.items():
        for extra in (False, True):
            stem = name + ("_all" if extra else "")
            put("medit_text", stem, medit_text(points, tets, extra))
            put("plugin_answer", stem, plugin_answer(points, tets, extra))
            for old in (False, True):
                for binary in (False, True):
                    put("msh", f"{stem}_{'22' if old else '41'}{'b' if binary else ''}", msh(points, tets, extra, old, binary))
            put("msh", name + "_20", msh_second_order(points, tets))
            put("inp", stem, inp(points, tets, extra))
            put("inp", name + "_10", inp_second_order(points, tets))
            put("su2", stem, su2(points, tets, extra))
            put("nastran", stem, nastran(points, tets, extra))
            put("nastran", name + "_10", nastran_second_order(points, tets))
            put("unv", stem, unv(points, tets, extra))
            put("unv", name + "_10", unv_second_order(points, tets))
            put("netgen", stem, netgen(points, tets, extra))
            put("tetgen", stem, tetgen(points, tets, extra, int(extra)))
            for version in (1, 2, 3, 4):
                for order in "<>":
                    put("medit_binary", f"{stem}_{version}{'le' if order == '<' else 'be'}",
                        medit_binary(points, tets, extra, version, order))
    put("series", "two", b'<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n<!-- c -->\n'
        b'<DataSet timestep="0.5" group="" part="0" file="a &amp; b.vtu"/>\n<DataSet timestep="1" file="c.vtu"></DataSet>\n'
        b'</Collection>\n</VTKFile>\n')
    for i, line in enumerate(COMMAND_LINES):
        put("options", str(i), line.replace(" ", "\n").encode())
    for i in range(8):  # optimize() takes its mesh and options from bytes, whatever they are
        put("optimize", str(i), random.Random(i).randbytes(200 << i % 4))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
