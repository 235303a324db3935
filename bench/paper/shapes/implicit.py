# SPDX-License-Identifier: Apache-2.0
"""Smooth solids: signed fields put together from simple ones, and the triangulation of where a field is zero.

A field takes an array of points (n, 3) and returns n values, negative inside, about the distance near the surface."""

import numpy as np


def length(*c):
    return np.sqrt(sum(x * x for x in c))


def capsule(p, a, b, radius_a, radius_b=None):
    """A stick with round ends; its radius may change from a to b."""
    a, b = np.array(a, float), np.array(b, float)
    t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    radius = radius_a if radius_b is None else radius_a + t * (radius_b - radius_a)
    return np.linalg.norm(p - a - t[:, None] * (b - a), axis=1) - radius


def ball(p, center, radius):
    return np.linalg.norm(p - np.array(center, float), axis=1) - radius


def box(p, center, half, rounding):
    """Its edges rounded with the radius `rounding`."""
    q = np.abs(p - np.array(center, float)) - (np.array(half, float) - rounding)
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0) - rounding


def disc(p, center, radius, half, rounding):
    """A round plate, its axis upright."""
    p = p - np.array(center, float)
    q, r = length(p[:, 0], p[:, 1]) - radius + rounding, np.abs(p[:, 2]) - half + rounding
    return length(np.maximum(q, 0), np.maximum(r, 0)) + np.minimum(np.maximum(q, r), 0) - rounding


def union(a, b, blend):
    """With a fillet about `blend` wide."""
    h = np.maximum(blend - np.abs(a - b), 0) / blend
    return np.minimum(a, b) - h * h * blend / 4


def cut(a, b, blend):
    """a without b."""
    return -union(-a, b, blend)


def common(a, b, blend):
    """The intersection."""
    return -union(-a, -b, blend)


def step(low, high, x):
    """From 0 at low to 1 at high, smoothly."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def triangulate(field, low, high, edge):
    """Points and triangles, outwards, of the surface of a field within a box, its edges about `edge` long: marching
    tetrahedra on a body-centered lattice, which gives a closed manifold whatever the field, then relaxed on the surface."""
    low, high, size = np.array(low, float), np.array(high, float), CELL * edge
    cells = np.ceil((high - low) / size).astype(int) + 1
    low = (low + high) / 2 - cells * size / 2
    value, first = [], []  # of the corners and of the middles of the cells, which are numbered after the corners
    for shape, shift in ((cells + 1, 0.0), (cells, 0.5)):
        lattice = (np.indices(shape).reshape(3, -1).T + shift) * size + low
        first.append(sum(len(v) for v in value))
        value.append(np.concatenate([field(part) for part in np.array_split(lattice, 64)]))
    inside = [v.reshape(shape) < 0 for v, shape in zip(value, (cells + 1, cells))]
    rim = [inside[1].take([0, -1], axis) for axis in range(3)]
    assert not any(r.any() for r in rim), "the box is too small"

    tets = np.concatenate([lattice_tets(inside, cells, axis, turn) for axis in range(3) for turn in range(4)])
    value = np.concatenate(value)

    def place(ids):
        middle = ids >= first[1]
        at = np.where(middle, np.unravel_index(np.maximum(ids - first[1], 0), cells),
                      np.unravel_index(np.minimum(ids, first[1] - 1), cells + 1))
        return low + size * (at.T + 0.5 * middle[:, None])

    near, far, triangles = cut_tets(tets, value[tets] < 0, place)
    weight = (value[near] / (value[near] - value[far]))[:, None]
    return relax(field, place(near) + np.clip(weight, 0.1, 0.9) * (place(far) - place(near)), triangles, edge)


CELL = 2.3  # ratio of the lattice's cells to the edges of the mesh


def lattice_tets(inside, cells, axis, turn):
    """The tetrahedra that the surface passes, of those over one face of the cells: two middles, one edge of the face."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    base = np.indices(np.where(np.arange(3) == axis, cells - 1, cells)).reshape(3, -1)
    corners = []
    for du, dv in (ring[turn], ring[(turn + 1) % 4]):
        at = base.copy()
        at[axis] += 1
        at[u] += du
        at[v] += dv
        corners.append(np.ravel_multi_index(at, cells + 1))
    middles = [np.ravel_multi_index(base, cells), np.ravel_multi_index(base + (np.arange(3) == axis)[:, None], cells)]
    number = sum(inside[0].ravel()[c].astype(int) for c in corners) + sum(inside[1].ravel()[m].astype(int) for m in middles)
    passed = (number > 0) & (number < 4)
    return np.stack([*corners, *(m + inside[0].size for m in middles)], axis=1)[passed]


