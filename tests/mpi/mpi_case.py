# SPDX-License-Identifier: Apache-2.0
"""Shared by the tests of tetune-mpi: running it on some ranks.

Run a file of tests:  python3 test_contract.py path/to/tetune-mpi path/to/tetune bracket.meshb [names of tests]
"""

import json
import os
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cli"))
import cli_case  # noqa: E402

PROGRAM = TETUNE = BRACKET = ""


def command(ranks, *args):
    return ["mpiexec", "--allow-run-as-root", "--oversubscribe", "--mca", "btl", "self,vader", "--mca",
            "btl_vader_single_copy_mechanism", "none", "-n", str(ranks), PROGRAM, *map(str, args)]


class MpiTest(cli_case.CliTest):
    def mpi(self, ranks, source, out, *args, code=0):
        """Replaces `out`. The exit code of mpiexec is that of the ranks."""
        args = (source, "-o", out, *args)
        done = subprocess.run(
            command(ranks, *args), capture_output=True, text=True, timeout=cli_case.HANG,
            env={**os.environ, "OMPI_MCA_rmaps_base_oversubscribe": "1"})
        self.assertEqual(done.returncode, code, f"{args}\n{done.stdout}\n{done.stderr}")
        return done

    def info(self, mesh):
        done = subprocess.run([TETUNE, "info", "--json", mesh], capture_output=True, text=True, check=False)
        return json.loads(done.stdout)

    def compare(self, before, after):
        done = subprocess.run([TETUNE, "compare", "--json", before, after], capture_output=True, text=True, check=False)
        return json.loads(done.stdout)

    def on_one_machine(self, mesh, *args):
        out = self.path("one_machine.meshb")
        subprocess.run([TETUNE, "optimize", "--quiet", mesh, "-o", out, *args], check=True)
        return self.info(out)


def main(doc):
    global PROGRAM, TETUNE, BRACKET
    if len(sys.argv) < 4:
        sys.exit(doc)
    PROGRAM, TETUNE, BRACKET = (os.path.abspath(sys.argv.pop(1)) for _ in range(3))
    unittest.main(verbosity=1)
