# SPDX-License-Identifier: Apache-2.0
"""Decks with second-order tetrahedra through the command line. Run: see cli_case.py."""

import math
import re
import shutil
import subprocess
import unittest

import cli_case
from cli_case import CliTest
from deck import FACES, PAIRS, Deck, block, lines, numbers
from second_order import bend


def faces_of(deck, surface):
    """The faces of a surface by their vertices."""
    return {frozenset(deck.tets[e][k] for k in FACES[f - 1]) for e, f in deck.surfaces[surface]}


def middles_of(deck, surface):
    return {deck.middles[e] for e in deck.middles for face in faces_of(deck, surface) if face.issuperset(e)}


class SecondOrderDecks(CliTest):
    def make(self, n=2, shape=None, step="", name="a", jitter=0.2):
        """A deck with the tetrahedra of block() as C3D10; FIX and FRONT have all nodes of their sides."""
        path = self.folder / f"{name}.inp"
        path.write_text(block(n, jitter=jitter))
        deck = Deck(path)

        def small(label):  # CalculiX's numbers are of 32 bits
            return (int(label) - 5_000_000_000) // 10 + 1

        nodes, middle, rows = {small(v): p for v, p in deck.nodes.items()}, {}, {}
        for label, old in deck.tets.items():
            row = [small(v) for v in old]
            for i, j in PAIRS:
                ends = tuple(sorted((row[i], row[j])))
                if ends not in middle:
                    middle[ends] = 1001 + 3 * len(middle)
                    nodes[middle[ends]] = tuple((p + q) / 2 for p, q in zip(nodes[ends[0]], nodes[ends[1]]))
                row.append(middle[ends])
            rows[label] = ", ".join(map(str, [label, *row])) + "\n"
        sides = {"FIX": 0, "FRONT": 1}
        text, card = "", ""
        for line in path.read_text().splitlines(keepends=True):
            if line.startswith("*") and not line.startswith("**"):
                card = line.strip().upper()
                text += line.replace("C3D4", "C3D10")
                if card.startswith("*NODE, NSET=NALL"):
                    text += "".join(f"{v}, {x!r}, {y!r}, {z!r}\n" for v, (x, y, z) in
                                    ((v, shape(p) if shape else p) for v, p in nodes.items()))
                if card.startswith("*NSET") and card.split("=")[1] in sides:
                    text += lines(v for v, p in nodes.items() if p[sides[card.split("=")[1]]] == 0)
            elif card.startswith("*ELEMENT") and line[0].isdigit():
                text += rows[int(line.split(",")[0])]
            elif line[0] != "*" and (card.startswith("*NODE, NSET") or card in ("*NSET, NSET=FIX", "*NSET, NSET=FRONT")):
                continue
            elif card == "*NSET, NSET=LOAD":
                text += f"{small(line.strip(', ' + chr(10)))},\n"
            else:
                text += line
        path.write_text(text.replace("*NODE PRINT, NSET=FIX", step + "*NODE PRINT, NSET=FIX"))
        return Deck(path)

    def optimize(self, *options, code=0):
        done = self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), *options, code=code)
        return done if code else Deck(self.folder / "b.inp")

    def check(self, a, b, solve=True, slides=False):
        """The content of a deck of block() is kept, curved or not."""
        self.assertEqual(a.rest, b.rest)
        self.assertEqual(b.nsets["NALL"], set(b.nodes))
        self.assertEqual(set(b.nodes), {v for t in b.tets.values() for v in t} | set(b.middles.values()))
        self.assertEqual(b.elsets["ALL"], set(b.tets))
        self.assertEqual({e: v for e, v in a.middles.items() if e in b.middles},
                         {e: v for e, v in b.middles.items() if e in a.middles})  # edges that stay keep their node
        for name in () if slides else ("TOP", "MID", "DLOAD"):
            for x, y in zip(a.area_vector(name), b.area_vector(name)):
                self.assertAlmostEqual(x, y, places=12)
        count = {}
        for tet in b.tets.values():
            for face in FACES:
                key = frozenset(tet[k] for k in face)
                count[key] = count.get(key, 0) + 1
        self.assertTrue(all(count[f] == 1 for name in ("TOP", "DLOAD") for f in faces_of(b, name)))
        self.assertTrue(all(count[f] == 2 for f in faces_of(b, "MID")))
        if solve and shutil.which("ccx"):
            for name in ("a", "b"):
                done = subprocess.run(["ccx", name], cwd=self.folder, capture_output=True, text=True)
                self.assertIn("Job finished", done.stdout)
                self.assertNotIn("*ERROR", done.stdout)

    def test_a_straight_deck_follows(self):
        a = self.make(4)
        self.run_cli("convert", self.path("a.inp"), "-o", self.path("same.inp"))
        self.assertEqual(self.read_bytes("a.inp"), self.read_bytes("same.inp"))
        b = self.optimize()
        self.check(a, b)
        self.assertNotEqual(a.tets, b.tets)
        self.assertNotEqual(a.surfaces, b.surfaces)
        for edge, v in b.middles.items():
            for x, y in zip(b.nodes[v], b.midpoint(edge)):
                self.assertAlmostEqual(x, y, places=12)
        for name, axis in (("FIX", 0), ("FRONT", 1)):
            self.assertEqual(b.nsets[name], {v for v, p in b.nodes.items() if p[axis] == 0})

    def test_inserted_vertices_and_their_middles_join_the_sets(self):
        a = self.make(4, jitter=0.3)
        b = self.optimize("--effort", "best")
        self.check(a, b)
        vertices = {v for t in b.tets.values() for v in t}
        self.assertGreater(len(vertices - set(a.nodes)), 0)
        self.assertTrue(all(v > max(a.nodes) for v in vertices - set(a.nodes)))
        for name, axis in (("FIX", 0), ("FRONT", 1)):
            self.assertEqual(b.nsets[name], {v for v, p in b.nodes.items() if p[axis] == 0})

    def test_a_curved_surface_stays_bit_for_bit_with_its_numbers(self):
        a = self.make(5, bend, jitter=0.3)
        b = self.optimize("--untangle", "--boundary", "fixed")
        self.check(a, b)
        self.assertNotEqual(a.tets, b.tets)
        count = {}
        for tet in a.tets.values():
            for face in FACES:
                key = frozenset(tet[k] for k in face)
                count[key] = count.get(key, 0) + 1
        surface = {v for e, v in a.middles.items() if any(n == 1 and f.issuperset(e) for f, n in count.items())}
        surface |= middles_of(a, "MID")
        self.assertTrue(any(math.dist(a.nodes[v], a.midpoint(e)) > 1e-3 for e, v in a.middles.items() if v in surface))
        self.assertEqual({v: a.nodes[v] for v in surface}, {v: b.nodes.get(v) for v in surface})
        for name in ("FIX", "FRONT"):
            self.assertEqual(a.nsets[name], b.nsets[name])
        self.assertEqual(middles_of(a, "DLOAD"), middles_of(b, "DLOAD"))
        self.assertIn("proved valid, 0 inverted, 0 undecided", self.run_cli("info", self.path("b.inp")).stdout)

    def test_a_curved_surface_slides(self):
        def vault(p):
            x, y, z = p
            return (x, y, round(z + 0.3 * x * (1 - x), 12) if z == 1 else z)

        a = self.make(4, vault, jitter=0.3)
        b = self.optimize("--boundary", "slide")
        self.check(a, b, slides=True)
        moved = [v for v in set(a.nodes) & set(b.nodes) if a.nodes[v] != b.nodes[v]]
        self.assertTrue(any(v in {w for f in faces_of(b, "TOP") for w in f} for v in moved))
        for name in ("TOP", "MID", "DLOAD"):
            self.assertEqual(len(a.surfaces[name]), len(b.surfaces[name]))
        self.assertIn("proved valid, 0 inverted, 0 undecided", self.run_cli("info", self.path("b.inp")).stdout)

    def test_a_middle_with_a_load_stays(self):
        for shape in (None, bend):
            a = self.make(5, shape, jitter=0.3)
            free = self.optimize()
            on_sides = a.nsets["FIX"] | a.nsets["FRONT"] | middles_of(a, "TOP") | middles_of(a, "DLOAD") | middles_of(a, "MID")
            gone = [e for e, v in a.middles.items() if e not in free.middles and v not in on_sides]
            moved = [e for e in free.middles if e in a.middles and free.nodes[a.middles[e]] != a.nodes[a.middles[e]]]
            for edge in (gone[0], moved[0]):
                middle = a.middles[edge]
                a = self.make(5, shape, f"*CLOAD\n{middle}, 3, -1.\n", jitter=0.3)
                b = self.optimize()
                self.check(a, b, solve=False)
                self.assertEqual(b.middles[edge], middle)
                self.assertEqual(b.nodes[middle], a.nodes[middle])
                self.assertEqual([b.nodes[v] for v in edge], [a.nodes[v] for v in edge])

    def test_a_held_middle_stays_where_its_elements_are_untangled(self):
        a = self.make(2, bend, jitter=0)
        inner = [e for e, v in a.middles.items() if v not in a.nsets["FIX"] | a.nsets["FRONT"] | middles_of(a, "MID")
                 and all(0.2 < x < 0.9 for x in a.nodes[v])]
        bad = inner[0]
        around = [t for t in a.tets.values() if set(bad) <= set(t)]
        held = a.middles[next(e for e in inner if e != bad and any(set(e) <= set(t) for t in around))]
        text = (self.folder / "a.inp").read_text()
        x, y, z = a.nodes[a.middles[bad]]
        text = re.sub(rf"(?m)^{a.middles[bad]}, .*$", f"{a.middles[bad]}, {round(x + 0.15, 12)!r}, {y!r}, {z!r}", text, count=1)
        for load in ("", f"*CLOAD\n{held}, 3, -1.\n"):
            (self.folder / "a.inp").write_text(text.replace("*NODE PRINT, NSET=FIX", load + "*NODE PRINT, NSET=FIX"))
            self.assertIn(" inverted   scaled", self.run_cli("info", self.path("a.inp"), code=1).stdout)
            b = self.optimize("--untangle")
            self.assertIn("proved valid, 0 inverted, 0 undecided", self.run_cli("info", self.path("b.inp")).stdout)
            self.assertEqual(b.nodes.get(held) == a.nodes[held], load != "")

    @unittest.skipUnless(shutil.which("ccx"), "SKIPPED, NOT TESTED: no CalculiX (Debian: calculix-ccx)")
    def test_calculix_solves_the_deck_that_it_refused(self):
        a = self.make(2, bend, jitter=0)
        bad = next(v for v in a.middles.values() if all(0.2 < x < 0.9 for x in a.nodes[v]))
        text = (self.folder / "a.inp").read_text()
        x, y, z = a.nodes[bad]
        broken = re.sub(rf"(?m)^{bad}, .*$", f"{bad}, {round(x + 0.3, 12)!r}, {y!r}, {z!r}", text, count=1)

        def solve(name):
            done = subprocess.run(["ccx", name], cwd=self.folder, capture_output=True, text=True, timeout=cli_case.HANG)
            return done.stdout, numbers((self.folder / f"{name}.dat").read_text())

        _, (_, *before) = solve("a")
        (self.folder / "a.inp").write_text(broken)
        self.assertIn("nonpositive jacobian", solve("a")[0])
        self.optimize("--untangle", "--boundary", "fixed")
        said, (_, *after) = solve("b")
        self.assertIn("Job finished", said)
        self.assertEqual(len(after), len(before))
        self.assertLess(math.dist(after, before), 0.01 * math.hypot(*before))

    def test_moved_boundaries_take_middles_with_them(self):
        a = self.make(4)
        middle = a.middles[next(e for e in a.middles if all(a.nodes[v][0] == 1 for v in e))]
        a = self.make(4, step=f"*CLOAD\n{middle}, 3, -1.\n")
        self.make(4, lambda p: (1.25, *p[1:]) if p[0] == 1 else p, name="target")
        self.run_cli("move", self.path("a.inp"), "--to", self.path("target.inp"), "-o", self.path("b.inp"))
        b = Deck(self.folder / "b.inp")
        self.assertEqual(a.rest, b.rest)
        self.assertEqual(b.nodes[middle], (1.25, *a.nodes[middle][1:]))
        self.assertEqual(a.area_vector("DLOAD"), b.area_vector("DLOAD"))

    def test_gmsh_and_back_keeps_elements_and_middles(self):
        a = self.make(2, bend)
        self.run_cli("convert", self.path("a.inp"), "-o", self.path("m.msh"))
        self.run_cli("convert", self.path("m.msh"), "-o", self.path("b.inp"))
        self.run_cli("convert", self.path("b.inp"), "-o", self.path("n.msh"))
        b = Deck(self.folder / "b.inp")

        def places(deck):
            rows = []
            for tet in deck.tets.values():
                edges = [tuple(sorted((tet[i], tet[j]))) for i, j in PAIRS]
                rows.append([deck.nodes[v] for v in (*tet, *(deck.middles[e] for e in edges))])
            return sorted(rows)

        self.assertEqual(len(places(a)), len(places(b)))
        for p, q in zip(places(a), places(b)):
            for v, w in zip(p, q):
                for x, y in zip(v, w):
                    self.assertAlmostEqual(x, y, places=14)  # 20 characters, at both writings
        info = [self.run_cli("info", self.path(name)).stdout.split("tetrahedra")[-1] for name in ("m.msh", "n.msh")]
        self.assertEqual(info[0], info[1])

    def test_refusals(self):
        for of, to, message in (("*END STEP\n", "*END STEP\n*ELEMENT, TYPE=C3D4\n99999, 1, 2, 3, 4\n", "use one of both kinds in a deck"),
                                (", 1001, ", ", 1, ", "and also a vertex or on another edge"),
                                ("*END STEP\n", "*END STEP\n*ELEMENT, TYPE=B31\n99999, 1, 1001\n", "is a mid-side node and a vertex of another element")):
            self.make(2)
            path = self.folder / "a.inp"
            text = path.read_text()
            self.assertIn(of, text)
            path.write_text(text.replace(of, to))
            self.assertIn(message, self.optimize(code=2).stderr)


if __name__ == "__main__":
    cli_case.main(__doc__)
