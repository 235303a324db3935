# SPDX-License-Identifier: Apache-2.0
"""The shapes with many corners: curved or carved surfaces of many small triangles. `edge` is about how long theirs are."""

import math
import random

import numpy as np

from implicit import ball, box, capsule, check_closed, common, cut, disc, length, split, step, triangulate, union
from surface import from_triangles


def closed(points, triangles):
    check_closed(triangles)
    return from_triangles(points, triangles)


def block(edge):
    """A block, a fine relief carved in its top and sides; its edges are straight."""
    size = np.array([2.0, 1.4, 1.0])
    cells = np.maximum(np.round(size / edge).astype(int), 4)
    index, quads = {}, []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, cells[axis]):
            for i in range(cells[u]):
                for j in range(cells[v]):
                    quad = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        at = [0, 0, 0]
                        at[axis], at[u], at[v] = end, i + di, j + dj
                        quad.append(index.setdefault(tuple(at), len(index)))
                    quads.append(quad if end else quad[::-1])
    lattice = np.array(list(index))
    x, y, z = (lattice / cells).T
    points = lattice / cells * size
    fade = [step(0, 0.12 / s, c) * step(0, 0.12 / s, 1 - c) for s, c in zip(size, (x, y, z))]
    px, py, pz = points.T
    rings = np.cos(14 * length(px - 1, py - 0.7)) * np.exp(-1.2 * length(px - 1, py - 0.7))
    depth_top = 0.06 * rings + 0.03 * np.sin(11 * px) * np.sin(11 * py)
    points[:, 2] += np.where(lattice[:, 2] == cells[2], fade[0] * fade[1] * depth_top, 0)
    for axis, other in ((0, 1), (1, 0)):
        depth = 0.035 * np.sin(9 * points[:, other] + 1) * np.sin(12 * pz)
        out = np.where(lattice[:, axis] == cells[axis], 1, np.where(lattice[:, axis] == 0, -1, 0))
        points[:, axis] += out * fade[other] * fade[2] * depth
    return closed(points, split(points, np.array(quads)))


def ghost(edge):
    """A draped bell with two arms, hollow from below, its hem wavy, two eyes, and a mouth that opens into the hollow."""
    def field(p):
        x, y, z = p.T
        angle, drape = np.arctan2(y, x), step(0.1, 0.4, length(x, y))
        wide = 0.16 * step(0.4, -0.75, z) + 0.05 * step(0.3, -0.75, z) * drape * np.cos(7 * angle)
        f = capsule(p, (0, 0, -1.6), (0, 0, 0.5), 0.5) - wide
        for side in (-1, 1):
            f = union(f, capsule(p, (side * 0.4, -0.1, 0.2), (side * 0.78, -0.35, 0.3), 0.14, 0.1), 0.15)
            f = cut(f, ball(p, (side * 0.18, -0.5, 0.55), 0.11), 0.05)
        f = cut(f, capsule(p, (0, 0, -1.6), (0, 0, 0.0), 0.29) - wide, 0.06)
        f = cut(f, capsule(p, (0, -0.2, 0.08), (0, -0.8, 0.08), 0.1), 0.06)
        return common(f, 0.06 * drape * np.cos(5 * angle + 0.5) - 0.75 - z, 0.06)

    return closed(*triangulate(field, (-1.0, -0.9, -0.95), (1.0, 0.9, 1.1), edge))


def die(edge):
    """A cube with round edges and 21 dimples."""
    a = 0.48
    cross = [(-a, -a), (a, a), (-a, a), (a, -a)]
    dimples = {1: [(0, 0)], 2: cross[:2], 3: [(0, 0), *cross[:2]], 4: cross, 5: [(0, 0), *cross],
               6: [*cross, (-a, 0), (a, 0)]}
    centers = []
    for axis, number in enumerate((1, 2, 3)):
        for sign, dots in ((1, number), (-1, 7 - number)):
            for u, v in dimples[dots]:
                centers.append(np.roll([sign * 1.06, u, v], axis))

    def field(p):
        pit = np.min([ball(p, c, 0.2) for c in centers], axis=0)
        return cut(box(p, (0, 0, 0), (1, 1, 1), 0.25), pit, 0.05)

    return closed(*triangulate(field, (-1.3, -1.3, -1.3), (1.3, 1.3, 1.3), edge))


