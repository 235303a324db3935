# SPDX-License-Identifier: Apache-2.0
"""Decks of Abaqus and CalculiX for tests: a plain reader, independent of tetune's, and one of a loaded block."""

import re
from pathlib import Path

from cli_case import Mesh, cube

FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))  # S1 to S4
PAIRS = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))  # of the mid-side nodes of C3D10
READ = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "DLOAD")


def cross(p, q, r):
    a, b = ([x - y for x, y in zip(v, p)] for v in (q, r))
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


class Deck:
    """Nodes and elements by number, sets, faces of surfaces and loads by name, and all other lines."""

    def __init__(self, path):
        self.nodes, self.tets, self.others, self.nsets, self.elsets, self.surfaces = {}, {}, {}, {}, {}, {}
        self.rest, self.card, self.param = [], "", {}
        self.middles = {}  # mid-side nodes by the ends of their edges
        for line in Path(path).read_text().splitlines():
            if line.startswith("**") or not line.strip():
                self.rest.append(line)
            elif line.startswith("*"):
                words = [w.strip() for w in line[1:].upper().split(",")]
                self.card = words[0].replace(" ", "")
                self.param = dict((w.split("=") + [""])[:2] for w in words[1:])
                self.rest.append(line.upper().replace(", GENERATE", ""))
            elif self.card in READ:
                self.data([w.strip() for w in line.split(",") if w.strip()])
            else:
                self.rest.append(line)

    def data(self, words):
        if self.card == "NODE":
            assert int(words[0]) not in self.nodes
            assert all(len(w) <= 20 for w in words), words
            self.nodes[int(words[0])] = tuple(map(float, words[1:4]))
            self.nsets.setdefault(self.param.get("NSET"), set()).add(int(words[0]))
        elif self.card == "ELEMENT":
            to = self.tets if self.param["TYPE"] in ("C3D4", "C3D10") else self.others
            assert int(words[0]) not in self.tets and int(words[0]) not in self.others
            nodes = tuple(map(int, words[1:]))
            to[int(words[0])] = nodes[:4] if to is self.tets else nodes
            for pair, node in zip(PAIRS, nodes[4:] if to is self.tets else ()):
                ends = tuple(sorted(nodes[k] for k in pair))
                assert self.middles.setdefault(ends, node) == node
            self.elsets.setdefault(self.param.get("ELSET"), set()).add(int(words[0]))
        elif self.card in ("NSET", "ELSET"):
            sets = self.nsets if self.card == "NSET" else self.elsets
            known = self.nodes if self.card == "NSET" else {**self.tets, **self.others}
            found = sets.setdefault(self.param[self.card], set())
            if "GENERATE" in self.param:
                found |= set(range(int(words[0]), int(words[1]) + 1, int(words[2]))) & set(known)
            else:
                for word in words:
                    found |= {int(word)} if word.isdigit() else sets[word.upper()]
                assert found <= set(known)
        else:
            name = self.param.get("NAME", self.card)
            elements = {int(words[0])} if words[0].isdigit() else self.elsets[words[0].upper()]
            self.surfaces.setdefault(name, set()).update((e, int(words[1][1])) for e in elements)

    def point(self, node):
        return self.nodes[node]

    def corners(self, face):
        return [self.nodes[self.tets[face[0]][k]] for k in FACES[face[1] - 1]]

    def volume(self, elset):
        mesh = Mesh(list(self.nodes.values()), [])
        position = {node: i for i, node in enumerate(self.nodes)}
        mesh.tets = [tuple(position[v] for v in self.tets[e]) for e in self.elsets[elset] if e in self.tets]
        volumes = mesh.volumes()
        assert min(volumes) > 0
        return sum(volumes)

    def area_vector(self, surface):
        """The sum of the areas of its faces times their normals out of their elements."""
        total = [0, 0, 0]
        for face in self.surfaces[surface]:
            tet = [self.nodes[v] for v in self.tets[face[0]]]
            normal = cross(*self.corners(face))
            inward = [sum(p[k] for p in tet) / 4 - self.corners(face)[0][k] for k in range(3)]
            sign = -0.5 if sum(a * b for a, b in zip(normal, inward)) > 0 else 0.5
            total = [t + sign * x for t, x in zip(total, normal)]
        return total

    def midpoint(self, edge):
        return tuple((p + q) / 2 for p, q in zip(*(self.nodes[v] for v in edge)))

    def vertices(self, surface):
        return {self.tets[e][k] for e, f in self.surfaces[surface] for k in FACES[f - 1]}


def lines(numbers, each=8):
    numbers = list(numbers)
    return "".join(", ".join(map(str, numbers[i:i + each])) + "\n" for i in range(0, len(numbers), each))


