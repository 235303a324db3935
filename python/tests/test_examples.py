# SPDX-License-Identifier: Apache-2.0
"""The examples and what the documents show run, and do what they say."""

import re
import subprocess
import sys

import pytest

from meshes import ROOT, shaken_box

import tetune


def run(name, *needs, words=()):
    for package in needs:
        pytest.importorskip(package)
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "python" / name, *words], capture_output=True, text=True, timeout=250
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers(text):
    return [float(x) for x in re.findall(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?", text)]


def test_gmsh_in_memory():
    out = run("gmsh_in_memory.py", "gmsh").splitlines()
    before, after = numbers(out[1])
    assert after > before + 3
    before, after = numbers(out[2])
    assert after > before


def test_tetgen_pyvista():
    before, after = (numbers(line.split(maxsplit=1)[1]) for line in run("tetgen_pyvista.py", "tetgen", "pyvista").splitlines())
    assert after[1] > before[1] + 5  # degrees
    assert after[2] > before[2]  # smallest scaled Jacobian
    assert after[4] > before[4]  # mean


def test_mmgpy_pyvista(tmp_path):
    points, tets = shaken_box()
    tetune.write_mesh(str(tmp_path / "in.mesh"), tetune.TetMesh(points, tets))
    words = (tmp_path / "in.mesh", tmp_path / "out.vtk")
    before, after = numbers(run("mmgpy_pyvista.py", "pyvista", "meshio", words=words))
    assert after > before and (tmp_path / "out.vtk").is_file()


def test_moving_piston():
    lines = run("moving_piston.py").splitlines()
    assert len(lines) == 8
    assert numbers(lines[-1])[0] == 0.4 and numbers(lines[-1])[2] > 8  # degrees


def test_pressed_bar():
    lines = [numbers(line) for line in run("pressed_bar.py", "skfem").splitlines()]
    assert len(lines) == 10
    height, angle, mean, highest = lines[-1]
    assert height == 1 and angle > 8  # degrees
    assert abs(mean - lines[0][2]) < 0.02 * mean and highest < lines[0][3]


def test_poisson():
    before, after = (numbers(line) for line in run("poisson.py", "skfem").splitlines()[1:])
    assert after[1] < before[1] / 2  # condition number
    assert after[2] < 0.75 * before[2]  # iterations
    assert after[3] == pytest.approx(before[3], rel=0.01)


def test_readme(tmp_path, monkeypatch):
    pv = pytest.importorskip("pyvista")
    pytest.importorskip("meshio")
    monkeypatch.chdir(tmp_path)
    points, tets = shaken_box()
    tetune.write_mesh("in.mesh", tetune.TetMesh(points, tets))
    snippets = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S)
    assert len(snippets) >= 2
    for snippet in snippets:
        exec(compile(snippet, "README.md", "exec"), {"points": points, "tets": tets})
    out = pv.read("out.vtu")
    assert out.tetune.quality().dihedral_min > tetune.quality(points, tets).dihedral_min
