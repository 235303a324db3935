# SPDX-License-Identifier: Apache-2.0
"""tetune optimize --only-below: the rest of the file stays. Run: see cli_case.py."""

import json

import cli_case
from cli_case import CliTest, Mesh, cube


def disturbed():
    """A regular cube with one vertex near a corner out of place."""
    mesh = cube(8, jitter=0)
    at = (2 * 9 + 2) * 9 + 2
    x, y, z = mesh.points[at]
    mesh.points[at] = (x + 0.11, y, z)
    return mesh


class OnlyBelow(CliTest):
    def optimize(self, *args, code=0):
        return self.run_cli("optimize", "in.mesh", "-o", "out.mesh", *args, code=code, cwd=self.folder)

    def test_lines_of_the_rest_are_the_same(self):
        self.put("raw.mesh", disturbed())
        # As tetune writes it.
        self.run_cli("convert", self.path("raw.mesh"), self.path("in.mesh"))
        before = self.read_bytes("in.mesh").decode().splitlines()
        mesh = Mesh.read(self.path("in.mesh"))
        for effort in ("fast", "standard", "best"):
            for boundary in ("preserve", "fixed", "slide"):
                results = set()
                for threads in (1, 3):
                    done = self.optimize("--only-below", "20", "--effort", effort, "--boundary", boundary,
                                         "--report", "r.json", "--map", "map.txt", "--threads", threads)
                    results.add(self.read_bytes("out.mesh"))
                self.assertEqual(len(results), 1)
                report = json.loads(self.read_bytes("r.json"))
                run = report["optimization"]
                active = run["tetrahedra_active"]
                self.assertIn(f"{run['tetrahedra_bad']} tetrahedra below the limits of --only-below, {active} might",
                              done.stdout)
                self.assertLess(run["tetrahedra_bad"], active)
                self.assertLess(active, len(mesh.tets) / 4)
                after = self.read_bytes("out.mesh").decode().splitlines()
                changed = set(before) - set(after)
                self.assertGreater(len(changed), 0)
                self.assertLessEqual(len(changed), 2 * active)
                # In order: the lines that stay are a subsequence of the result.
                rest = iter(after)
                kept = [line for line in before if line in set(after) and " " in line]
                self.assertTrue(all(line in rest for line in kept))
                self.assertGreater(report["after"]["dihedral_min_deg"], report["before"]["dihedral_min_deg"] + 10)

    def test_a_copy_where_nothing_is_bad(self):
        mesh = cube(3)
        # Not as tetune would write it.
        text = mesh.text().replace("Vertices", "# by hand\n\nVertices")
        self.put("in.mesh", text)
        done = self.optimize("--only-below", "1e-3")
        self.assertEqual(self.read_bytes("out.mesh").decode(), text)
        self.assertIn("nothing to do", done.stdout)
        self.run_cli("optimize", "in.mesh", "-o", "in.mesh", "--only-below", "mean_ratio=1e-3", cwd=self.folder)
        self.assertEqual(self.read_bytes("in.mesh").decode(), text)
        # Another format is written.
        self.run_cli("optimize", "in.mesh", "-o", "out.meshb", "--only-below", "1e-3", cwd=self.folder)
        self.run_cli("convert", "out.meshb", "-o", "out.mesh", cwd=self.folder)
        self.assertEqual(Mesh.read(self.path("out.mesh")).tets, mesh.tets)

    def test_sets_of_a_deck_follow(self):
        """Vertices are inserted and removed at a surface whose nodes are a set of the deck."""
        mesh = cube(6, jitter=0.3)
        faces = [[v + 1 for v in tet if mesh.points[v][0] == 0] for tet in mesh.tets]
        surface = [f"{f[0]} {f[1]} {f[2]} 7" for f in faces if len(f) == 3]
        self.assertEqual(len(surface), 72)
        text = mesh.text().split("End")[0]
        self.put("in.mesh", text + "\n".join(["Triangles", str(len(surface)), *surface, "End", ""]))
        self.run_cli("convert", "in.mesh", "in.inp", cwd=self.folder)
        for limit in (15, 20, 25, 30):
            self.run_cli("optimize", "in.inp", "-o", "out.inp", "--effort", "best", "--only-below", limit,
                         "--report", "r.json", cwd=self.folder)
            self.run_cli("info", "--check", "out.inp", cwd=self.folder)
            place, members, card = {}, set(), ""
            for line in self.read_bytes("out.inp").decode().splitlines():
                if line.startswith("*"):
                    card = line.upper().replace(" ", "")
                elif card.startswith("*NODE"):
                    number, x, *_ = line.split(",")
                    place[int(number)] = float(x)
                elif card.startswith("*NSET") and "SURFACE7" in card:
                    members.update(int(n) for n in line.split(",") if n.strip())
            self.assertEqual({n for n, x in place.items() if x == 0}, members)

    def test_a_deck_is_written_with_its_includes(self):
        self.put("in.mesh", cube(2))
        self.run_cli("convert", "in.mesh", "mesh.inp", cwd=self.folder)
        self.put("job.inp", "*INCLUDE, INPUT=mesh.inp\n*STEP\n*END STEP\n")
        (self.folder / "out").mkdir()
        self.run_cli("optimize", "job.inp", "-o", "out/job.inp", "--only-below", "1e-3", cwd=self.folder)
        self.run_cli("info", "--check", "out/job.inp", cwd=self.folder)

    def test_targets_and_exit_code(self):
        self.put("in.mesh", disturbed())
        done = self.optimize("--only-below", "20", "--target-quality", "mean_ratio=0.9", code=1)
        self.assertIn("held by: locked element", done.stdout)

    def test_refusals(self):
        self.put("in.mesh", disturbed())
        for args, said in ((["--only-below", "80"], ["--only-below", "80", "70.528"]),
                           (["--only-below", "beauty=1"], ["--only-below", "'beauty'", "mean_ratio"]),
                           (["--only-below", "ten"], ["--only-below", "'ten'"]),
                           (["--only-below", "10", "--rings", "-1"], ["--rings"])):
            self.refused("optimize", "in.mesh", "-o", "out.mesh", *args, said=said, cwd=self.folder)
        self.assertIn("--rings 3 has no effect without --only-below", self.optimize("--rings", "3").stderr)
        self.refused("move", "in.mesh", "-o", "out.mesh", "--to", "in.mesh", "--only-below", "10",
                     said=["--only-below is for optimize"], cwd=self.folder)


if __name__ == "__main__":
    cli_case.main(__doc__)
