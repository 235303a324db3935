#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the eight meshes that tests/bits/run compares:  tests/bits/meshes.py FOLDER"""

import math
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cli"))
from cli_case import Mesh, bent, cube, unflipped  # noqa: E402


def mapped(mesh, place):
    """The mesh with other positions of its vertices."""
    return Mesh([place(*p) for p in mesh.points], mesh.tets, mesh.point_tags, mesh.tet_tags)


def ball(x, y, z):
    """A point of the unit cube in a rounder body: halfway to where shells of cubes become spheres."""
    at = [2 * c - 1 for c in (x, y, z)]
    norm = math.sqrt(sum(c * c for c in at))
    return tuple(c * (0.5 + 0.5 * max(map(abs, at)) / norm) if norm > 0 else 0.0 for c in at)


def two_regions(mesh):
    """Two materials with a curved interface, in elements."""
    tags = []
    for tet in mesh.tets:
        x, y = (sum(mesh.points[v][k] for v in tet) / 4 for k in (0, 1))
        tags.append(1 if x + 0.2 * math.sin(4 * y) < 0.5 else 2)
    return Mesh(mesh.points, mesh.tets, mesh.point_tags, tags)


def slivers(n, seed):
    """A cube, many of whose elements are flat."""
    rng = random.Random(seed)
    mesh = cube(n, 0.0)
    points = [tuple(c + (0.62 / n * rng.uniform(-1, 1) ** 3 if 0 < c < 1 else 0.0) for c in p) for p in mesh.points]
    bad = {0}
    while bad:
        volumes = Mesh(points, mesh.tets).volumes()
        bad = {v for tet, volume in zip(mesh.tets, volumes) if volume <= 1e-7 for v in tet}
        points = [mesh.points[v] if v in bad else p for v, p in enumerate(points)]
    return Mesh(points, mesh.tets, mesh.point_tags, mesh.tet_tags)


def meshes():
    yield "cube", cube(8, 0.2, 1)
    yield "waves", bent(cube(8, 0.25, 2))
    yield "unflipped", unflipped(cube(7, 0.25, 3))
    yield "regions", two_regions(cube(8, 0.25, 4))
    yield "ball", mapped(cube(8, 0.15, 5), ball)
    yield "layer", mapped(cube(9, 0.22, 6), lambda x, y, z: (x, y, z / 8))
    yield "far", mapped(cube(7, 0.25, 7), lambda x, y, z: (1e5 + x, y - 1e5, z + 3e4))
    yield "slivers", slivers(8, 8)


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for number, (name, mesh) in enumerate(meshes()):
        # Half of the files have the line ends of Windows.
        (folder / f"{name}.mesh").write_bytes(mesh.text().replace("\n", "\r\n" if number % 2 else "\n").encode())
