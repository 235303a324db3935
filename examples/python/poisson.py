# SPDX-License-Identifier: Apache-2.0
"""The effect of mesh quality on a solver: heat in a bracket of two materials, with scikit-fem.

Prints the condition number of the stiffness matrix and the iterations of conjugate gradients, before and after.
"""

from pathlib import Path

import numpy as np
import skfem
from scipy.sparse.linalg import cg, eigsh
from skfem.helpers import dot, grad

import tetune

CONDUCTIVITY = {30: 100.0, 31: 1.0}  # of bushing and bracket, by their tags


def solve(mesh):
    m = skfem.MeshTet(np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.tets.T, dtype=np.int64))
    basis = skfem.Basis(m, skfem.ElementTetP1())
    conductivity = np.vectorize(CONDUCTIVITY.get)(mesh.tet_tags)[:, None]
    stiffness = skfem.BilinearForm(lambda u, v, w: w.k * dot(grad(u), grad(v))).assemble(basis, k=conductivity)
    load = skfem.LinearForm(lambda v, w: 1.0 * v).assemble(basis)
    cold = np.flatnonzero(m.p[2] == m.p[2].min())  # held at 0
    A, b, temperature, inside = skfem.condense(stiffness, load, D=cold)

    iterations = 0

    def count(_):
        nonlocal iterations
        iterations += 1

    temperature[inside], failed = cg(A, b, rtol=1e-8, maxiter=20000, callback=count)
    assert failed == 0
    largest = eigsh(A, 1, which="LA", tol=1e-4, return_eigenvectors=False)[0]
    smallest = eigsh(A.tocsc(), 1, sigma=0, tol=1e-4, return_eigenvectors=False)[0]
    return largest / smallest, iterations, temperature.max()


bracket = tetune.read_mesh(str(Path(__file__).parents[2] / "data" / "bracket.meshb"))
result = tetune.optimize(bracket, effort="best")
print("          smallest angle   condition number   iterations of CG   highest temperature")
for name, mesh in (("before", bracket), ("after", result.mesh)):
    condition, iterations, highest = solve(mesh)
    print(f"{name:6}{tetune.quality(mesh).dihedral_min:14.2f} deg{condition:19.3g}{iterations:19}{highest:22.2f}")
