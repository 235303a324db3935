# SPDX-License-Identifier: Apache-2.0
"""Plugins, seen from the command line: one that is missing or fails is an error with exit code 2. Run: see cli_case.py."""

import os
import shutil
import signal
import time
from pathlib import Path

import cli_case
from format_case import FormatTest


class Plugins(FormatTest):
    def setUp(self):
        super().setUp()
        if Path(cli_case.TETUNE).read_bytes().startswith(b"#!"):
            self.skipTest("an emulator starts the program from the place where it was built")

    def installation(self, plugin=None):
        """A copy of the program alone, with this text as its VTK plugin."""
        (self.folder / "prefix/bin").mkdir(parents=True)
        program = Path(shutil.copy(cli_case.TETUNE, self.folder / "prefix/bin/tetune"))
        if plugin is not None:
            self.executable(self.folder / "prefix/libexec/tetune/tetune-vtk", plugin)
        return str(program)

    def executable(self, path, text):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("#!/bin/sh\n" + text + "\n")
        path.chmod(0o755)

    def expect_refused(self, program, *parts, env=None):
        (self.folder / "out.vtu").write_text("old")
        done = self.run_tetune("optimize", "cube.mesh", "-o", "out.vtu", program=program, env=env)
        self.assertEqual(done.returncode, 2, done.stderr)
        for part in ("out.vtu",) + parts:
            self.assertIn(part, done.stderr)
        self.assertEqual((self.folder / "out.vtu").read_text(), "old")
        self.assertEqual(list(self.folder.glob("*.tmp*")), [])

    def test_a_missing_plugin_is_named_with_its_package(self):
        self.expect_refused(self.installation(), "install VTK with its headers")

    def test_plugins_are_taken_from_the_installation_alone(self):
        program = self.installation()
        for folder in (".", "libexec/tetune", "bin/../libexec/tetune", "path"):
            self.executable(self.folder / folder / "tetune-vtk", f"touch {self.folder}/ran")
        env = dict(os.environ, PATH=f"{self.folder}/path:{os.environ['PATH']}", LD_LIBRARY_PATH=str(self.folder))
        self.expect_refused(program, "install VTK with its headers", env=env)
        self.assertFalse((self.folder / "ran").exists())

    def test_a_missing_library_is_named_with_its_package(self):
        self.expect_refused(self.installation("exit 127"), "library is missing; install VTK")

    def test_a_crash_of_the_library_is_an_error(self):
        self.expect_refused(self.installation("kill -SEGV $$"), "VTK failed")

    def test_no_answer_is_an_error(self):
        self.expect_refused(self.installation("true"), "no answer")

    def test_a_bad_answer_is_an_error(self):
        self.expect_refused(self.installation("head -c 200 /dev/zero >/proc/self/fd/3"), "another build")

    def test_a_plugin_that_starts_after_the_end_of_tetune_writes_nothing(self):
        real = Path(cli_case.TETUNE).resolve().parents[1] / "libexec/tetune/tetune-vtk"
        if not real.is_file():
            self.skipTest("built without VTK")
        pid = self.folder / "pid"
        script = f"[ $1 = write ] || exec {real} \"$@\"\necho $$ >{pid}.new\nmv {pid}.new {pid}\nparent=$PPID\n" \
                 f"kill -KILL $parent\nwhile kill -0 $parent; do sleep 0.01; done\nexec {real} \"$@\""
        done = self.run_tetune("convert", "cube.mesh", "out.vtu", program=self.installation(script))
        self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
        end = time.monotonic() + cli_case.HANG
        command = Path(f"/proc/{pid.read_text().strip()}/cmdline")  # empty of one that has ended
        while command.exists() and command.read_bytes() and time.monotonic() < end:
            time.sleep(0.01)
        self.assertEqual(list(self.folder.glob("out.vtu*")), [])

    def test_a_medit_run_starts_no_plugin(self):
        program = self.installation(f"touch {self.folder}/ran")
        done = self.run_tetune("optimize", "cube.mesh", "-o", "out.mesh", program=program)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertFalse((self.folder / "ran").exists())


if __name__ == "__main__":
    cli_case.main(__doc__)
