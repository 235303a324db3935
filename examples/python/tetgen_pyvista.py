# SPDX-License-Identifier: Apache-2.0
"""TetGen -> tetune -> pyvista: the example of tetgen's own README, with one line more."""

import sys

import pyvista as pv
import tetgen

sphere = pv.Sphere()
tet = tetgen.TetGen(sphere)
tet.tetrahedralize(order=1, mindihedral=20, minratio=1.5)
grid = tet.grid
better = grid.tetune.optimize(effort="best")

for name, g in (("TetGen", grid), ("tetune", better)):
    jacobian = g.cell_quality("scaled_jacobian")["scaled_jacobian"]
    print(f"{name}  {g.n_cells:6} tetrahedra, smallest dihedral angle {g.tetune.quality().dihedral_min:5.2f} degrees, "
          f"scaled Jacobian {jacobian.min():.3f} to {jacobian.max():.3f}, mean {jacobian.mean():.3f}")

if "--show" in sys.argv:
    below = better.extract_cells(better.cell_centers().points[:, 2] < 0)
    below.plot(scalars=below.cell_quality("scaled_jacobian")["scaled_jacobian"], show_edges=True, clim=[0, 1])
