# SPDX-License-Identifier: Apache-2.0
"""tetune optimize --periodic and --periodic-map. Run: see cli_case.py."""

import json

import cli_case
from cli_case import CliTest, cube


class Periodic(CliTest):
    N = 5

    def setUp(self):
        super().setUp()
        self.mesh = cube(self.N, jitter=0)
        # Inner vertices out of place, so that those of the faces have a reason to move.
        for i, p in enumerate(self.mesh.points):
            if all(0 < x < 1 for x in p):
                self.mesh.points[i] = tuple(x + 0.05 * ((i * (k + 3)) % 7 - 3) / 3 for k, x in enumerate(p))
        self.put("in.mesh", self.mesh)

    def optimize(self, *args, code=0):
        return self.run_cli("optimize", "in.mesh", "-o", "out.mesh", "--report", "r.json", *args, code=code,
                            cwd=self.folder)

    def pairs(self):
        """Vertices of the face x = 1, and those opposite, by the input."""
        places = {p: i for i, p in enumerate(self.mesh.points)}
        return [(i, places[(0.0, p[1], p[2])]) for i, p in enumerate(self.mesh.points) if p[0] == 1]

    def check_match(self):
        after = cli_case.Mesh.read(self.path("out.mesh")).points
        moved = 0
        for image, master in self.pairs():
            x, y, z = after[master]
            self.assertEqual(after[image], (x + 1, y, z))
            moved += after[image] != self.mesh.points[image]
        self.assertGreater(moved, (self.N - 1) ** 2 / 2)

    def test_a_box(self):
        done = self.optimize("--periodic", "x,y,z")
        self.check_match()
        self.assertNotIn("periodic", done.stderr)  # the links are not those of the file
        report = json.loads(self.read_bytes("r.json"))
        n = self.N - 1
        count = 6 * n * n + 12 * n
        self.assertEqual(report["optimization"]["vertices_periodic"], count)
        done = self.run_cli("optimize", "in.mesh", "--dry-run", "--periodic", "x,y,z", cwd=self.folder)
        self.assertRegex(done.stdout, f"periodic vertices +{count}\n")

    def test_a_map(self):
        lines = ["# the faces across x", "translation 1 0 0"] + [f"{i + 1} {m + 1}" for i, m in self.pairs()]
        self.put("pairs.txt", "\n".join(lines))
        self.optimize("--periodic-map", "pairs.txt")
        self.check_match()

    def test_refusals(self):
        for text, message in (("1 2\n", 'pairs.txt:1: expected "translation X Y Z" before the first pair'),
                              ("translation 1 0\n12 7\n", "pairs.txt:1: expected the three components of a translation, found the end of the line"),
                              ("translation 1 0 0\n12\n7 3\n", "pairs.txt:2: expected a vertex and its master, found the end"),
                              ("translation 1 0 0\n1 999\n", "pairs.txt:2: master 999 does not exist"),
                              ("translation 1 nan 0\n1 2\n", "the translation has a component that is not a finite number"),
                              ("translation 1 0 0\n1 2\n", "pairs.txt:2: vertex 1 is")):
            self.put("pairs.txt", text)
            done = self.optimize("--periodic-map", "pairs.txt", code=2)
            self.assertIn(message, done.stderr)
        self.assertIn("--periodic", self.optimize("--periodic", "w", code=2).stderr)
        self.mesh.points[self.pairs()[7][0]] = (1.0, 0.77, 0.77)
        self.put("in.mesh", self.mesh)
        done = self.optimize("--periodic", "x", code=2)
        self.assertIn("in.mesh: periodic in x: 2 vertices on the faces of smallest and largest x", done.stderr)


if __name__ == "__main__":
    cli_case.main(__doc__)
