# SPDX-License-Identifier: Apache-2.0
"""Help, options, Mmg's names, completion, manual. Run: see cli_case.py."""

import json
import re
import shutil
import subprocess
import unittest
from pathlib import Path

import cli_case
from cli_case import CliTest, Mesh, cube, unflipped

COMMANDS = ["optimize", "convert", "move", "info", "compare", "report", "completion", "man"]


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

    def test_values_that_are_none(self):
        source = self.put("in.mesh", cube(1))
        for words, said in ((["--threads", "two"], "--threads: 'two' is not an integer"), (["--threads", "1.5"], "'1.5' is not an integer"),
                            (["--max-growth", "x"], "--max-growth: 'x' is not a number"), (["--threads"], "--threads: the value is missing"),
                            (["--effort", "best", "--effort", "fast"], "--effort is given more than once")):
            self.refused("optimize", source, "-o", self.path("out.mesh"), *words, said=[said])
        self.refused("convert", source, "a.mesh", "b.mesh", said=["too many arguments: b.mesh"])

    def test_time_series_are_for_move(self):
        self.refused("optimize", self.path("in.pvd"), "-o", self.path("out.pvd"), said=["tetune move"])
        self.assertIn(".pvd", self.run_cli("move", "--help").stdout)

    def test_errors_of_arguments_as_json(self):
        source = self.put("in.mesh", cube(1))
        for words in (["--effort", "bst", "--progress", "json"], ["--progress=json", "--wide"], ["--progress", "json", "--max-growth", "-1"],
                      ["--progress", "json", "--criteria", self.path("absent.toml")]):
            done = self.refused("optimize", source, "-o", self.path("out.mesh"), *words)
            error, end = map(json.loads, done.stderr.splitlines())
            self.assertEqual(error["event"], "error")
            self.assertLess(end.pop("seconds"), cli_case.HANG)
            self.assertEqual(end, {"event": "end", "input": None, "result": "failed", "exit_code": 2})

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
        for words, changed in ((["-ar", "60", "--boundary", "slide"], {"feature_angle": 60, "feature_angle_deg": 60, "boundary": "slide"}),
                               (["-nr", "--boundary", "slide"], {"feature_angle": 180, "feature_angle_deg": 180, "boundary": "slide"}),
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
            return len(self.run_cli("optimize", *words, source, "-o", self.path("out.mesh")).stdout.splitlines())
        self.assertEqual(lines("-v", "-1"), 0)
        self.assertEqual(lines("-v", "0"), 0)
        usual = lines()
        self.assertEqual(lines("-v", "1"), usual)
        self.assertGreater(lines("-v", "5"), usual + 5)
        self.assertEqual(lines("-v"), lines("-v", "5"))

    def test_what_mmg_has_and_tetune_has_not(self):
        source = self.put("in.mesh", cube(1))
        for word in ("-hmax", "-hsiz", "-sol", "-ls"):
            self.refused("optimize", source, "-o", self.path("out.mesh"), word, "0.1", said=[word, "sizes", "remove"])
        # Not the help that begins with the same letter.
        self.refused("optimize", source, "-o", self.path("out.mesh"), "-hfoo", said=["-hfoo", "--help"])
        self.refused("optimize", source, "-o", self.path("out.mesh"), "-xyz", said=["-xyz"])

    def test_no_flips_moves_vertices_alone(self):
        mesh = unflipped(cube(5))
        source = self.put("in.mesh", mesh)
        for effort in ("fast", "standard"):
            self.run_cli("optimize", source, "-o", self.path("out.mesh"), "-noswap", "--effort", effort, "--report",
                         self.path("r.json"))
            after = Mesh.read(self.path("out.mesh"))
            self.assertEqual(sorted(tuple(sorted(t)) for t in after.tets), sorted(tuple(sorted(t)) for t in mesh.tets))
            self.assertNotEqual(after.points, mesh.points)
            self.assertGreater(min(after.volumes()), 0)
            run = json.loads(self.read_bytes("r.json"))["optimization"]
            self.assertEqual(run["flip_passes"], [])
            self.assertLess(run["energy_after"], run["energy_before"])

    def test_without_operations_a_mesh_is_only_converted(self):
        mesh = unflipped(cube(5))
        source = self.put("in.mesh", mesh)
        for effort in ("fast", "standard", "best"):
            done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "-noswap", "-nomove", "--effort", effort)
            self.assertIn("warning: --max-iterations 0 leaves nothing to improve with --no-flips", done.stderr)
            after = Mesh.read(self.path("out.mesh"))
            self.assertEqual(after.points, mesh.points)
            self.assertEqual(sorted(tuple(sorted(t)) for t in after.tets), sorted(tuple(sorted(t)) for t in mesh.tets))

    def test_redundant_options_are_warnings(self):
        source = self.put("in.mesh", cube(3))
        done = self.run_cli("optimize", source, "-o", self.path("out.mesh"), "--no-boundary-flips", "--max-ring", "3")
        self.assertIn("warning: --no-boundary-flips has no effect with --max-ring 3", done.stderr)

    def test_former_names_are_accepted_with_a_warning(self):
        for words, name, value in ((["--effort", "default"], "effort", "standard"), (["--device", "automatic"], "device", "auto")):
            done = self.run_cli("optimize", *words, "--print-options")
            self.assertEqual(json.loads(done.stdout)[name], value)
            self.assertIn(f"{' '.join(words)} is the former name of {words[0]} {value}", done.stderr)
            self.assertEqual(len(done.stderr.splitlines()), 1)

    def test_options_without_effect_are_warnings(self):
        for words, said in ((["--feature-angle", "60"], "--feature-angle 60 has no effect without --boundary slide"),
                            (["-ar", "60", "-nosurf"], "--feature-angle 60 has no effect without --boundary slide"),
                            (["-hausd", "0.1%"], "--max-deviation 0.1% has no effect without --boundary slide"),
                            (["--effort", "fast", "--termination", "paper"], "--effort fast has little effect with --termination paper"),
                            (["--effort", "best", "-nomove"], "--effort best has no effect with --max-iterations 0"),
                            (["--effort", "best", "--energy", "harmonic"], "--effort best inserts no vertices"),
                            (["--effort", "best", "--termination", "paper"], "--effort best has little effect with --termination paper"),
                            (["--relocation", "newton", "-nomove"], "--relocation newton has no effect with --max-iterations 0"),
                            (["--termination", "paper", "-nomove"], "--termination paper has no effect with --max-iterations 0"),
                            (["--boundary-flips", "-nosurf"], "--boundary-flips has no effect with --boundary fixed"),
                            (["--boundary-flips", "--max-ring", "3"], "--boundary-flips has no effect with --max-ring 3"),
                            (["--no-boundary-flips", "-nomove"], "--no-boundary-flips has no effect with --max-iterations 0"),
                            (["-noswap", "--max-ring", "5"], "--max-ring 5 has no effect with --no-flips"),
                            (["--device", "cuda", "--threads", "2"], "--threads 2 has no effect with --device cuda"),
                            (["--trace-angles"], "--trace-angles has no effect without --report")):
            done = self.run_cli("optimize", *words, "--print-options")
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn("tetune: warning: " + said, done.stderr)
        for words in (["--surface-vertices", "keep", "--boundary", "fixed", "--effort", "best"],
                      ["--surface-vertices", "keep", "--max-ring", "3", "--effort", "best"],
                      ["--boundary-flips", "--boundary", "slide", "-hausd", "0"],
                      ["--boundary-flips", "--boundary", "slide", "-hausd", "0.0%"]):
            self.assertEqual(self.run_cli("optimize", *words, "--print-options").stderr, "")
        # They are in the report, and the run goes on.
        source = self.put("in.mesh", cube(2))
        self.run_cli("optimize", source, "-o", self.path("out.mesh"), "-nosurf", "-ar", "60", "--report", self.path("r.json"))
        self.assertEqual(json.loads(self.read_bytes("r.json"))["warnings"],
                         ["--feature-angle 60 has no effect without --boundary slide"])

    def test_noinsert_with_every_effort(self):
        source = self.put("in.mesh", unflipped(cube(6, 0.25)))
        for effort in ("fast", "standard", "best"):
            self.run_cli("optimize", source, "-o", self.path("out.mesh"), "-noinsert", "--effort", effort, "--quiet")
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
                            (["--bogus"], "--bogus"),
                            (["--effort"], "--effort: ")):
            done = self.refused("optimize", source, "-o", self.path("out.mesh"), *words, said=["tetune: ", said,
                                "; see tetune optimize --help"])
            self.assertEqual(len(done.stderr.splitlines()), 1)

    def test_names_of_mmg_in_messages(self):
        source = self.put("in.mesh", cube(1))
        for words, said in ((["-ar", "200"], "--feature-angle 200 is out of range: it must be above 0 and at most 180 degrees"),
                            (["-nt", "-1"], "--threads -1 is out of range: it must be 0 to 4096")):
            self.refused("optimize", source, "-o", self.path("out.mesh"), *words, said=[said])

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
        self.assertEqual(complete("tetune", "optimize", "--only-below", "min_"), {"min_dihedral_deg="})
        self.assertLessEqual({m + "=" for m in cli_case.MEASURES}, complete("tetune", "optimize", "--target-quality", ""))
        self.assertEqual(complete("tetune", "info", "--min-quality", "scaled"), {"scaled_jacobian="})
        self.put("openfoam.toml", "")
        for command in ("optimize", "info", "move"):
            self.assertEqual(complete("tetune", command, "--criteria", "open"), {"openfoam", "openfoam.toml"})
        self.assertEqual(complete("tetune", "info", "--geometry-unit", "m"), {"mm", "m"})
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
        def complete(line):
            done = subprocess.run(["fish", "-c", f"source {script}; complete -C '{line}'"], capture_output=True, text=True,
                                  timeout=cli_case.HANG, cwd=self.folder, env={"HOME": str(self.folder), "PATH": "/usr/bin:/bin"})
            return {line.split()[0] for line in done.stdout.splitlines()}
        self.put("openfoam.toml", "")
        self.assertEqual(complete("tetune optimize --effort "), {"fast", "standard", "best"})
        self.assertEqual(complete("tetune optimize --only-below min_"), {"min_dihedral_deg="})
        self.assertEqual(complete("tetune optimize --criteria openfoam"), {"openfoam", "openfoam.toml"})

    def test_reference_of_the_options(self):
        """The page and the Python types that are generated from the table of options are up to date."""
        program = Path(cli_case.TETUNE).with_name("tetune_option_reference")
        if not program.is_file():
            self.skipTest("tetune_option_reference is not beside tetune")
        for kind, name in (("markdown", "docs/options.md"), ("python", "python/tetune/_options.py")):
            text = subprocess.run([program, kind], capture_output=True, text=True, timeout=cli_case.HANG, check=True).stdout
            self.assertEqual(text, (Path(__file__).resolve().parents[2] / name).read_text(), f"run: {program.name} {kind} > {name}")

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
