# SPDX-License-Identifier: Apache-2.0
"""Prisms of second order beside curved tetrahedra on the command line. Run: see cli_case.py."""

import json
from itertools import combinations

import cli_case
from cli_case import CliTest, cube, msh_text
from second_order import EDGES, TET10, Middles, bend

PRISM_EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 4), (2, 5), (3, 4), (3, 5), (4, 5))  # in Gmsh's order
PRISM15 = 18  # Gmsh's number


def hybrid(n=4, bends=True):
    """A bent cube of tetrahedra on a layer of prisms: the elements with Gmsh's type and their nodes, and all positions.
    Edges inside the cube are straight."""
    mesh = cube(n, jitter=0.15)
    points, below = list(mesh.points), {}
    for v, (x, y, z) in enumerate(mesh.points):
        if z == 0:
            below[v] = len(points)
            points.append((x, y, -0.4))
    middles = Middles(points)
    elements = [(TET10, middles.nodes_of(tet)) for tet in mesh.tets]
    curved = {edge for face in mesh.boundary_faces() for edge in combinations(face, 2)}
    inside = set(middles.edge2node) - curved
    for tet in mesh.tets:
        face = [v for v in tet if v in below]
        if len(face) == 3:
            (ax, ay, _), (bx, by, _), (cx, cy, _) = (points[v] for v in face)
            if (bx - ax) * (cy - ay) < (by - ay) * (cx - ax):
                face.reverse()
            elements.append((PRISM15, middles.nodes_of([below[v] for v in face] + face, PRISM_EDGES)))
    if bends:
        points = [bend(p) for p in points]
        for a, b in inside:
            points[middles.of_edge(a, b)] = tuple(round((p + q) / 2, 12) for p, q in zip(points[a], points[b]))
    return elements, points


def write_msh(path, elements, points):
    path.write_text(msh_text(points, [(kind, kind, row) for kind, row in elements]))


def nodes_of(path, kind):
    """The positions of the nodes of each element of a kind, as text, in the order of the file."""
    rows = path.read_text().splitlines()
    at = rows.index("$Nodes") + 2
    place = {row.split()[0]: tuple(row.split()[1:4]) for row in rows[at:at + int(rows[at - 1])]}
    at = rows.index("$Elements") + 2
    words = (row.split() for row in rows[at:at + int(rows[at - 1])])
    return [tuple(place[v] for v in w[3 + int(w[2]):]) for w in words if int(w[1]) == kind]


def one_node_per_edge(path):
    """Whether all elements have the same node in the middle of each edge."""
    middles = {}
    for kind, corners, edges in ((TET10, 4, EDGES), (PRISM15, 6, PRISM_EDGES)):
        for row in nodes_of(path, kind):
            for (a, b), middle in zip(edges, row[corners:]):
                if middles.setdefault(frozenset((row[a], row[b])), middle) != middle:
                    return False
    return True


class OtherKinds(CliTest):
    def path_of(self, name):
        return self.folder / name

    def test_prisms_keep_the_bits_of_their_nodes(self):
        for bends in (True, False):
            write_msh(self.path_of("in.msh"), *hybrid(bends=bends))
            # The shortest digits, as the results have them.
            self.run_cli("convert", self.path_of("in.msh"), "-o", self.path_of("same.msh"))
            before = nodes_of(self.path_of("same.msh"), PRISM15)
            self.assertEqual(len(before), 32)
            energy = self.quality("same.msh")
            for words in ((), ("--boundary", "slide"), ("--effort", "best", "--boundary", "slide"), ("--dry-run",),
                          ("--untangle", *(("--straighten",) if bends else ()), "--boundary", "slide")):
                out = self.path_of("out.msh")
                out.unlink(missing_ok=True)
                self.run_cli("optimize", self.path_of("same.msh"), out, *words)
                if "--dry-run" in words:
                    self.assertFalse(out.exists())
                    continue
                self.assertEqual(nodes_of(out, PRISM15), before, words)
                self.assertTrue(one_node_per_edge(out), words)
                self.assertLess(self.quality("out.msh"), energy, words)
                compared = self.run_cli("compare", self.path_of("same.msh"), out).stdout
                self.assertNotIn("NO", compared, words)

    def quality(self, name):
        report = json.loads(self.run_cli("info", self.path_of(name), "--json").stdout)
        self.assertEqual(report["counts"]["Prisms"], 32)
        return report["quality"]["shape_sum"]

    def test_prisms_go_through_all_formats_that_have_them(self):
        write_msh(self.path_of("in.msh"), *hybrid())
        self.run_cli("convert", self.path_of("in.msh"), "-o", self.path_of("same.msh"))
        for ending in ("unv", "bdf", "inp"):
            self.run_cli("convert", self.path_of("in.msh"), "-o", self.path_of("a." + ending))
            self.run_cli("convert", self.path_of("a." + ending), "--msh", "2.2-text", "-o", self.path_of("back.msh"))
            for kind in (TET10, PRISM15):
                self.assertEqual(nodes_of(self.path_of("back.msh"), kind), nodes_of(self.path_of("same.msh"), kind), ending)
        self.refused("convert", self.path_of("in.msh"), "-o", self.path_of("a.vol"), said=["Prisms with mid-side nodes"])
        self.refused("convert", self.path_of("in.msh"), "--order", "2", "-o", self.path_of("a.msh"), said=["curved edges already"])
        self.run_cli("convert", self.path_of("in.msh"), "--order", "1", "-o", self.path_of("a.msh"))
        self.assertEqual(nodes_of(self.path_of("a.msh"), 6), [row[:6] for row in nodes_of(self.path_of("same.msh"), PRISM15)])
        self.assertIn("Prisms (order 2)", self.run_cli("info", self.path_of("in.msh")).stdout)

    def test_elements_of_decks_keep_their_text(self):
        write_msh(self.path_of("in.msh"), *hybrid())
        self.run_cli("convert", self.path_of("in.msh"), "-o", self.path_of("a.inp"))
        text = self.path_of("a.inp").read_text().replace("TYPE=C3D15", "TYPE=C3D15H")
        top = [row.split(",")[0] for row in text.splitlines() if "e" not in row and row.count(",") == 3 and "*" not in row]
        self.path_of("a.inp").write_text(text + f"*NSET, NSET=LAST\n{', '.join(top[-3:])}\n*BOUNDARY\nLAST, 1, 3\n")
        self.run_cli("optimize", self.path_of("a.inp"), self.path_of("b.inp"), "--boundary", "slide")
        before, after = (self.path_of(n).read_text() for n in ("a.inp", "b.inp"))

        def card(of, head, end):
            begin = of.index(head)
            return of[begin:of.index(end, begin + 1)]

        prisms = card(before, "*ELEMENT, TYPE=C3D15H", "*ELSET" if "*ELSET" in before else "*NSET")
        self.assertIn(prisms.rstrip("\n"), after)
        numbers = {n for row in prisms.splitlines()[1:] for n in row.replace(" ", "").split(",")[1:] if n}
        nodes = {row.split(",")[0]: row for row in card(before, "*NODE", "*ELEMENT").splitlines()[1:]}
        rows = set(after.splitlines())
        self.assertEqual([n for n in numbers if nodes[n] not in rows], [])
        self.assertTrue(rows.symmetric_difference(before.splitlines()))


if __name__ == "__main__":
    cli_case.main(__doc__)
