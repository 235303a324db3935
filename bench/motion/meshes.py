# SPDX-License-Identifier: Apache-2.0
"""The meshes of the motion benchmark, by Gmsh: each is returned as points and tetrahedra."""

import gmsh
import numpy as np


def _generate(build, size):
    gmsh.initialize(["", "-v", "1"])
    try:
        build(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        for low_high in ("Min", "Max"):
            gmsh.option.setNumber(f"Mesh.MeshSize{low_high}", size)
        gmsh.option.setNumber("Mesh.Algorithm3D", 10)  # HXT
        gmsh.model.mesh.generate(3)
        tags, points, _ = gmsh.model.mesh.getNodes()
        _, _, nodes = gmsh.model.mesh.getElements(3)
        row = np.zeros(int(tags.max()) + 1, dtype=np.int64)
        row[tags] = np.arange(len(tags))
        tets = row[np.asarray(nodes[0], dtype=np.int64)].reshape(-1, 4)
        used = np.unique(tets)
        new = np.full(len(tags), -1)
        new[used] = np.arange(len(used))
        return points.reshape(-1, 3)[used], new[tets].astype(np.int32)
    finally:
        gmsh.finalize()


def box_with_sphere(size):
    """The cube [-1, 1]^3 without the ball of radius 0.4 around the origin."""

    def build(occ):
        box = occ.addBox(-1, -1, -1, 2, 2, 2)
        ball = occ.addSphere(0, 0, 0, 0.4)
        occ.cut([(3, box)], [(3, ball)])

    return _generate(build, size)


def box_with_ellipsoid(size):
    """The cube [-1, 1]^3 without an ellipsoid of half axes 0.7, 0.3, 0.3 around the origin."""

    def build(occ):
        box = occ.addBox(-1, -1, -1, 2, 2, 2)
        ball = occ.addSphere(0, 0, 0, 1)
        occ.dilate([(3, ball)], 0, 0, 0, 0.7, 0.3, 0.3)
        occ.cut([(3, box)], [(3, ball)])

    return _generate(build, size)


def bar(size):
    """A bar [0, 4] x [-0.5, 0.5]^2."""
    return _generate(lambda occ: occ.addBox(0, -0.5, -0.5, 4, 1, 1), size)


def chamber(size):
    """The chamber of a piston: a box [0, 1] x [-0.5, 0.5]^2, whose face x = 1 is the piston's."""
    return _generate(lambda occ: occ.addBox(0, -0.5, -0.5, 1, 1, 1), size)


def valve(size):
    """A box [0, 1] x [-0.5, 0.5]^2 without a disk of radius 0.3 and thickness 0.15, whose distance from the seat x = 0 is 0.35."""

    def build(occ):
        box = occ.addBox(0, -0.5, -0.5, 1, 1, 1)
        disk = occ.addCylinder(0.35, 0, 0, 0.15, 0, 0, 0.3)
        occ.cut([(3, box)], [(3, disk)])

    return _generate(build, size)


def surface_faces(tets):
    """The faces on one tetrahedron."""
    faces = tets[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].reshape(-1, 3)
    _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[first[counts == 1]]


def surface_vertices(tets):
    """Flags the vertices of faces on one tetrahedron."""
    flags = np.zeros(tets.max() + 1, dtype=bool)
    flags[surface_faces(tets).ravel()] = True
    return flags
