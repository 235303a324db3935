# SPDX-License-Identifier: Apache-2.0
import json
import os
import platform
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tetune
from meshes import shaken_box


def test_command_line(tmp_path):
    points, tets = shaken_box()
    tetune.write_mesh(str(tmp_path / "in.mesh"), tetune.TetMesh(points, tets))
    run = subprocess.run(
        [sys.executable, "-m", "tetune", "optimize", tmp_path / "in.mesh", "-o", tmp_path / "out.mesh"],
        capture_output=True, text=True, timeout=100,
    )
    assert run.returncode == 0, run.stderr
    out = tetune.read_mesh(str(tmp_path / "out.mesh"))
    r = tetune.optimize(points, tets)
    assert np.array_equal(out.points, r.mesh.points) and np.array_equal(out.tets, r.mesh.tets)


@pytest.mark.skipif(not (Path(tetune.__file__).parent / "lib" / "glibc-hwcaps").exists(), reason="built as one library")
def test_the_processor_decides_which_library_runs(tmp_path):
    points, tets = shaken_box()
    tetune.write_mesh(str(tmp_path / "in.mesh"), tetune.TetMesh(points, tets))

    def run(without=""):
        report = tmp_path / "report.json"
        subprocess.run(
            [sys.executable, "-m", "tetune", "optimize", "in.mesh", "-o", "out.meshb", "--report", report],
            env={**os.environ, "GLIBC_TUNABLES": f"glibc.cpu.hwcaps={without}"}, cwd=tmp_path, check=True, timeout=100,
        )
        return json.loads(report.read_text())["instructions"], (tmp_path / "out.meshb").read_bytes()

    flags = set(re.search(r"^flags\s*:(.*)$", Path("/proc/cpuinfo").read_text(), re.M)[1].split())
    level, result = run()
    if not {"avx2", "bmi2", "fma", "movbe"} <= flags or tuple(map(int, platform.libc_ver()[1].split("."))) < (2, 33):
        assert level == "x86-64"
        return
    has_v4 = (Path(tetune.__file__).parent / "lib" / "glibc-hwcaps" / "x86-64-v4").exists()
    runs_v4 = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"} <= flags
    assert level == ("x86-64-v4" if has_v4 and runs_v4 else "x86-64-v3")
    assert run("-AVX512F") == ("x86-64-v3", result)
    assert run("-AVX2") == ("x86-64", result)


def test_numpy_alone_is_enough():
    code = """
import sys
for name in ("meshio", "pyvista", "vtk", "rich", "plotly"):
    sys.modules[name] = None
sys.path.insert(0, sys.argv[1])
from meshes import shaken_box
import tetune
assert tetune.optimize(*shaken_box(2, 2, 2)).report.tets_after > 0
try:
    tetune.optimize(*shaken_box(2, 2, 2), progress=True)
except ImportError as error:
    assert "pip install rich" in str(error)
else:
    raise AssertionError("no error")
"""
    run = subprocess.run([sys.executable, "-c", code, os.path.dirname(__file__)], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
