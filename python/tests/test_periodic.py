# SPDX-License-Identifier: Apache-2.0
"""Periodic links of meshes."""

import numpy as np
import pytest

import tetune
from meshes import shaken_box


def test_faces_of_a_box_move_together():
    mesh = tetune.TetMesh(*shaken_box(4, 4, 4))
    mesh.link_box_faces("xyz")
    links = mesh.periodic
    assert [len(pairs) for pairs in links] == [25, 25, 25]
    result = tetune.optimize(mesh)
    assert result.report.periodic_vertices > 0
    points = result.mesh.points
    for axis, pairs in enumerate(result.mesh.periodic):
        assert (points[pairs[:, 0]] == points[pairs[:, 1]] + 4 * np.eye(3)[axis]).all()
    assert (points[links[0][:, 0]] != mesh.points[links[0][:, 0]]).any()


def test_a_map_file(tmp_path):
    mesh = tetune.TetMesh(*shaken_box(2, 2, 2))
    image, master = (int(np.flatnonzero((mesh.points == [x, 1, 1]).all(axis=1))[0]) for x in (2, 0))
    path = tmp_path / "pairs.txt"
    path.write_text(f"translation 2 0 0\n{image + 1} {master + 1}\n")
    mesh.read_periodic_map(path)
    assert mesh.periodic[0].tolist() == [[image, master]]
    with pytest.raises(ValueError, match="xyz"):
        mesh.link_box_faces("w")
