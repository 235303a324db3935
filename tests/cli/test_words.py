# SPDX-License-Identifier: Apache-2.0
"""The words of the command line: help, Mmg's names, completion, manual. Run: see cli_case.py."""

import json
import re
import shutil
import subprocess
import unittest

import cli_case
from cli_case import CliTest, Mesh, cube, unflipped

COMMANDS = ["optimize", "info", "compare", "report", "completion", "man"]


class Help(CliTest):
    def test_a_mistyped_option_is_guessed(self):
        source = self.put("in.mesh", cube(1))
        for words, said in ((["optimize", source, "--untangel"], "did you mean --untangle?"),
                            (["optimize", source, "-effrot=best"], "effrot"), (["info", source, "--cehck"], "did you mean --check?"),
                            (["--versio"], "did you mean --version?"), (["optimize", source, "-octree", "3"], "-octree: nothing")):
            self.refused(*words, said=[said])
        self.assertNotIn("did you mean", self.refused("optimize", source, "--foo", said=["--foo: there is no such option"]).stderr)
        # Words that are no options: values, what follows --, and what the Python package knows.
        self.run_cli("optimize", source, "-o", self.path("--out.mesh"), "--quiet")
        self.run_cli("optimize", "-o", self.path("b.mesh"), "--", source)
        self.refused("report", "a.mesh", "b.mesh", "--run", "r.json", said=["pip install"])

    def test_help_and_version(self):
        for args in (["--help"], *([command, "--help"] for command in COMMANDS)):
            done = self.run_cli(*args)
            self.assertIn("Usage", done.stdout)
            self.assertEqual(done.stderr, "")
        self.assertIn("Exit codes", self.run_cli("--help").stdout)
        self.assertRegex(self.run_cli("--version").stdout, r"^tetune \d+\.\d+\.\d+\n$")


