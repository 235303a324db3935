# SPDX-License-Identifier: Apache-2.0
"""Decks of Abaqus and CalculiX (.inp) through the command line. Run: see cli_case.py."""

import re
import shutil
import subprocess
import unittest

import cli_case
from cli_case import CliTest, Mesh, cube, with_triangles
from deck import FACES, Deck, block, contact, lines, numbers


class Decks(CliTest):
    def deck_of(self, text):
        return Deck(self.put("text.inp", text))

    def assert_close(self, a, b):
        self.assertEqual(len(a), len(b))
        for x, y in zip(a, b):
            self.assertAlmostEqual(x, y, places=9)

    def assert_follows(self, before, after):
        """The sets, surfaces and loads of a block() are at the same places."""
        self.assertEqual(before.rest, after.rest)
        self.assertEqual(set(before.elsets), set(after.elsets))
        self.assertEqual(set(before.nsets), set(after.nsets))
        for name in ("LEFT", "RIGHT", "ALL", "RANGE"):
            self.assertAlmostEqual(before.volume(name), after.volume(name), places=9)
        self.assertEqual(after.elsets["ALL"], set(after.tets))
        self.assertEqual(after.elsets["RANGE"], set(after.tets))
        self.assertEqual(after.elsets["LEFT"] | after.elsets["RIGHT"], set(after.tets))
        self.assertFalse(after.elsets["LEFT"] & after.elsets["RIGHT"])
        for name in ("TOP", "MID", "DLOAD"):
            self.assert_close(before.area_vector(name), after.area_vector(name))
        self.assertLessEqual({e for e, _ in after.surfaces["MID"]}, after.elsets["LEFT"])
        self.assertEqual(after.nsets["NALL"], set(after.nodes))
        on = [("FIX", 0, 0.0), ("FRONT", 1, 0.0)]
        for name, axis, at in on:
            self.assertEqual(after.nsets[name], {v for v, p in after.nodes.items() if p[axis] == at})
        self.assertEqual(after.nsets["LOAD"], before.nsets["LOAD"])
        self.assertEqual(after.nsets["BOTH"], after.nsets["LOAD"] | after.nsets["FIX"])
        for v in after.nsets["LOAD"]:
            self.assertEqual(after.nodes[v], before.nodes[v])
        for old, new in ((before.nodes, after.nodes), (before.tets, after.tets)):
            self.assertGreater(min([max(old) + 1, *(set(new) - set(old))]), max(old))

    def test_an_unchanged_deck_is_the_same_to_the_byte(self):
        text = block(2)
        variants = {"as is": text, "returns": text.replace("\n", "\r\n"), "no last line end": text[:-1],
                    "blanks": text.replace(", ", "  ,\t"), "blank lines": text.replace("*ELSET", "\n*ELSET"),
                    "small letters": text.lower(), "continued": text.replace("*ELEMENT, TYPE=C3D4, ELSET=LEFT",
                                                                             "*ELEMENT, TYPE=C3D4,\n ELSET=LEFT")}
        for name, variant in variants.items():
            with self.subTest(name):
                self.folder.joinpath("a.inp").write_bytes(variant.encode())
                done = self.run_cli("convert", self.path("a.inp"), "-o", self.path("b.inp"))
                self.assertEqual(done.stderr, "")
                self.assertEqual(self.read_bytes("a.inp"), self.read_bytes("b.inp"))

    def test_sets_follow_an_optimization(self):
        self.put("a.inp", block(4))
        before = Deck(self.path("a.inp"))
        for effort in ("fast", "standard", "best"):
            with self.subTest(effort):
                self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--effort", effort)
                after = Deck(self.path("b.inp"))
                self.assert_follows(before, after)
                moved = sum(before.nodes.get(v) != p for v, p in after.nodes.items())
                self.assertGreater(moved, 10)
                self.assertNotEqual(before.tets, after.tets)
                if effort == "best":
                    self.assertNotEqual(set(before.nodes), set(after.nodes))

    def test_a_surface_inside_a_region_keeps_its_side(self):
        self.put("a.inp", block(4))
        deck = Deck(self.path("a.inp"))
        # Between two tetrahedra of the first material that are at no other surface.
        sides = {}
        for e in sorted(deck.elsets["LEFT"]):
            for f, face in enumerate(FACES):
                sides.setdefault(frozenset(deck.tets[e][k] for k in face), []).append((e, f + 1))
        pair = next(two for key, two in sides.items() if len(two) == 2 and all(0 < x < 1 for v in key for x in deck.nodes[v][1:]))
        for side in pair:
            with self.subTest(side):
                self.put("a.inp", block(4).replace("*MATERIAL, NAME=ALU", "*SURFACE, NAME=IN\n{}, S{}\n*MATERIAL, NAME=ALU".format(*side)))
                self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--effort", "best")
                before, after = Deck(self.path("a.inp")), Deck(self.path("b.inp"))
                self.assert_follows(before, after)
                self.assertEqual(len(after.surfaces["IN"]), 1)
                self.assert_close(before.area_vector("IN"), after.area_vector("IN"))
        self.refused("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--no-open-boundaries",
                     said=["of which the surface IN of the deck consists"])

    def test_moved_nodes(self):
        self.put("a.inp", block(4))
        self.put("target.inp", re.sub(r"(?m)^(50\d{8}), 1\.0,", r"\1, 1.25,", block(4)))
        self.run_cli("move", self.path("a.inp"), "--to", self.path("target.inp"), "-o", self.path("b.inp"))
        before, after = Deck(self.path("a.inp")), Deck(self.path("b.inp"))
        self.assertEqual(before.rest, after.rest)
        self.assertAlmostEqual(after.volume("ALL"), 1.25, places=6)
        self.assert_close([-abs(x) for x in after.area_vector("DLOAD")], [-1, 0, 0])

    def test_included_files_stand_in_the_place_of_their_lines(self):
        text = block(2)
        at = [text.index(key) for key in ("*Node", "*ELEMENT", "*ELSET, ELSET=RIGHT", "*MATERIAL")]
        self.folder.joinpath("mesh").mkdir()
        self.put("mesh/nodes.txt", text[at[0]:at[1]].rstrip("\n"))
        self.put("mesh/elements.txt", text[at[1]:at[2]])
        self.put("mesh/all.inp", "*INCLUDE, INPUT=mesh/nodes.txt\n*include, input=\"elements.txt\"\n")
        self.put("a.inp", text[:at[0]] + "*INCLUDE,INPUT=mesh/all.inp\n" + text[at[2]:])
        self.run_cli("convert", self.path("a.inp"), "-o", self.path("b.inp"))
        self.assertEqual(self.read_bytes("b.inp").decode(), text)
        for name, content, said in (
                ("itself.inp", "*INCLUDE, INPUT=itself.inp\n", "itself.inp includes itself"),
                ("none.inp", "*HEADING\n*INCLUDE, INPUT=gone.txt\n", "none.inp:2: the included file"),
                ("folder.inp", "*INCLUDE, INPUT=mesh\n", "does not exist")):
            self.put(name, content)
            self.refused("info", self.path(name), said=[said])

    def test_other_elements_and_what_cards_name_by_number_stay(self):
        text = block(2)
        nodes = [5_000_000_000 + 10 * v for v in (0, 1, 2, 13)]
        text = text.replace("*ELSET, ELSET=RIGHT", f"*ELEMENT, TYPE=S3, ELSET=SKIN\n9000, {nodes[0]}, {nodes[1]}, 5000000040\n"
                            f"*ELEMENT, TYPE=SPRINGA, ELSET=SPRING\n9001, {nodes[3]}, {nodes[0]}\n*ELSET, ELSET=RIGHT")
        text = text.replace("*END STEP", f"*CLOAD\n{nodes[3]}, 3, 1.\n*END STEP")
        self.put("a.inp", text)
        self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--effort", "best")
        before, after = Deck(self.path("a.inp")), Deck(self.path("b.inp"))
        self.assertEqual(before.others, after.others)
        for v in nodes[0], nodes[1], nodes[3]:
            self.assertEqual(before.nodes[v], after.nodes[v])

    def test_cards_that_are_not_known_hold_the_numbers_in_first_fields(self):
        self.put("a.inp", block(4))
        deck = Deck(self.path("a.inp"))
        nodes = [v for v, p in deck.nodes.items() if all(0 < x < 1 for x in p)][:5]
        elements = sorted(deck.tets)[:3]
        cards = ("*KINEMATIC COUPLING, REF NODE={0}\n{1}, 1, 3\n{2}, 1, 3\n*CFILM\n{3}, 1., 300., 10.\n*NEW CARD\n{4}, 1.\n".format(*nodes)
                 + "".join(f"{e}, 1.5\n" for e in elements))
        self.put("a.inp", block(4).replace("*MATERIAL, NAME=ALU", cards + "*MATERIAL, NAME=ALU"))
        self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--effort", "best")
        before, after = Deck(self.path("a.inp")), Deck(self.path("b.inp"))
        self.assertEqual([before.nodes[v] for v in nodes], [after.nodes[v] for v in nodes])
        self.assertEqual([before.tets[e] for e in elements], [after.tets[e] for e in elements])
        self.assertNotEqual(before.nodes, after.nodes)

    def test_to_and_from_other_formats(self):
        self.put("a.inp", block(2))
        done = self.run_cli("convert", self.path("a.inp"), "-o", self.path("b.msh"))
        self.assertIn("the format cannot hold the rest of the deck", done.stderr)
        info = self.run_cli("info", self.path("b.msh")).stdout
        for name in ("LEFT", "RIGHT", "TOP", "MID", "FIX", "FRONT"):
            self.assertIn(f'"{name}"', info)
        mesh = cube(3)
        mesh.tet_tags = [5 + (t % 3 == 0) for t in range(len(mesh.tets))]
        sides = [f for f in sorted(mesh.boundary_faces()) if all(mesh.points[v][2] == 0 for v in f)]
        self.put("c.mesh", with_triangles(mesh, [(f, 8 + (i % 2)) for i, f in enumerate(sides)]))
        done = self.run_cli("convert", self.path("c.mesh"), "-o", self.path("d.inp"))
        self.assertIn("the format cannot hold tags of vertices", done.stderr)
        self.assertEqual({name: len(s) for name, s in Deck(self.path("d.inp")).elsets.items()},
                         {f"VOLUME{t}": mesh.tet_tags.count(t) for t in (5, 6)})
        self.run_cli("convert", self.path("d.inp"), "-o", self.path("e.mesh"))
        back = Mesh.read(self.path("e.mesh"))
        self.assertEqual(back.points, mesh.points)
        self.assertEqual(sorted(zip(back.tets, back.tet_tags)), sorted(zip(mesh.tets, mesh.tet_tags)))
        listed = self.read_bytes("e.mesh").decode().split("Triangles\n")[1].split("\n")
        self.assertEqual(sorted((*sorted(map(int, row.split()[:3])), int(row.split()[3])) for row in listed[1:len(sides) + 1]),
                         sorted((*(v + 1 for v in f), 8 + (i % 2)) for i, f in enumerate(sides)))

    def test_refusals_have_lines(self):
        head = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n"
        tet = "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n"
        for text, said in (
                ("1 2 3\n", "no keyword lines"), ("*NODE\n1, 0., x, 0.\n", "a.inp:2: expected a coordinate, found \"x\""),
                ("*NODE\n\n1.5, 0., 0.\n", "a.inp:3: expected the number of a node, found \"1.5\""),
                (head + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3\n", "a.inp:7: element 1 has 3 nodes instead of 4"),
                (head + "*ELEMENT\n1, 1, 2, 3, 4\n", "a.inp:6: *ELEMENT has no TYPE"),
                (head + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n*ELEMENT, TYPE=C3D10\n", "use one of both kinds in a deck"),
                (head + "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 9\n", "a.inp:7: element 1 has the node 9, which is not defined"),
                (head + head + tet, "a.inp:10: node 4 is defined twice, first at "), (head + tet + tet, "a.inp:9: element 1 is defined twice, first at "),
                (head + tet + "*ELEMENT, TYPE=T3D2\n2, 1, 2\n1, 1, 2\n", "a.inp:10: element 1 is defined twice"),
                ("/PREP7\nN,1,0.,0.,0.\n", "a.inp:1: this is a deck of ANSYS (/PREP7)"),
                ("! mesh\n*SET,a,1\nn,1,0,0,0\n", "a.inp:2: this is a deck of ANSYS (*SET)"),
                ("*HEADING\n*BOUNDARY\nN, 1, 3\n", "the deck has no *NODE card"),
                (head, "the deck has no *ELEMENT card"), (tet, "the deck has no *NODE card"), (head + tet + "*NGEN\n1, 4, 1\n", "a.inp:8: *NGEN: this card generates"),
                (head + tet + "*NSET\n1\n", "*NSET has no name"), (head + tet + "*ELSET, ELSET=A\nB\n", "lists B, which is not"),
                (head + tet + "*NSET, NSET=A, GENERATE\n1, 2, 0\n", "FIRST, LAST, STEP")):
            with self.subTest(said):
                self.put("a.inp", text)
                self.refused("info", self.path("a.inp"), said=[said])

    @unittest.skipUnless(shutil.which("ccx"), "SKIPPED, NOT TESTED: no CalculiX (Debian: calculix-ccx)")
    def test_calculix_has_the_same_result(self):
        # CalculiX's numbers of nodes have 32 bits.
        self.put("a.inp", block(6, jitter=0.15).replace("50000", "1"))
        self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--effort", "best")
        before, after = Deck(self.path("a.inp")), Deck(self.path("b.inp"))
        self.assert_follows(before, after)
        results = []
        for name in "ab":
            subprocess.run(["ccx", name], cwd=self.folder, check=True, capture_output=True, timeout=cli_case.HANG)
            results.append(numbers((self.folder / f"{name}.dat").read_text()))
        for time, reaction, _, _, _, displacement, _, _ in results:
            self.assertEqual(time, 1)
            self.assertAlmostEqual(reaction, -70, places=3)  # the pressure times the area
            self.assertAlmostEqual(displacement / results[0][5], 1, delta=0.02)

    def test_loads_on_each_node_of_a_set_keep_their_total(self):
        text = block(5)
        labels = [v for v, p in self.deck_of(text).nodes.items() if p[0] == 1]
        self.put("a.inp", text.replace("*STEP", "*NSET, NSET=PULLED\n" + lines(labels) + "*STEP", 1).replace(
            "*DLOAD", "*CLOAD\nPULLED, 1, 2.\n*DLOAD"))
        self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--effort", "best")
        before, after = Deck(self.path("a.inp")), Deck(self.path("b.inp"))
        self.assertNotEqual(set(before.nodes), set(after.nodes))
        self.assertEqual(after.nsets["PULLED"], set(labels))
        self.assertEqual([before.nodes[v] for v in labels], [after.nodes[v] for v in labels])
        self.assert_follows(before, after)

    def stretched(self):
        """A block() of long elements, into whose edges vertices are inserted."""
        return re.sub(r"(?m)^50(\d{8}), ([^,]+), ([^,]+), ([^,]+)$",
                      lambda m: f"50{m[1]}, {m[2]}, {10 * float(m[3])!r}, {m[4]}", block(4, jitter=0.1)).replace("50000", "1")

    def card(self, path, name):
        """The fields of the data lines of the first card with this keyword line."""
        text = self.read_bytes(path).decode()
        rows = text[text.index(name + "\n") + len(name) + 1:].split("\n*")[0].split("\n")
        return [[field.strip() for field in row.split(",")] for row in rows if row]

    def test_supports_on_lines_have_the_nodes_that_are_inserted_on_them(self):
        text = self.stretched()
        nodes = self.deck_of(text).nodes
        rim = [v for v, p in nodes.items() if p[0] == 1 and p[2] == 0]
        listed = [v for v, p in nodes.items() if p[0] == 1 and p[2] == 1]
        self.put("a.inp", text.replace("*STEP", "*NSET, NSET=RIM\n" + lines(rim) + "*BOUNDARY\nRIM, 1, 3\n"
                                       + "".join(f"{v}, 3\n" for v in listed) + "*STEP", 1))
        self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--effort", "best")
        after = Deck(self.path("b.inp"))
        self.assertGreater(len(after.nsets["RIM"]), len(rim))
        self.assertEqual(after.nsets["RIM"], {v for v, p in after.nodes.items() if p[0] == 1 and p[2] == 0})
        rows = self.card("b.inp", "*BOUNDARY")
        self.assertEqual(rows[0], ["RIM", "1", "3"])
        self.assertGreater(len(rows), len(listed) + 1)
        self.assertEqual({int(row[0]) for row in rows[1:]}, {v for v, p in after.nodes.items() if p[0] == 1 and p[2] == 1})

    def test_inserted_nodes_have_temperatures(self):
        def temperature(p):
            return 20 + 50 * p[0] + 10 * p[1] - 30 * p[2]

        text = block(4, jitter=0.25).replace("50000", "1")
        nodes = self.deck_of(text).nodes
        text = re.sub(r"(\*ELASTIC\n.*\n)", r"\1*EXPANSION\n1.E-5\n", text).replace(
            "*STEP", "*INITIAL CONDITIONS, TYPE=TEMPERATURE\n" + "".join(f"{v}, 20.\n" for v in nodes) + "*STEP", 1)
        self.put("a.inp", text.replace("*DLOAD", "*TEMPERATURE\n" + "".join(f"{v}, {temperature(p)!r}\n" for v, p in nodes.items())
                                       + "*DLOAD").replace("*NODE PRINT, NSET=LOAD\nU", "*NODE PRINT, NSET=NALL\nNT"))
        self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--effort", "best")
        after = Deck(self.path("b.inp"))
        self.assertGreater(len(after.nodes), len(nodes))
        for name, expected in (("*INITIAL CONDITIONS, TYPE=TEMPERATURE", lambda p: 20), ("*TEMPERATURE", temperature)):
            found = {int(v): float(t) for v, t in self.card("b.inp", name)}
            self.assertEqual(set(found), set(after.nodes))
            for v, t in found.items():
                self.assertAlmostEqual(t, expected(after.nodes[v]), places=9)
        if shutil.which("ccx") is None:
            self.skipTest("SKIPPED, NOT TESTED: no CalculiX (Debian: calculix-ccx)")
        subprocess.run(["ccx", "b"], cwd=self.folder, check=True, capture_output=True, timeout=cli_case.HANG)
        printed = (self.folder / "b.dat").read_text().split("temperatures for set NALL")[1]
        found = dict(re.findall(r"(?m)^ +(\d+) +(\S+)$", printed))
        self.assertEqual(set(map(int, found)), set(after.nodes))
        for v, t in found.items():
            self.assertAlmostEqual(float(t), temperature(after.nodes[int(v)]), places=3)

    def test_surfaces_in_contact_stay_in_contact(self):
        self.put("a.inp", contact())
        self.run_cli("optimize", self.path("a.inp"), "-o", self.path("b.inp"), "--effort", "best")
        before, after = Deck(self.path("a.inp")), Deck(self.path("b.inp"))
        self.assertNotEqual(before.tets, after.tets)
        self.assertEqual(before.rest, after.rest)
        for name in ("MASTER", "SLAVE", "DLOAD"):
            self.assert_close(before.area_vector(name), after.area_vector(name))
            self.assertLessEqual({e for e, _ in after.surfaces[name]}, after.elsets["LOWER" if name == "MASTER" else "UPPER"])
        for name, axis, at in (("BOTTOM", 2, 0), ("X0", 0, 0), ("Y0", 1, 0)):
            self.assertEqual(after.nsets[name], {v for v, p in after.nodes.items() if p[axis] == at})
        self.assertEqual(after.nsets["TIP"], before.nsets["TIP"])
        if shutil.which("ccx") is None:
            self.skipTest("SKIPPED, NOT TESTED: no CalculiX (Debian: calculix-ccx)")
        for name in "ab":
            subprocess.run(["ccx", name], cwd=self.folder, check=True, capture_output=True, timeout=cli_case.HANG)
            _, _, _, displacement, _, _, _, reaction = numbers((self.folder / f"{name}.dat").read_text())
            self.assertAlmostEqual(displacement, -0.02, delta=2e-5)  # of both cubes, and 1e-5 of the contact
            self.assertAlmostEqual(reaction, 10, places=3)


if __name__ == "__main__":
    cli_case.main(__doc__)
