# SPDX-License-Identifier: Apache-2.0
"""The example of mmgpy's own README, with tetune in its place: mmgpy_pyvista.py IN OUT"""

import sys

import pyvista as pv

mesh = pv.read(sys.argv[1])
better = mesh.tetune.optimize()  # was: mesh.mmg.remesh(hmax=0.1)

q_before = mesh.tetune.measure_each()["mean_ratio"]
q_after = better.tetune.measure_each()["mean_ratio"]
print(f"Quality: {q_before.mean():.2f} -> {q_after.mean():.2f}")

better.save(sys.argv[2])
