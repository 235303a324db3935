# SPDX-License-Identifier: Apache-2.0
"""MFEM's miniapp mesh-optimizer (TMOP, the target-matrix optimization paradigm), as the package `mfem` of PyPI brings it: vertices
move under a shape metric while the surface and the connectivity stay."""

import importlib.util
import pathlib
import subprocess
import tempfile

import numpy as np

SHAPE, UNTANGLING = 303, 313  # the metrics' numbers


def program():
    """The path of the program, or None without the package."""
    found = importlib.util.find_spec("mfem")
    if found is None:
        return None
    path = pathlib.Path(found.origin).parent / "external/ser/miniapps/mesh-optimizer"
    return path if path.is_file() else None


def optimize(points, tets, faces, metric, timeout=None):
    """Positions after mesh-optimizer with a fixed boundary: at most 20 steps of Newton's method. Raises subprocess.SubprocessError
    if it fails."""
    with tempfile.TemporaryDirectory() as folder:
        _write(pathlib.Path(folder) / "in.mesh", points, tets, faces)
        words = [program(), "-m", "in.mesh", "-o", "1", "-mid", str(metric), "-tid", "1", "-fix-bnd", "-no-vis", "-qo", "2", "-ni", "20",
                 "-rtol", "1e-4", "-ls", "3", "-li", "50", *(["-fd"] if metric == UNTANGLING else [])]
        subprocess.run(words, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=timeout, check=True)
        return _read_nodes(pathlib.Path(folder) / "optimized.mesh", len(points))


def _write(path, points, tets, faces):
    with open(path, "w") as file:
        file.write(f"MFEM mesh v1.0\n\ndimension\n3\n\nelements\n{len(tets)}\n")
        np.savetxt(file, np.hstack([np.tile([1, 4], (len(tets), 1)), tets]), fmt="%d")
        file.write(f"\nboundary\n{len(faces)}\n")
        np.savetxt(file, np.hstack([np.tile([1, 2], (len(faces), 1)), faces]), fmt="%d")
        file.write(f"\nvertices\n{len(points)}\n3\n")
        np.savetxt(file, points, fmt="%.17g")


def _read_nodes(path, count):
    """The positions of the vertices, which are stored as the values of a finite element function, by component."""
    text = path.read_text()
    head, values = text[text.index("\nnodes\n"):].split("Ordering:", 1)
    by_vertex = values.split(None, 1)[0] == "1"
    numbers = np.array(values.split()[1:], dtype=float)
    assert len(numbers) == 3 * count, head
    return numbers.reshape(count, 3) if by_vertex else numbers.reshape(3, count).T