def block(n=4, seed=1, jitter=0.2):
    """A unit cube of two materials, fixed at x = 0, with a pressure at x = 1, a surface at z = 1, one between the
    materials on the side of the first, a set of nodes at y = 0, and a load on one node inside."""
    mesh = cube(n, jitter, seed)
    half = n // 2
    mesh.points = [(0.5 if i % (n + 1) == half else p[0], *p[1:]) for i, p in enumerate(mesh.points)]

    def label(v):
        return 5_000_000_000 + 10 * v

    def element(t):
        return 3 * t + 7

    def lies(axis, at):
        return lambda v: mesh.points[v][axis] == at

    def faces(on):
        return [(element(t), f + 1) for t, tet in enumerate(mesh.tets) for f, face in enumerate(FACES)
                if all(on(tet[k]) for k in face)]

    left = [t for t, tet in enumerate(mesh.tets) if max(mesh.points[v][0] for v in tet) <= 0.5]
    right = sorted(set(range(len(mesh.tets))) - set(left))
    in_left = {element(t) for t in left}
    top = faces(lies(2, 1.0))
    load = (half * (n + 1) + half) * (n + 1) + half + 1
    rows = [lines([element(t), *map(label, mesh.tets[t])], 9) for t in range(len(mesh.tets))]
    text = ("*HEADING\nA block\n** the nodes\n*Node, nset=Nall\n"
            + "".join(f"{label(v)}, {x!r}, {y!r}, {z!r}\n" for v, (x, y, z) in enumerate(mesh.points)) + "** both materials\n"
            + "*ELEMENT, TYPE=C3D4, ELSET=LEFT\n" + "".join(rows[t] for t in left)
            + "*ELEMENT, TYPE=C3D4\n** no set on its card\n" + "".join(rows[t] for t in right)
            + "*ELSET, ELSET=RIGHT\n" + lines(map(element, right)) + "*elset, elset=ALL\nleft, RIGHT\n"
            + f"*ELSET, ELSET=RANGE, GENERATE\n{element(0)}, {element(len(mesh.tets) - 1)}, 3\n"
            + "*NSET, NSET=FIX\n" + lines(label(v) for v in range(len(mesh.points)) if mesh.points[v][0] == 0)
            + "*NSET, NSET=FRONT\n** a comment in a set\n"
            + lines(label(v) for v in range(len(mesh.points)) if mesh.points[v][1] == 0)
            + f"*NSET, NSET=LOAD\n{label(load)},\n*NSET, NSET=BOTH\nFIX, LOAD\n")
    for f in range(1, 5):
        if any(face == f for _, face in top):
            text += f"*ELSET, ELSET=_TOP_S{f}, INTERNAL\n" + lines(e for e, face in top if face == f)
    text += "*SURFACE, NAME=TOP, TYPE=ELEMENT\n" + "".join(
        f"_TOP_S{f}, S{f}\n" for f in range(1, 5) if any(face == f for _, face in top))
    text += "*SURFACE, NAME=MID\n" + "".join(f"{e}, S{f}\n" for e, f in faces(lies(0, 0.5)) if e in in_left)
    text += ("*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n*MATERIAL, NAME=ALU\n*ELASTIC\n70000., 0.3\n"
             "*SOLID SECTION, ELSET=LEFT, MATERIAL=STEEL\n*SOLID SECTION, ELSET=RIGHT, MATERIAL=ALU\n"
             "*STEP\n*STATIC\n*BOUNDARY\nFIX, 1, 3\n*DLOAD\n" + "".join(f"{e}, P{f}, -70.\n" for e, f in faces(lies(0, 1.0)))
             + "*NODE PRINT, NSET=FIX, TOTALS=ONLY\nRF\n*NODE PRINT, NSET=LOAD\nU\n*END STEP\n")
    return text


def numbers(text):
    """Those of CalculiX's printed results."""
    return [float(x) for x in re.findall(r"-?\d\.\d+E[-+]\d+", text)]


def contact(n=3, jitter=0.15):
    """Two unit cubes of meshes of their own, one on the other in contact, with a pressure of 10 on the upper one. The stress
    is uniform, so that the result does not depend on the meshes."""
    sets = {name: [] for name in ("BOTTOM", "X0", "Y0", "TIP", "MASTER", "SLAVE", "PRESSED")}
    text = "*HEADING\nTwo cubes\n*NODE, NSET=NALL\n"
    rows = {}
    for part, (name, surfaces) in enumerate((("LOWER", {1.0: "MASTER"}), ("UPPER", {1.0: "SLAVE", 2.0: "PRESSED"}))):
        mesh = cube(n, jitter, part + 1)
        points = [(p[0], p[1], p[2] + part) for p in mesh.points]
        first = 1 + 10_000 * part
        text += "".join(f"{first + v}, {x!r}, {y!r}, {z!r}\n" for v, (x, y, z) in enumerate(points))
        for at, (axis, value) in {"BOTTOM": (2, 0), "X0": (0, 0), "Y0": (1, 0)}.items():
            sets[at] += [first + v for v, p in enumerate(points) if p[axis] == value]
        sets["TIP"] += [first + v for v, p in enumerate(points) if p == (1, 1, 2)]
        rows[name] = "".join(lines([first + t, *(first + v for v in tet)]) for t, tet in enumerate(mesh.tets))
        for z, surface in surfaces.items():
            sets[surface] += [(first + t, f + 1) for t, tet in enumerate(mesh.tets) for f, face in enumerate(FACES)
                              if all(points[tet[k]][2] == z for k in face)]
    for name, row in rows.items():
        text += f"*ELEMENT, TYPE=C3D4, ELSET={name}\n{row}"
    text += "*ELSET, ELSET=ALL\nLOWER, UPPER\n"
    text += "".join(f"*NSET, NSET={name}\n" + lines(sets[name]) for name in ("BOTTOM", "X0", "Y0", "TIP"))
    text += "".join(f"*SURFACE, NAME={name}, TYPE=ELEMENT\n" + "".join(f"{e}, S{f}\n" for e, f in sets[name])
                    for name in ("MASTER", "SLAVE"))
    return (text + "*MATERIAL, NAME=STEEL\n*ELASTIC\n1000., 0.3\n*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n"
            "*SURFACE INTERACTION, NAME=TOUCH\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1.E6, 0.1\n"
            "*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE\nSLAVE, MASTER\n*STEP\n*STATIC\n1., 1.\n"
            "*BOUNDARY\nBOTTOM, 3, 3\nX0, 1, 1\nY0, 2, 2\n*DLOAD\n" + "".join(f"{e}, P{f}, 10.\n" for e, f in sets["PRESSED"])
            + "*NODE PRINT, NSET=TIP\nU\n*NODE PRINT, NSET=BOTTOM, TOTALS=ONLY\nRF\n*END STEP\n")