def falcon(edge):
    """A plated saucer with two prongs, a side cabin on a tube, a dish on a stem, turrets and vents."""
    thick = 0.24
    radius = (1 + thick * thick) / (2 * thick)

    def field(p):
        x, y, _ = p.T
        f = common(ball(p, (0, 0, thick - radius), radius), ball(p, (0, 0, radius - thick), radius), 0.05)
        f -= 0.008 * np.tanh(3 * np.sin(24 * x) * np.sin(24 * y))
        f = union(f, disc(p, (0, 0, 0), 1.0, 0.06, 0.03), 0.03)
        for side in (-1, 1):
            f = union(f, box(p, (side * 0.3, 1.05, 0), (0.17, 0.5, 0.07), 0.03), 0.05)
            f = union(f, capsule(p, (0, 0, 0), (0, 0, side * 0.3), 0.11), 0.04)
            f = cut(f, box(p, (side * 0.3, 1.2, 0.09), (0.09, 0.2, 0.05), 0.02), 0.02)
        f = union(f, capsule(p, (0.7, 0.4, 0), (1.14, 0.6, 0), 0.09), 0.05)
        f = union(f, capsule(p, (1.14, 0.55, 0), (1.14, 0.9, 0), 0.13, 0.09), 0.04)
        f = union(f, capsule(p, (-0.4, 0.35, 0), (-0.4, 0.35, 0.36), 0.08), 0.04)
        dish = cut(disc(p, (-0.4, 0.35, 0.39), 0.24, 0.07, 0.04), ball(p, (-0.4, 0.35, 0.86), 0.43), 0.03)
        f = union(f, dish, 0.04)
        for k in range(6):
            turn = math.pi * (1.25 + 0.1 * k)
            f = cut(f, ball(p, (0.7 * math.cos(turn), 0.7 * math.sin(turn), 0.14), 0.065), 0.03)
        return f

    return closed(*triangulate(field, (-1.15, -1.15, -0.55), (1.35, 1.7, 0.6), edge))


def world(edge):
    """A globe with raised continents and mountains."""
    points, triangles = sphere(max(round(1.107 / edge), 4))
    rng = random.Random(2022)

    def waves(frequencies):
        total = 0
        for frequency in frequencies:
            direction = np.array([rng.uniform(-1, 1) for _ in range(3)])
            total += np.sin(points @ direction * frequency / np.linalg.norm(direction) + rng.uniform(0, 6))
        return total

    land = np.tanh(1.5 * waves((2, 3, 3, 4, 4, 5, 6, 7, 9, 11)))
    radius = 1 + 0.02 * land + 0.006 * step(0.3, 1, land) * waves((15, 17, 19, 21, 23, 26))
    return closed(points * radius[:, None], triangles)


def sphere(n):
    """The unit sphere, each face of an icosahedron in n * n triangles."""
    t = (1 + math.sqrt(5)) / 2
    corner = np.array([(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t),
                       (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)])
    near = [{b for b in range(12) if b != a and np.linalg.norm(corner[a] - corner[b]) < 2.1} for a in range(12)]
    faces = [(a, b, c) for a in range(12) for b in near[a] for c in near[a] & near[b] if a < b < c]
    index, triangles = {}, []
    for face in faces:
        if np.linalg.det(corner[list(face)]) < 0:
            face = face[::-1]

        def at(i, j):
            parts = sorted((v, w) for v, w in zip(face, (n - i - j, i, j)) if w)
            return index.setdefault(tuple(parts), len(index))

        for i in range(n):
            for j in range(n - i):
                triangles.append((at(i, j), at(i + 1, j), at(i, j + 1)))
                if i + j < n - 1:
                    triangles.append((at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))
    points = np.array([sum(corner[v] * w for v, w in parts) for parts in index])
    return points / np.linalg.norm(points, axis=1)[:, None], np.array(triangles)


def pot(edge):
    """A hollow pot: patterned belly, rim, foot, a spout that pours, a handle."""
    squash = np.array([1, 1, 1.15])

    def field(p):
        x, y, z = p.T
        f = ball(p * squash, (0, 0, 0), 1.0)
        f -= 0.012 * step(0.55, 0.35, np.abs(z)) * np.sin(18 * np.arctan2(y, x)) * np.sin(16 * z)
        f = union(f, disc(p, (0, 0, -0.86), 0.55, 0.09, 0.05), 0.08)
        f = union(f, capsule(p, (0, -0.8, -0.25), (0, -1.35, 0.15), 0.29, 0.24), 0.12)
        f = union(f, capsule(p, (0, -1.35, 0.15), (0, -1.6, 0.6), 0.24, 0.22), 0.08)
        f = union(f, length(length(y - 1.0, z - 0.05) - 0.42, x) - 0.12, 0.1)
        f = union(f, length(length(x, y) - 0.53, z - 0.74) - 0.13, 0.08)
        hollow = ball(p * squash, (0, 0, 0), 0.82)
        hollow = union(hollow, capsule(p, (0, 0, 0.3), (0, 0, 1.4), 0.42), 0.08)
        hollow = union(hollow, capsule(p, (0, -0.7, -0.25), (0, -1.35, 0.15), 0.15, 0.12), 0.08)
        hollow = union(hollow, capsule(p, (0, -1.35, 0.15), (0, -1.78, 0.92), 0.12), 0.05)
        return cut(f, hollow, 0.06)

    return closed(*triangulate(field, (-1.15, -2.0, -1.1), (1.15, 1.75, 1.05), edge))
