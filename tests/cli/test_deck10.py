# SPDX-License-Identifier: Apache-2.0
"""Decks with second-order tetrahedra through the command line. Run: see cli_case.py."""

import shutil
import subprocess

import cli_case
from cli_case import CliTest
from deck import Deck, block

PAIRS = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
STEP = """*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.3
*SOLID SECTION, ELSET=E, MATERIAL=STEEL
*STEP
*STATIC
*BOUNDARY
FIX, 1, 3
*CLOAD
NALL, 3, -1.
*END STEP
"""


def second_order(path):
    """A deck with the tetrahedra of block() as C3D10, and its nodes at x = 0 as the set FIX."""
    path.write_text(block(2))
    deck = Deck(path)
    small = {n: i + 1 for i, n in enumerate(deck.nodes)}  # CalculiX's numbers are of 32 bits
    nodes, middle, lines = {small[n]: p for n, p in deck.nodes.items()}, {}, []
    for label, old in enumerate(deck.tets.values(), 1):
        tet = [small[n] for n in old]
        row = list(tet)
        for i, j in PAIRS:
            ends = tuple(sorted((tet[i], tet[j])))
            if ends not in middle:
                middle[ends] = max(nodes) + 1
                nodes[middle[ends]] = tuple((p + q) / 2 for p, q in zip(nodes[ends[0]], nodes[ends[1]]))
            row.append(middle[ends])
        lines.append(", ".join(map(str, [label, *row])))
    text = "*NODE, NSET=NALL\n" + "".join(f"{n}, {x!r}, {y!r}, {z!r}\n" for n, (x, y, z) in nodes.items())
    text += "*ELEMENT, TYPE=C3D10, ELSET=E\n" + "\n".join(lines) + "\n*NSET, NSET=FIX\n"
    path.write_text(text + "".join(f"{n},\n" for n, p in nodes.items() if p[0] == 0) + STEP)


class SecondOrderDecks(CliTest):
    def test_deck_follows(self):
        second_order(self.folder / "a.inp")
        self.run_cli("convert", self.path("a.inp"), "-o", self.path("same.inp"))
        self.assertEqual(self.read_bytes("a.inp"), self.read_bytes("same.inp"))
        self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"))
        a, b = Deck(self.folder / "a.inp"), Deck(self.folder / "b.inp")
        self.assertEqual(a.rest, b.rest)
        self.assertNotEqual(self.read_bytes("a.inp"), self.read_bytes("b.inp"))
        self.assertEqual(b.nsets["NALL"], set(b.nodes))
        self.assertEqual(b.nsets["FIX"], {n for n, p in b.nodes.items() if p[0] == 0})
        self.assertEqual(b.elsets["E"], set(b.others))
        for tet in b.others.values():
            self.assertEqual(len(tet), 10)
            for (i, j), m in zip(PAIRS, tet[4:]):
                for x, p, q in zip(b.nodes[m], b.nodes[tet[i]], b.nodes[tet[j]]):
                    self.assertAlmostEqual(x, (p + q) / 2, places=12)
        if shutil.which("ccx"):
            for name in ("a", "b"):
                done = subprocess.run(["ccx", name], cwd=self.folder, capture_output=True, text=True)
                self.assertIn("Job finished", done.stdout)


if __name__ == "__main__":
    cli_case.main(__doc__)
