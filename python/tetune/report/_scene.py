# SPDX-License-Identifier: Apache-2.0
"""The 3D view of the page: the surface of a mesh, cuts through it, and the neighborhoods of the worst elements.

A mesh of a million tetrahedra is too much for a page; its surface and some dozens of cuts are not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import Quality, TetMesh, measure_all, measure_each

Array = NDArray[Any]

# Faces of a positive tetrahedron, oriented outwards.
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
# The colors of elements: measure, worst and best value of the scale.
COLORS = {"min_dihedral_deg": (0.0, 70.53), "mean_ratio": (0.0, 1.0)}
WORST = 12
# A cut of n tetrahedra takes about this times n^(2/3) bytes of the page.
CUT_BYTES = 15
ALL_CUTS_BYTES, MOST_CUTS = 9_000_000, 24


@dataclass(frozen=True)
class Measured:
    """A mesh and the quality of its elements."""

    mesh: TetMesh
    each: dict[str, Array]
    quality: Quality

    @classmethod
    def of(cls, mesh: TetMesh) -> Measured:
        return cls(mesh, measure_each(mesh), measure_all(mesh, worst=WORST))

    def colors(self, tets: Array) -> dict[str, Array]:
        """The colors of these tetrahedra, 0 to 255 over the scale."""
        return {
            name: np.clip((self.each[name][tets] - lo) / (hi - lo) * 255, 0, 255).astype(np.uint8)
            for name, (lo, hi) in COLORS.items()
        }


def cuts_per_axis(tets: int) -> int:
    """The number of cuts that the size of the page allows, in both meshes and along three axes."""
    return int(np.clip(ALL_CUTS_BYTES / (6 * CUT_BYTES * tets ** (2 / 3)), 3, MOST_CUTS))


def boundary_faces(mesh: TetMesh) -> tuple[Array, Array]:
    """The faces that only one tetrahedron has, and that tetrahedron."""
    rng = np.random.default_rng(0)
    key = rng.integers(2**64, size=len(mesh.points), dtype=np.uint64)
    # A face is identified by a sum of random 64-bit numbers; collisions are too unlikely to matter.
    keys = key[mesh.tets]
    faces = np.stack([keys[:, a] + keys[:, b] + keys[:, c] for a, b, c in FACES])
    # The two sides of an inner face cancel in their bucket, so that few faces remain to be sorted.
    buckets = max(1, 1 << int(np.log2(faces.size / 4)))
    bucket = faces & np.uint64(buckets - 1)
    left = np.zeros(buckets, dtype=np.uint64)
    np.bitwise_xor.at(left, bucket, faces)
    face, tet = np.nonzero((left != 0)[bucket])
    _, first, count = np.unique(faces[face, tet], return_index=True, return_counts=True)
    single = np.sort(first[count == 1])
    face, tet = face[single], tet[single]
    return mesh.tets[tet[:, None], FACES[face]], tet


def _sorted(triangles: Array, tet: Array) -> tuple[Array, Array]:
    """Sorts triangles by their vertices: neighbors are then adjacent, which compresses well."""
    order = np.argsort(triangles.min(axis=1), kind="stable")
    return triangles[order], tet[order]


class Scene:
    """Surface and cuts of one mesh. Coordinates are parts of the common box, in 65535ths."""

    def __init__(self, measured: Measured, low: Array, size: Array, cuts: int) -> None:
        self._m = measured
        self._low, self._size = low, size
        points, tets = measured.mesh.points, measured.mesh.tets
        triangles, tet = _sorted(*boundary_faces(measured.mesh))
        self.surface = self._packed(triangles, tet)
        self.cuts: list[list[dict[str, Array]]] = []
        for axis in range(3):
            planes = low[axis] + size[axis] * (np.arange(cuts) + 1) / (cuts + 1)
            # For each vertex the number of planes that it is not below.
            passed = np.searchsorted(planes, points[:, axis], side="right").astype(np.uint8)
            corners = [passed[tets[:, k]] for k in range(4)]
            near, far = corners[0].copy(), corners[0].copy()
            for c in corners[1:]:
                np.minimum(near, c, out=near)
                np.maximum(far, c, out=far)
            # The first cut that shows a triangle: all elements that reach below a plane are shown.
            self.surface[f"first{axis}"] = near[tet]
            self.cuts.append([self._cut(passed, near, far, c) for c in range(cuts)])

    def _cut(self, passed: Array, near: Array, far: Array, plane: int) -> dict[str, Array]:
        """The faces of cut elements that lie beyond the plane, where other elements would hide them."""
        tets = np.flatnonzero((near <= plane) & (far > plane))
        beyond = passed[self._m.mesh.tets[tets]] > plane
        row, face = np.nonzero(np.stack([beyond[:, f].all(axis=1) for f in FACES], axis=1))
        tet = tets[row]
        return self._packed(*_sorted(self._m.mesh.tets[tet[:, None], FACES[face]], tet))

    def _packed(self, triangles: Array, tet: Array) -> dict[str, Array]:
        vertices, corner = np.unique(triangles, return_inverse=True)
        parts = (self._m.mesh.points[vertices] - self._low) / self._size
        index = np.uint16 if len(vertices) < 2**16 else np.uint32
        return {
            "points": np.round(parts * 65535).astype(np.uint16).T,
            "triangles": corner.reshape(-1, 3).astype(index).T,
            **self._m.colors(tet),
        }


class Places:
    """Finds the elements around a point."""

    def __init__(self, measured: Measured) -> None:
        self._m = measured
        x, tets = measured.mesh.points[:, 0].copy(), measured.mesh.tets
        centroids = (x[tets[:, 0]] + x[tets[:, 1]] + x[tets[:, 2]] + x[tets[:, 3]]) / 4
        self._by_x = np.argsort(centroids)
        self._x = centroids[self._by_x]

    def around(self, center: Array, radius: float, element: int = -1) -> dict[str, Array]:
        """The four vertices of each element; `element` comes first."""
        begin, end = np.searchsorted(self._x, [center[0] - radius, center[0] + radius])
        slab = np.sort(self._by_x[begin:end])
        centroids = self._m.mesh.points[self._m.mesh.tets[slab]].mean(axis=1)
        near = slab[((centroids - center) ** 2).sum(axis=1) < radius**2]
        if element >= 0:
            near = np.concatenate([[element], near[near != element]])
        corners = self._m.mesh.points[self._m.mesh.tets[near]]
        return {"corners": corners.astype(np.float32), **self._m.colors(near)}


def worst_places(measured: tuple[Measured, Measured]) -> list[list[dict[str, Any]]]:
    """For the worst elements of each mesh: figures, and the neighborhood in both meshes."""
    places = [Places(m) for m in measured]
    lists = []
    for which, m in enumerate(measured):
        rows = []
        for w in m.quality.worst:
            corners = m.mesh.points[m.mesh.tets[w.tet]]
            center = corners.mean(axis=0)
            radius = max(float(np.linalg.norm(a - b)) for a in corners for b in corners)
            rows.append({
                "tet": w.tet + 1,
                "angle": w.dihedral,
                "ratio": float(m.each["mean_ratio"][w.tet]),
                "at": list(w.centroid),
                "size": radius,
                "around": [
                    p.around(center, radius, w.tet if k == which else -1) for k, p in enumerate(places)
                ],
            })
        lists.append(rows)
    return lists
