# SPDX-License-Identifier: Apache-2.0
"""A piston compresses a chamber: in each step its face is prescribed, the walls slide, and the inner vertices follow."""

import numpy as np

import tetune

# A chamber of 12 x 6 x 6 cells of six tetrahedra each; the piston is its face x = 2.
n = np.array([12, 6, 6])
grid = np.moveaxis(np.indices(n + 1), 0, -1)
points = grid.reshape(-1, 3) / 6.0
number = np.arange(len(points)).reshape(n + 1)
corner = np.stack([number[i : i + n[0], j : j + n[1], k : k + n[2]].ravel() for i in (0, 1) for j in (0, 1) for k in (0, 1)])
paths = [(0, 4, 6, 7), (0, 2, 3, 7), (0, 1, 5, 7), (0, 5, 4, 7), (0, 6, 2, 7), (0, 3, 1, 7)]
tets = np.concatenate([corner[list(path)].T for path in paths])

piston, head = points[:, 0] == 2, points[:, 0] == 0
mesh = tetune.TetMesh(points, tets)
for position in np.linspace(2, 0.4, 9)[1:]:
    targets = np.full((len(points), 3), np.nan)  # NaN: the vertex follows
    targets[head | piston] = points[head | piston]
    targets[piston, 0] = position
    result = tetune.move(mesh, to=targets)
    assert result.motion.reached
    mesh = result.mesh
    angle = result.motion.steps[-1].dihedral_min
    print(f"piston at {position:.1f}: {len(mesh.tets)} tetrahedra, smallest angle {angle:.1f} degrees")
assert tetune.validate(mesh) == ""
