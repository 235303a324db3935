# SPDX-License-Identifier: Apache-2.0
"""Where meshes come from and go to: two free words, several meshes, pipes. Run: see cli_case.py."""

import json
import os
import subprocess

import cli_case
from cli_case import CliTest, Mesh, cube


class Files(CliTest):
    def test_second_word_is_the_output(self):
        source = self.put("in.mesh", cube(3))
        self.run_cli("optimize", source, self.path("a.mesh"), "--quiet")
        self.run_cli("optimize", source, "-o", self.path("b.mesh"), "--quiet")
        self.assertEqual(self.read_bytes("a.mesh"), self.read_bytes("b.mesh"))

    def test_no_mesh_is_overwritten_as_second_word(self):
        """The second name may be a mesh that a pattern as *.mesh has matched."""
        first, second = self.put("a.mesh", cube(2)), self.put("b.mesh", cube(3))
        os.mkdir(self.path("new"))
        self.put("new/a.mesh", cube(1))
        for words in ([first, second], [first, first], [first, self.path("new")], ["-", second]):
            names = self.files()
            self.refused("optimize", *words, "--report", self.path("r.json"), said=[words[1], "exists", "-o"])
            self.assertEqual(self.files(), names)
        self.assertEqual(self.read_bytes("b.mesh").decode(), cube(3).text())
        self.assertEqual(self.read_bytes("new/a.mesh").decode(), cube(1).text())
        self.run_cli("optimize", first, "-o", second, "--quiet")
        self.assertNotEqual(self.read_bytes("b.mesh").decode(), cube(3).text())
        os.symlink("absent.mesh", self.path("link.mesh"))
        self.run_cli("optimize", first, self.path("link.mesh"), "--quiet")

    def test_which_words_are_needed(self):
        source = self.put("in.mesh", cube(1))
        self.refused("optimize", said=["input"])
        self.refused("optimize", source, said=["output", "-o", "--dry-run"])
        self.refused("optimize", source, self.path("b.mesh"), self.path("c.mesh"), said=["output", "FOLDER/", "{}"])
        self.assertEqual(self.files(), ["in.mesh"])

    def test_a_folder_as_output(self):
        source = self.put("in.mesh", cube(2))
        os.mkdir(self.path("new"))
        for slash in ("", "/"):
            self.run_cli("optimize", source, "-o", self.path("new") + slash, "--quiet")
            self.assertEqual(os.listdir(self.path("new")), ["in.mesh"])
            os.remove(self.path("new/in.mesh"))
        self.run_cli("optimize", source, "-o", self.path("made") + "/", "--dry-run")
        self.assertFalse(os.path.exists(self.path("made")))
        self.refused("optimize", self.put("m.vtp", ""), "-o", self.path("made") + "/", "--dry-run", said=[".vtp"])
        self.assertFalse(os.path.exists(self.path("made")))
        os.remove(self.path("m.vtp"))
        self.run_cli("optimize", source, "-o", self.path("made") + "/", "--quiet")
        self.assertEqual(os.listdir(self.path("made")), ["in.mesh"])
        self.refused("optimize", source, "-o", self.path("absent/made") + "/", said=["absent/made", "does not exist"])


