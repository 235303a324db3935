# SPDX-License-Identifier: Apache-2.0
"""Files of tetune-mpi: replaced as by tetune."""

import os
import subprocess
from pathlib import Path

import mpi_case
from mpi_case import MpiTest, cli_case


class Files(MpiTest):
    def writes_hdf5(self):
        done = subprocess.run([mpi_case.PROGRAM, mpi_case.BRACKET, "-o", self.path("trial.h5"), "--effort", "fast"],
                              capture_output=True, text=True, check=False)
        return "built without HDF5" not in done.stderr

    def test_files_that_an_earlier_run_has_left(self):
        source = self.put("in.mesh", cli_case.cube(4))
        out = self.path("out.meshb")
        self.mpi(2, source, out, "--effort", "fast")
        expected = Path(out).read_bytes()
        left = Path(out + ".tetune-mpi.tmp")
        left.write_bytes(b"left" * 100_000)
        self.mpi(2, source, out, "--effort", "fast")
        self.assertEqual(Path(out).read_bytes(), expected)
        self.assertEqual(left.stat().st_size, 400_000)
        self.assertEqual(self.files(), ["in.mesh", "out.meshb", left.name])

    def test_permissions_are_kept(self):
        endings = ["meshb", "mesh"] + ["h5"] * self.writes_hdf5()
        for ending in endings:
            out = self.put(f"out.{ending}", "old")
            for mode in (0o640, 0o604):
                with self.subTest(ending=ending, mode=mode):
                    os.chmod(out, mode)
                    self.mpi(2, mpi_case.BRACKET, out, "--effort", "fast")
                    self.assertNotEqual(Path(out).read_bytes(), b"old")
                    self.assertEqual(os.stat(out).st_mode & 0o777, mode)

    def test_the_mesh_is_written_and_the_report_is_not(self):
        report = self.path("long" * 75 + ".json")
        for ranks in (1, 3):
            out = self.put("out.meshb", "old")
            done = self.mpi(ranks, mpi_case.BRACKET, out, "--effort", "fast", "--report", report, code=1)
            self.assertIn("; the mesh was written", done.stderr)
            self.assertIn("dihedral min", done.stdout)
            self.assertTrue(self.info(out)["validity"]["valid"])
            self.assertEqual(self.files(), ["out.meshb"])


mpi_case.main(__doc__)
