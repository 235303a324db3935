# SPDX-License-Identifier: Apache-2.0
"""Decks of Abaqus and CalculiX, of Nastran and of I-deas."""

from seeds.meshes import BASE, TOP, UPRIGHT, hexahedron, second_order


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


def inp_parts(points, tets):
    """A deck of two parts, one of them of tetrahedra, with an assembly that refers to sets of both."""
    def rows(numbered):
        return "".join(", ".join(map(str, row)) + "\n" for row in numbered)

    mesh = ("*Node\n" + rows((i + 1, *p) for i, p in enumerate(points)) + "*Element, type=C3D4\n"
            + rows((i + 1, *(v + 1 for v in t)) for i, t in enumerate(tets)) + "*Nset, nset=S\n1, 2, 3\n*Elset, elset=S\n1\n")
    tool = "*Part, name=T\n*Node\n1, 0., 0., 9.\n2, 1., 0., 9.\n3, 0., 1., 9.\n*Element, type=R3D3\n1, 1, 2, 3\n*End Part\n"
    assembly = ("*Assembly, name=A\n*Instance, name=P-1, part=P\n0., 0., 1.\n*End Instance\n*Instance, name=T-1, part=T\n*End Instance\n"
                "*Node\n1, 5., 5., 5.\n*Nset, nset=RP\n1,\n*Nset, nset=S, instance=P-1\n2, 3, 4\n*Elset, elset=_F, internal, instance=P-1\n1\n"
                "*Surface, type=ELEMENT, name=F\n_F, S1\nP-1.S, S2\n*End Assembly\n")
    steps = "*Step\n*Boundary\nS, 1, 3\nP-1.S, 1\nP-1.1, 2, 2\nRP, 1\n*Dload\nP-1.1, P3, 2.\n*Cload\n1, 3, 1.\n*End Step\n"
    return ("*Part, name=P\n" + mesh + "*End Part\n" + tool + assembly + steps).encode()


def inp_second_order(points, tets):
    """A deck of tetrahedra of 10 nodes and a hexahedron of 20, with sets, a load on a face and one on a mid-side node."""
    nodes, elements = second_order(points, tets)
    text = "*NODE, NSET=ALL\n" + "".join(", ".join(map(str, (v + 1, *p))) + "\n" for v, p in enumerate(nodes))
    text += "*ELEMENT, TYPE=C3D10, ELSET=E\n"
    text += "".join(", ".join(map(str, (number, *(v + 1 for v in row)))) + "\n" for number, row in enumerate(elements, 1))
    text += f"*NSET, NSET=SOME, GENERATE\n1, {len(nodes)}, 2\n*DLOAD\n1, P1, 2.\n*CLOAD\n{len(nodes)}, 1, 1.\n"
    added = hexahedron(5001, BASE + TOP + UPRIGHT)
    text += "*NODE\n" + "".join(", ".join(map(str, (n, *p))) + "\n" for n, p in added)
    numbers = [str(n) for n, _ in added]
    text += "*ELEMENT, TYPE=C3D20\n900, " + ", ".join(numbers[:15]) + ",\n" + ", ".join(numbers[15:]) + "\n"
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


def nastran_second_order(points, tets):
    """Tetrahedra of 10 nodes and a hexahedron of 20."""
    nodes, elements = second_order(points, tets)
    added = hexahedron(5001, BASE + UPRIGHT + TOP)

    def grid(numbered):
        return "".join("GRID,{},,{},{},{}\n".format(n, *map(float, p)) for n, p in numbered)

    text = grid(enumerate(nodes, 1))
    for number, row in enumerate(elements, 1):
        names = [str(v + 1) for v in row]
        text += ",".join(("CTETRA", str(number), "1", *names[:6], "+A")) + "\n" + ",".join(("+A", *names[6:])) + "\n"
    text += grid(added)
    numbers = [str(n) for n, _ in added]
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
    """Tetrahedra of 10 nodes and a hexahedron of 20."""
    nodes, elements = second_order(points, tets)
    added = hexahedron(5001, BASE + UPRIGHT + TOP)
    text = "    -1\n  2411\n"
    text += "".join("{} 1 1 11\n{} {} {}\n".format(n, *map(float, p)) for n, p in [*enumerate(nodes, 1), *added])
    text += "    -1\n    -1\n  2412\n"
    for number, row in enumerate(elements, 1):
        names = [str(row[k] + 1) for k in (0, 4, 1, 5, 2, 6, 7, 8, 9, 3)]
        text += f"{number} 118 1 1 7 10\n" + " ".join(names[:8]) + "\n" + " ".join(names[8:]) + "\n"
    places = (0, 8, 1, 9, 2, 10, 3, 11, 12, 13, 14, 15, 4, 16, 5, 17, 6, 18, 7, 19)
    numbers = [str(added[k][0]) for k in places]
    text += "900 116 2 1 7 20\n" + "".join(" ".join(numbers[k:k + 8]) + "\n" for k in (0, 8, 16))
    return (text + "    -1\n").encode()