class Options(CliTest):
    def options(self, *words):
        return json.loads(self.run_cli("optimize", *words, "--print-options").stdout)

    def test_names_of_mmg(self):
        plain = self.options()
        self.assertEqual(json.loads(self.run_cli("optimize", "-val").stdout), plain)
        for words, changed in ((["-ar", "60", "--boundary", "slide"], {"feature_angle_deg": 60, "boundary": "slide"}),
                               (["-nr", "--boundary", "slide"], {"feature_angle_deg": 180, "boundary": "slide"}),
                               (["-hausd", "0.1%", "--boundary", "slide"], {"max_deviation": "0.1%", "boundary": "slide"}),
                               (["-nosurf"], {"boundary": "fixed"}),
                               (["-noswap"], {"flips": False}),
                               (["-nomove"], {"max_iterations": 0}),
                               (["-noinsert"], {"keep_vertices": True}),
                               (["--untangle"], {"untangle": True}),
                               (["-opnbdy"], {}),
                               (["-optim"], {}),
                               (["-nt", "3"], {"threads": 3}),
                               (["-m", "500"], {"max_memory_mb": 500}),
                               (["-v", "-1"], {}),
                               (["--time-limit", "7"], {"time_limit_seconds": 7}),
                               # Long names with one dash.
                               (["-effort", "best"], {"effort": "best"}),
                               (["-effort=fast"], {"effort": "fast"}),
                               (["-max-ring=3"], {"max_ring": 3})):
            self.assertEqual(self.options(*words), {**plain, **changed}, words)

    def test_input_and_output_as_mmg_names_them(self):
        source = self.put("in.mesh", cube(2))
        self.run_cli("optimize", "-in", source, "-out", self.path("out.mesh"))
        self.assertEqual(self.files(), ["in.mesh", "out.mesh"])

    def test_verbosity_of_mmg(self):
        source = self.put("in.mesh", cube(3))

        def lines(*words):
            return len(self.run_cli("optimize", *words, source, self.path("out.mesh")).stdout.splitlines())
        self.assertEqual(lines("-v", "-1"), 0)
        self.assertEqual(lines("-v", "0"), 0)
        usual = lines()
        self.assertEqual(lines("-v", "1"), usual)
        self.assertGreater(lines("-v", "5"), usual + 5)
        self.assertEqual(lines("-v"), lines("-v", "5"))

    def test_what_mmg_has_and_tetune_has_not(self):
        source = self.put("in.mesh", cube(1))
        for word in ("-hmax", "-hsiz", "-sol", "-ls"):
            self.refused("optimize", source, self.path("out.mesh"), word, "0.1", said=[word, "sizes", "drop"])
        # Not the help that begins with the same letter.
        self.refused("optimize", source, self.path("out.mesh"), "-hfoo", said=["-hfoo", "--help"])
        self.refused("optimize", source, self.path("out.mesh"), "-xyz", said=["-xyz"])

    def test_no_flips_moves_vertices_alone(self):
        mesh = unflipped(cube(5))
        source = self.put("in.mesh", mesh)
        for effort in ("fast", "default"):
            self.run_cli("optimize", source, self.path("out.mesh"), "-noswap", "--effort", effort, "--report",
                         self.path("r.json"))
            after = Mesh.read(self.path("out.mesh"))
            self.assertEqual(sorted(tuple(sorted(t)) for t in after.tets), sorted(tuple(sorted(t)) for t in mesh.tets))
            self.assertNotEqual(after.points, mesh.points)
            self.assertGreater(min(after.volumes()), 0)
            run = json.loads(self.read_bytes("r.json"))["optimization"]
            self.assertEqual(run["flip_passes"], [])
            self.assertLess(run["energy_after"], run["energy_before"])
        for words, said in ((["--max-ring", "5"], "--max-ring"), (["-nomove"], "nothing to do"),
                            (["--boundary-flips"], "--boundary-flips")):
            self.refused("optimize", source, self.path("x.mesh"), "-noswap", *words, said=["--no-flips", said])

    def test_noinsert_with_every_effort(self):
        source = self.put("in.mesh", unflipped(cube(6, 0.25)))
        for effort in ("fast", "default", "best"):
            self.run_cli("optimize", source, self.path("out.mesh"), "-noinsert", "--effort", effort, "--quiet")
            self.assertEqual(len(Mesh.read(self.path("out.mesh")).points), 7 ** 3)


class Mistakes(CliTest):
    """Each message says what is wrong, and what to do or where to look."""

    def test_no_command(self):
        for words, said in (([], "no command"), (["in.mesh", "out.mesh"], "'in.mesh' is not a command"), ([""], "'' is not")):
            self.refused(*words, said=["tetune: ", said, ", ".join(COMMANDS), "tetune optimize IN OUT"])
        self.refused("--quiet", said=["tetune: ", "see tetune --help"])

    def test_values(self):
        source = self.put("in.mesh", cube(1))
        for words, said in ((["--boundary", "sliding"], "--boundary: 'sliding' is not one of preserve,slide,fixed"),
                            (["--boundary", "1"], "--boundary: '1' is not one of"),
                            (["--progress", "yes"], "--progress: 'yes' is not one of auto,none,json"),
                            (["--time-limit", "nan"], "--time-limit: 'nan' is not a positive number"),
                            (["--time-limit", "inf"], "--time-limit: 'inf' is not a positive number"),
                            (["-m", "0"], "--max-memory: '0' is not a positive number"),
                            (["--threads", "-1"], "--threads: "),
                            (["--bogus"], "--bogus"),
                            (["--effort"], "--effort: ")):
            done = self.refused("optimize", source, self.path("out.mesh"), *words, said=["tetune: ", said,
                                "; see tetune optimize --help"])
            self.assertEqual(len(done.stderr.splitlines()), 1)

    def test_names_of_mmg_in_messages(self):
        source = self.put("in.mesh", cube(1))
        for word, ours in (("-hausd", "--max-deviation"), ("-ar", "--feature-angle")):
            self.refused("optimize", source, self.path("out.mesh"), word, "1", said=[word, ours, "--boundary slide"])

    def test_a_folder_is_no_mesh(self):
        self.refused("info", str(self.folder), said=[str(self.folder), "is a folder"])