class Several(CliTest):
    def meshes(self, *names):
        return [self.put(name, cube(3, 0.2, seed)) for seed, name in enumerate(names)]

    def test_the_same_as_one_by_one(self):
        sources = self.meshes("a.mesh", "b.mesh", "c.mesh")
        os.mkdir(self.path("new"))
        done = self.run_cli("optimize", *sources, "-o", self.path("new") + "/")
        self.assertEqual(sorted(os.listdir(self.path("new"))), ["a.mesh", "b.mesh", "c.mesh"])
        for source in sources:
            self.run_cli("optimize", source, "-o", self.path("one.mesh"), "--quiet")
            self.assertEqual(self.read_bytes("new/" + os.path.basename(source)), self.read_bytes("one.mesh"))
        lines = done.stdout.splitlines()
        self.assertEqual(len(lines), 4)
        self.assertIn("dihedral min", lines[0])
        for line, source in zip(lines[1:], sources):
            self.assertRegex(line, rf"^  {source} +162 +\d+ +[\d.]+ -> +[\d.]+ +[\d.]+ -> +[\d.]+ +[\d.]+  done$")
        self.assertNotIn("eta", done.stdout)
        self.assertIn("eta", self.run_cli("optimize", *sources, "-o", self.path("new"), "-v", "2").stdout)

    def test_names_are_filled_in(self):
        sources = self.meshes("a.mesh", "b.mesh")
        self.run_cli("optimize", *sources, "-o", self.path("new_{}.meshb"), "--report", self.path("{}.json"), "--trace",
                     self.path("{}.csv"), "--map", self.path("{}.map"), "--quiet")
        self.assertEqual(self.files(), ["a.csv", "a.json", "a.map", "a.mesh", "b.csv", "b.json", "b.map", "b.mesh",
                                        "new_a.meshb", "new_b.meshb"])
        self.assertEqual(json.loads(self.read_bytes("b.json"))["output"], self.path("new_b.meshb"))

    def test_one_failure_does_not_stop_the_others(self):
        first, last = self.meshes("a.mesh", "c.mesh")
        broken = self.put("b.mesh", "no mesh")
        done = self.run_cli("optimize", first, broken, self.path("absent.mesh"), last, "-o", self.path("new_{}.mesh"), code=2)
        self.assertIn("b.mesh:1: ", done.stderr)
        self.assertIn("absent.mesh", done.stderr)
        self.assertEqual([line.split()[-1] for line in done.stdout.splitlines()[1:]], ["done", "failed", "failed", "done"])
        self.assertEqual(self.files(), ["a.mesh", "b.mesh", "c.mesh", "new_a.mesh", "new_c.mesh"])

    def test_the_worst_exit_code(self):
        sources = self.meshes("a.mesh", "b.mesh")
        done = self.run_cli("optimize", *sources, "-o", self.path("new_{}.mesh"), "--target-dihedral", "70", code=1)
        self.assertEqual(done.stdout.count("target missed"), 2)

    def test_clashes_are_refused_before_the_work(self):
        a, b = self.meshes("a.mesh", "b.mesh")
        os.mkdir(self.path("other"))
        twin = self.put("other/a.mesh", cube(2))
        names = self.files()
        for words, said in (
                ([a, twin, "-o", self.path("new_{}.mesh")], [self.path("new_a.mesh"), a, twin]),
                ([a, b, "-o", self.path("new.mesh")], ["new.mesh", "{}"]),
                ([a, b, "-o", self.path("new_{}.mesh"), "--report", self.path("r.json")], ["--report", "{}"]),
                ([a, b, "-o", self.path("new_{}.mesh"), "--map", self.path("new_{}.mesh")], ["new_a.mesh", "twice"]),
                ([a, a, "-o", self.path("new_{}.mesh")], [a, "twice"]),
                ([a, self.path("other/../a.mesh"), "-o", self.path("new_{}.mesh")], ["twice"]),
                ([a, twin, "-o", self.path("other")], [self.path("other/a.mesh")]),
                ([a, "-", "-o", self.path("new_{}.mesh")], ["standard input"]),
                ([a, b, "-o", "-"], ["--output"])):
            self.refused("optimize", *words, said=said)
            self.assertEqual(self.files(), names)
            self.assertEqual(os.listdir(self.path("other")), ["a.mesh"])
        # In place is no clash.
        self.run_cli("optimize", a, b, "-o", self.path("{}.mesh"), "--quiet")


class Pipes(CliTest):
    def piped(self, data, *words, code=0):
        done = subprocess.run([cli_case.TETUNE, *words], input=data, capture_output=True, timeout=cli_case.HANG)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def test_text_and_binary(self):
        source = self.put("in.mesh", cube(3))
        for ending in ("mesh", "meshb"):
            self.run_cli("optimize", source, self.path(f"out.{ending}"), "--quiet", "--max-iterations", "0")
            data = self.read_bytes(f"out.{ending}")
            self.run_cli("optimize", self.path(f"out.{ending}"), self.path(f"again.{ending}"), "--quiet")
            again = self.read_bytes(f"again.{ending}")
            done = self.piped(data, "optimize", "-", "-")
            self.assertEqual(done.stdout, again)
            self.assertIn(b"dihedral min", done.stderr)
            self.assertIn(b"standard output", done.stderr)
            self.assertEqual(self.piped(data, "optimize", "-", "-", "--quiet").stderr, b"")
            if ending == "mesh":  # with the mark that some editors put before a text
                self.assertEqual(self.piped(b"\xef\xbb\xbf" + data, "optimize", "-", "-", "--quiet").stdout, again)
            self.assertEqual(self.piped(b"", "optimize", self.path(f"out.{ending}"), "-", "--quiet").stdout, again)
            self.piped(data, "optimize", "-", "-o", self.path("x.mesh"), "--quiet")
            self.assertEqual(Mesh.read(self.path("x.mesh")).points, Mesh.read(self.path("again.mesh")).points)
            info = json.loads(self.piped(data, "info", "--json", "-").stdout)
            self.assertEqual(info["counts"]["vertices"], 64)

    def test_errors_name_the_standard_input(self):
        for data, said in ((b"", b"standard input"), (b"no mesh", b"standard input:1: "), (b"\1\0\0\0", b"standard input, byte"),
                           (cube(1).text().replace("Tetrahedra", "Tetrahedra\nx").encode(), b"standard input:")):
            done = self.piped(data, "optimize", "-", "-", code=2)
            self.assertEqual(done.stdout, b"")
            self.assertIn(said, done.stderr)
        for output in (self.path("{}.mesh"), str(self.folder)):
            self.assertIn(b"the standard input has no name", self.piped(b"", "optimize", "-", "-o", output, code=2).stderr)

    def test_nothing_but_a_mesh_goes_there(self):
        source = self.put("in.mesh", cube(1))
        for option in ("--report", "--trace", "--map"):
            self.refused("optimize", source, "-o", self.path("out.mesh"), option, "-", said=[option + " -: ", "file name"])

    def test_json_and_a_mesh(self):
        done = self.piped(cube(2).text().encode(), "optimize", "-", "-", "--progress", "json")
        self.assertTrue(done.stdout.startswith(b"MeshVersionFormatted"))
        for line in done.stderr.splitlines():
            json.loads(line)


if __name__ == "__main__":
    cli_case.main(__doc__)