def cut_tets(tets, inside, place):
    """Of the lattice edges cut: their ends inside and outside; and the triangles between the cuts."""
    pieces = []
    for code in range(1, 15):
        chosen = tets[(inside << np.arange(4)).sum(axis=1) == code]
        ins, outs = [k for k in range(4) if code >> k & 1], [k for k in range(4) if not code >> k & 1]
        loop = [(i, o) for i in ins for o in outs]
        loop = [loop[k] for k in ((0, 1, 3, 2) if len(loop) == 4 else (0, 1, 2))]
        middle = [place(chosen[:, i]) + place(chosen[:, o]) for i, o in loop[:3]]
        normal = np.cross(middle[1] - middle[0], middle[2] - middle[0])
        outward = place(chosen[:, outs[0]]) - place(chosen[:, ins[0]])
        turned = np.einsum("ij,ij->i", normal, outward) < 0
        cuts = np.stack([chosen[:, list(pair)] for pair in loop], axis=1)
        cuts[turned] = cuts[turned][:, ::-1]
        pieces += [cuts[:, [0, k, k + 1]] for k in range(1, len(loop) - 1)]
    cuts = np.concatenate(pieces).reshape(-1, 2)
    ends, triangles = np.unique(cuts, axis=0, return_inverse=True)
    return ends[:, 0], ends[:, 1], triangles.reshape(-1, 3)


def relax(field, points, triangles, edge):
    """Moves the vertices to the middle of their neighbors and back to the surface, several times."""
    ends = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])  # each edge in both directions
    degree = np.bincount(ends[:, 0], minlength=len(points))[:, None]
    points = project(field, points, edge)
    for _ in range(10):
        middle = np.stack([np.bincount(ends[:, 0], points[ends[:, 1], k], len(points)) for k in range(3)], axis=1) / degree
        points = project(field, points + 0.5 * (middle - points), edge)
    return points, triangles


def project(field, points, edge):
    """To the zero of the field, by Newton's method along its gradient."""
    tiny = 1e-4 * edge
    for _ in range(3):
        gradient = np.stack([field(points + tiny * e) - field(points - tiny * e) for e in np.eye(3)], axis=1) / (2 * tiny)
        move = -(field(points) / np.maximum((gradient ** 2).sum(axis=1), 0.1))[:, None] * gradient
        points = points + move * np.minimum(1, 0.3 * edge / np.maximum(np.linalg.norm(move, axis=1), 1e-300))[:, None]
    return points


def split(points, quads):
    """Triangles of quadrilaterals, by the shorter diagonal."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    first = (((a - c) ** 2).sum(axis=1) <= ((b - d) ** 2).sum(axis=1))[:, None]
    return np.concatenate([np.where(first, quads[:, [0, 1, 2]], quads[:, [0, 1, 3]]),
                           np.where(first, quads[:, [0, 2, 3]], quads[:, [1, 2, 3]])])


def check_closed(triangles):
    """Every edge once in each direction: closed, oriented, two triangles an edge."""
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]).astype(np.int64)
    key, back = (edges[:, 0] << 32) + edges[:, 1], (edges[:, 1] << 32) + edges[:, 0]
    assert len(np.unique(key)) == len(key) and np.array_equal(np.sort(key), np.sort(back)), "the surface is not closed"