class Generated(CliTest):
    """Completion and manual name every option that the help names."""

    def options_of(self, command):
        text = self.run_cli(command, "--help").stdout
        return set(re.findall(r"(?m)^  (?:-\w,)?(--[\w-]+)", text)) | set(re.findall(r",(--no-[\w-]+)", text))

    def test_bash(self):
        script = self.put("tetune.bash", self.run_cli("completion", "bash").stdout)

        def complete(*words):
            code = (f"source {script}; COMP_WORDS=({' '.join(map(repr, words))}); COMP_CWORD={len(words) - 1}; _tetune; "
                    'printf "%s\\n" "${COMPREPLY[@]}"')
            done = subprocess.run(["bash", "-c", code], capture_output=True, text=True, cwd=self.folder, timeout=cli_case.HANG)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            return set(done.stdout.split())
        self.assertEqual(complete("tetune", ""), {*COMMANDS, "--help", "--version"})
        for command in ("optimize", "info", "compare"):
            self.assertEqual({o for o in complete("tetune", command, "--") if o.startswith("--")}, self.options_of(command))
        self.assertEqual(complete("tetune", "optimize", "--boundary", ""), {"preserve", "slide", "fixed"})
        self.assertEqual(complete("tetune", "optimize", "a.mesh", "--effort", "b"), {"best"})
        self.assertEqual(complete("tetune", "completion", ""), {"bash", "zsh", "fish"})
        self.assertEqual(complete("tetune", "optimize", "tet"), {"tetune.bash"})

    def test_zsh_and_fish(self):
        for shell, check in (("zsh", ["zsh", "-n"]), ("fish", ["fish", "--no-execute"])):
            text = self.run_cli("completion", shell).stdout
            for option in self.options_of("optimize"):
                self.assertIn(option if shell == "zsh" else f"-l {option[2:]} ", text)
            if shutil.which(shell):
                done = subprocess.run([*check, self.put(f"c.{shell}", text)], capture_output=True, text=True, timeout=cli_case.HANG)
                self.assertEqual((done.returncode, done.stderr), (0, ""), shell)
        self.refused("completion", "csh", said=["csh", "fish"])

    @unittest.skipUnless(shutil.which("fish"), "needs fish")
    def test_fish_completes(self):
        script = self.put("tetune.fish", self.run_cli("completion", "fish").stdout)
        done = subprocess.run(["fish", "-c", f"source {script}; complete -C 'tetune optimize --effort '"],
                              capture_output=True, text=True, timeout=cli_case.HANG, env={"HOME": str(self.folder), "PATH": "/usr/bin:/bin"})
        self.assertEqual({line.split()[0] for line in done.stdout.splitlines()}, {"fast", "default", "best"})

    def test_manual(self):
        page = self.run_cli("man").stdout
        for option in self.options_of("optimize") | self.options_of("info"):
            self.assertIn(option.replace("-", "\\-"), page)
        for part in (".SH INTERRUPTION", ".SH EXIT STATUS", ".SH EXAMPLES", "\\-hausd"):
            self.assertIn(part, page)
        if shutil.which("mandoc"):
            name = self.put("tetune.1", page)
            done = subprocess.run(["mandoc", "-T", "lint", "-W", "warning", name], capture_output=True, text=True, timeout=cli_case.HANG)
            self.assertEqual((done.returncode, done.stdout), (0, ""))
            text = subprocess.run(["mandoc", "-T", "utf8", name], capture_output=True, text=True, timeout=cli_case.HANG).stdout
            self.assertIn("--max-deviation", re.sub(".\b", "", text))


if __name__ == "__main__":
    cli_case.main(__doc__)
