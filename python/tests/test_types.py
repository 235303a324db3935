# SPDX-License-Identifier: Apache-2.0
import subprocess
import sys

import pytest

from meshes import ROOT

USE = """
import meshio
import numpy as np
import pyvista as pv
from typing import assert_type
import tetune

points, tets = np.zeros((4, 3)), np.arange(4).reshape(1, 4)
assert_type(tetune.optimize(points, tets, effort="best", targets={"mean_ratio": 0.2}), tetune.Result[tetune.TetMesh])
assert_type(tetune.optimize(meshio.Mesh(points, []), tags="a").report.sweeps[0].energy_before, float)
assert_type(tetune.optimize(pv.UnstructuredGrid()).mesh, pv.UnstructuredGrid)
tetune.optimize(points, tets, effort="bets")  # type: ignore[call-overload]
tetune.optimize(points, tets, iterations=3)  # type: ignore[call-overload]
"""


def test_mypy(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "use.py").write_text(USE)
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--config-file", ROOT / "pyproject.toml", "-p", "tetune", "-m", "use"],
        capture_output=True, text=True, cwd=tmp_path,
    )
    assert run.returncode == 0, run.stdout + run.stderr
