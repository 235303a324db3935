# SPDX-License-Identifier: Apache-2.0
"""Names and line ends of files that differ between systems.   python3 test_paths.py path/to/tetune"""

import os
import shutil
import signal
import subprocess
import time

import cli_case
from cli_case import CliTest, bent, cube, main


class Paths(CliTest):
    def setUp(self):
        super().setUp()
        self.plain = self.put("plain.mesh", cube(4))
        self.run_cli("optimize", self.plain, "-o", self.path("expected.mesh"), "--quiet")
        self.expected = self.read_bytes("expected.mesh")

    def test_spaces_and_umlauts(self):
        folder = self.folder / "Maße und Ö"
        folder.mkdir()
        shutil.copy(self.plain, folder / "Bügel 1.mesh")
        self.run_cli("optimize", folder / "Bügel 1.mesh", "-o", folder / "größer {}.mesh", "--report",
                     folder / "Bericht ä.json")
        self.assertEqual((folder / "größer Bügel 1.mesh").read_bytes(), self.expected)
        self.assertIn("tetrahedra", (folder / "Bericht ä.json").read_text(encoding="utf-8"))
        done = self.run_cli("info", folder / "größer Bügel 1.mesh")
        self.assertIn("tetrahedra", done.stdout)
        self.refused("info", folder / "fehlt ü.mesh", said=["fehlt ü.mesh"])

    def test_long_paths(self):
        folder = self.folder
        while len(str(folder)) < 300:
            folder = folder / ("long" * 10)
        folder.mkdir(parents=True)
        shutil.copy(self.plain, folder / "in.mesh")
        for _ in range(2):
            self.run_cli("optimize", folder / "in.mesh", "-o", folder / "out.mesh", "--quiet")
            self.assertEqual((folder / "out.mesh").read_bytes(), self.expected)
        self.assertEqual(sorted(os.listdir(folder)), ["in.mesh", "out.mesh"])

    def test_an_existing_file_is_replaced(self):
        self.put("out.mesh", "old")
        self.run_cli("optimize", self.plain, "-o", self.path("out.mesh"), "--quiet")
        self.assertEqual(self.read_bytes("out.mesh"), self.expected)
        self.run_cli("optimize", self.path("out.mesh"), "-o", self.path("out.mesh"), "--quiet")
        self.assertEqual(self.files(), ["expected.mesh", "out.mesh", "plain.mesh"])

    def test_line_ends_of_windows(self):
        mesh = bent(cube(4))
        for ending in (".mesh", ".inp", ".ele"):
            with self.subTest(ending):
                self.put("source.mesh", mesh)
                self.run_cli("convert", self.path("source.mesh"), "-o", self.path("lf" + ending))
                for file in self.folder.glob("lf.*"):
                    (self.folder / file.name.replace("lf", "crlf")).write_bytes(
                        file.read_bytes().replace(b"\n", b"\r\n"))
                for name in ("lf", "crlf"):
                    self.run_cli("optimize", self.path(name + ending), "-o", self.path(name + "-out.mesh"), "--quiet")
                self.assertEqual(self.read_bytes("lf-out.mesh"), self.read_bytes("crlf-out.mesh"))
                for file in self.folder.glob("*lf.*"):
                    file.unlink()

    def test_written_text_has_no_carriage_returns(self):
        self.assertNotIn(b"\r", self.expected)
        done = subprocess.run([cli_case.TETUNE, "optimize", self.plain, "-o", "-", "--quiet"], capture_output=True,
                              timeout=cli_case.HANG, check=True)
        self.assertEqual(done.stdout, self.expected)

    def test_an_interrupted_run_writes_a_mesh_or_nothing(self):
        self.put("large.mesh", cube(24))
        process = subprocess.Popen([cli_case.TETUNE, "optimize", self.path("large.mesh"), "-o", self.path("out.mesh"),
                                    "--effort", "best", "--progress", "json"], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE)
        for line in process.stderr:
            if b'"progress"' in line:
                break
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        process.stderr.read()
        code = process.wait(cli_case.HANG)
        process.stderr.close()
        self.assertEqual((code, (self.folder / "out.mesh").exists()), (1, True))
        self.run_cli("info", self.path("out.mesh"))


if __name__ == "__main__":
    main(__doc__)
