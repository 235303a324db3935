# SPDX-License-Identifier: Apache-2.0
"""Meshes that the tests make themselves."""

from itertools import product
from pathlib import Path

import numpy as np

import tetune

ROOT = Path(__file__).parents[2]
BRACKET = ROOT / "data" / "bracket.meshb"

# A cube in five tetrahedra, by the corners' numbers (binary: x + 2 y + 4 z), and the same mirrored.
FIVE = np.array([[0, 1, 2, 4], [3, 2, 1, 7], [5, 4, 7, 1], [6, 7, 4, 2], [1, 2, 4, 7]])


def shaken_box(nx=8, ny=4, nz=4, amount=0.55, seed=1):
    """Points and tetrahedra of a box of unit cubes; inner vertices are shaken, and still all volumes are positive."""
    index = lambda i, j, k: (k * (ny + 1) + j) * (nx + 1) + i
    points = np.array([(i, j, k) for k, j, i in product(range(nz + 1), range(ny + 1), range(nx + 1))], dtype=float)
    tets = []
    for k, j, i in product(range(nz), range(ny), range(nx)):
        mirror = (i + j + k) % 2
        corner = [index(i + (mirror ^ (c & 1)), j + (c >> 1 & 1), k + (c >> 2)) for c in range(8)]
        cell = np.array(corner)[FIVE]
        tets.append(cell[:, [0, 1, 3, 2]] if mirror else cell)
    tets = np.concatenate(tets)
    inner = np.all((points > 0) & (points < [nx, ny, nz]), axis=1)
    moves = np.random.default_rng(seed).uniform(-amount / 2, amount / 2, points.shape) * inner[:, None]
    while (bad := np.unique(tets[volumes(points + moves, tets) < 0.01])).size > 0:
        moves[bad] *= 0.5
    return points + moves, tets


def volumes(points, tets):
    a, b, c, d = np.moveaxis(np.asarray(points)[np.asarray(tets)], 1, 0)
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def smallest_dihedral(points, tets):
    """Of each tetrahedron, in degrees, straight from the normals of its faces."""
    p = np.asarray(points)[np.asarray(tets)]
    normals = []
    for f in range(4):
        a, b, c = (p[:, k] for k in range(4) if k != f)
        n = np.cross(b - a, c - a)
        n *= np.sign(np.einsum("ij,ij->i", n, a - p[:, f]))[:, None]
        normals.append(n / np.linalg.norm(n, axis=1)[:, None])
    angles = [
        180 - np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", normals[f], normals[g]), -1, 1)))
        for f in range(4)
        for g in range(f)
    ]
    return np.min(angles, axis=0)


def everything_of(value):
    """All that Python shows of an object of the module, as plain values."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tolist()
    if isinstance(value, (list, tuple)):
        return [everything_of(v) for v in value]
    if not type(value).__module__.startswith("tetune"):
        return value
    names = [n for n in dir(value) if not n.startswith("_") and not callable(getattr(value, n))]
    assert len(names) > 1
    return {n: everything_of(getattr(value, n)) for n in names}


def two_regions():
    points, tets = shaken_box(8, 4, 4)
    return points, tets, np.where(points[tets].mean(axis=1)[:, 0] > 4, 2, 1)


def interface_area(points, tets, tags):
    """Of the faces between regions 1 and 2."""
    faces = np.concatenate([np.delete(tets, f, axis=1) for f in range(4)])
    owner = np.tile(np.arange(len(tets)), 4)
    order = np.lexsort(np.sort(faces, axis=1).T)
    faces, owner = faces[order], owner[order]
    same = np.flatnonzero((np.sort(faces[1:], axis=1) == np.sort(faces[:-1], axis=1)).all(axis=1))
    between = same[tags[owner[same]] != tags[owner[same + 1]]]
    a, b, c = np.moveaxis(points[faces[between]], 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def inverted_pyramid():
    """A mesh with two pyramids beside it, and a target that pushes the tip of the second through its base."""
    points, tets = shaken_box(3, 3, 3)
    pyramid = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]])
    pyramids = len(points) + np.arange(10).reshape(2, 5)
    mesh = tetune.TetMesh(np.vstack([points, pyramid + [9, 0, 0], pyramid + [12, 0, 0]]), tets,
                          others=[("Quadrilaterals", pyramids[:, :4]), ("Pyramids", pyramids)])
    to = np.full_like(mesh.points, np.nan)
    to[-1] = [12.5, 0.5, -1]
    return mesh, to
