# SPDX-License-Identifier: Apache-2.0
"""Where the system sets the limits: full disks, folders that cannot be written, pipes without a reader, a process that
is killed, two that write one file. Run: see cli_case.py."""

import os
import random
import shlex
import signal
import subprocess
import time
from pathlib import Path

import cli_case
from cli_case import CliTest, Mesh, cube

OLD = b"an old file"


def vtk_endings():
    return ["vtu", "vtk", "e"] if cli_case.has_plugin("tetune-vtk") else []


@cli_case.needs_mount
class Mounts(CliTest):
    def on_disk(self, options, output, size="40k"):
        """Exit code, message, and what is then in a file system of its own, where there was an old file."""
        (self.folder / "disk").mkdir(exist_ok=True)
        name = f"disk/{output}"
        words = shlex.join([cli_case.TETUNE, "optimize", "in.mesh", "-o", name, "--max-iterations", "1", "--threads", "1"])
        script = (f"mount -t tmpfs -o size={size} none disk && printf '{OLD.decode()}' > {name} && mount -o remount,{options} disk\n"
                  f"{words} > log 2>&1; echo $? > code; ls disk > names; cp {name} left")
        subprocess.run(["unshare", "-rm", "sh", "-c", script], cwd=self.folder, check=True, timeout=cli_case.HANG)
        names = (self.folder / "names").read_text().split()
        return int((self.folder / "code").read_text()), (self.folder / "log").read_text(), names, self.read_bytes("left")

    def test_a_full_disk(self):
        self.put("in.mesh", cube(12))
        for ending in ["mesh", "meshb", "msh", "ele", "inp", "bdf", "unv", *vtk_endings()]:
            with self.subTest(ending):
                code, log, names, left = self.on_disk("rw", f"out.{ending}")
                self.assertEqual(code, 2, log)
                self.assertIn(f"disk/out.{'node' if ending == 'ele' else ending}", log)
                self.assertEqual((names, left), ([f"out.{ending}"], OLD))
                # The Exodus library has a number for it alone.
                if ending != "e":
                    self.assertRegex(log, "(?i)no space left")

    @cli_case.needs_vtk
    def test_a_disk_that_lacks_a_part_of_an_exodus_file(self):
        """The library writes the last part where it closes the file."""
        self.put("in.mesh", cube(3))
        self.run_cli("convert", self.path("in.mesh"), self.path("whole.e"))
        whole = len(self.read_bytes("whole.e"))
        for kilobytes in range(8, whole // 1024 + 8, 4):
            code, log, names, left = self.on_disk("rw", "out.e", f"{kilobytes}k")
            self.assertEqual(names, ["out.e"])
            if code == 0:
                self.assertEqual(len(left), whole, f"{kilobytes} kB")
            else:
                self.assertEqual((code, left), (2, OLD), log)
        self.assertEqual(code, 0)

    def test_a_folder_that_cannot_be_written(self):
        self.put("in.mesh", cube(2))
        code, log, names, left = self.on_disk("ro", "out.mesh")
        self.assertEqual(code, 2, log)
        self.assertIn("disk/out.mesh: no permission to write in disk", log)
        self.assertEqual((names, left), (["out.mesh"], OLD))


class Streams(CliTest):
    def shell(self, script, **more):
        return subprocess.run(["bash", "-c", script, "sh", cli_case.TETUNE], cwd=self.folder, capture_output=True,
                              text=True, timeout=cli_case.HANG, **more)

    def setUp(self):
        super().setUp()
        self.put("in.mesh", cube(8))

    def test_a_full_disk_behind_the_standard_output(self):
        done = self.shell('"$1" optimize in.mesh - --max-iterations 1 > /dev/full')
        self.assertEqual((done.returncode, done.stderr), (2, "tetune: cannot write standard output: No space left on device\n"))
        for words in ("info in.mesh", "info --json in.mesh", "compare in.mesh in.mesh", "man", "optimize --help",
                      "optimize --print-options in.mesh -", "optimize in.mesh --dry-run"):
            done = self.shell(f'"$1" {words} > /dev/full')
            self.assertEqual(done.returncode, 2, words)
            self.assertIn("No space left on device", done.stderr)
        # The mesh is written, and only its table is lost.
        done = self.shell('"$1" optimize in.mesh out.mesh --max-iterations 1 > /dev/full')
        self.assertEqual(done.returncode, 0)
        self.assertIn("No space left on device", done.stderr)
        self.assertGreater(min(Mesh.read(self.path("out.mesh")).volumes()), 0)

    def test_messages_that_cannot_be_written(self):
        for words, code in (("optimize in.mesh out.mesh --progress json", 0), ("optimize absent.mesh out.mesh", 2),
                            ("info absent.mesh", 2), ("optimize in.mesh --bogus", 2)):
            self.assertEqual(self.shell(f'"$1" {words} 2> /dev/full').returncode, code, words)

    def test_closed_streams(self):
        """Messages must not get into files that are opened in place of the closed streams."""
        done = self.shell('"$1" optimize in.mesh out.mesh --max-iterations 1 --progress json <&- >&- 2>&-')
        self.assertEqual(done.returncode, 0)
        self.assertGreater(min(Mesh.read(self.path("out.mesh")).volumes()), 0)
        done = self.shell('"$1" optimize in.mesh - --max-iterations 1 >&-')
        self.assertEqual(done.returncode, 2)
        self.assertIn("cannot write standard output", done.stderr)

    def test_a_pipe_without_a_reader(self):
        """It ends by the signal, as programs do; where that is ignored it is an error."""
        for trap, code in (("", 128 + signal.SIGPIPE), ("trap '' PIPE;", 2)):
            done = self.shell(f'{trap} "$1" optimize in.mesh - --max-iterations 1 | head -c 10; exit ${{PIPESTATUS[0]}}',
                              restore_signals=True)
            self.assertEqual((done.returncode, done.stdout), (code, "MeshVersio"))
            self.assertEqual("Broken pipe" in done.stderr, code == 2)
        self.assertEqual(self.files(), ["in.mesh"])


class Files(CliTest):
    def test_a_symbolic_link_is_replaced_and_what_it_names_is_left(self):
        self.put("in.mesh", cube(3))
        Path(self.path("target.mesh")).write_bytes(OLD)
        os.symlink("target.mesh", self.path("out.mesh"))
        os.symlink("nowhere.mesh", self.path("dangling.mesh"))
        for out in ("out.mesh", "dangling.mesh"):
            self.run_cli("optimize", self.path("in.mesh"), "-o", self.path(out))
            self.assertFalse(os.path.islink(self.path(out)))
            self.assertGreater(min(Mesh.read(self.path(out)).volumes()), 0)
        self.assertEqual(self.read_bytes("target.mesh"), OLD)
        self.assertEqual(self.files(), ["dangling.mesh", "in.mesh", "out.mesh", "target.mesh"])

    def test_two_processes_with_one_output(self):
        """The file is that of one of them, whole."""
        sources = [self.put("a.mesh", cube(6, seed=1)), self.put("b.mesh", cube(6, seed=2))]
        results = set()
        for source in sources:
            self.run_cli("optimize", source, "-o", self.path("out.mesh"))
            results.add(self.read_bytes("out.mesh"))
        for _ in range(5):
            runs = [subprocess.Popen([cli_case.TETUNE, "optimize", s, "-o", self.path("out.mesh"), "--quiet"]) for s in sources]
            self.assertEqual([run.wait(timeout=cli_case.HANG) for run in runs], [0, 0])
            self.assertIn(self.read_bytes("out.mesh"), results)
        self.assertEqual(self.files(), ["a.mesh", "b.mesh", "out.mesh"])

    def test_killed_at_any_moment_of_writing(self):
        """The output is the old file or the whole new one."""
        self.put("in.mesh", cube(14))
        rng = random.Random(1)
        for ending in ["mesh", "meshb", "msh"] + vtk_endings()[:1]:
            out = f"out.{ending}"
            words = [cli_case.TETUNE, "optimize", self.path("in.mesh"), "-o", self.path(out), "--max-iterations", "1", "--progress",
                     "json", "--threads", "1"]
            start = time.monotonic()
            with subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as process:
                for line in process.stderr:
                    if b'"writing"' in line:
                        break
                    start = time.monotonic()
                process.stderr.read()
            self.assertEqual(process.returncode, 0)
            seconds = time.monotonic() - start
            whole = self.read_bytes(out)

            def write_for_a_while(process):
                for line in process.stderr:
                    if b'"writing"' in line:
                        break
                time.sleep(1.2 * rng.random() * seconds)

            for _ in range(8):
                Path(self.path(out)).write_bytes(OLD)
                cli_case.start_and_kill(words, write_for_a_while)
                left = self.read_bytes(out)
                self.assertTrue(left == OLD or len(left) == len(whole), f"{len(left)} bytes of {len(whole)}")
                if left != OLD:
                    self.run_cli("info", "--check", self.path(out))


if __name__ == "__main__":
    cli_case.main(__doc__)
