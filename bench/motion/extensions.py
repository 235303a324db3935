# SPDX-License-Identifier: Apache-2.0
"""Two usual ways to move a mesh without changes of its connectivity: the displacement of the boundary is extended by
Laplace's equation or by linear elasticity, with linear elements and the stiffness 1 / V of each element."""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla


def volumes(points, tets):
    a, b, c, d = np.moveaxis(points[tets], 1, 0)
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def gradients(points, tets):
    """Of the four basis functions of each element."""
    p = points[tets]
    inverse = np.linalg.inv(p[:, 1:] - p[:, :1])
    g = np.moveaxis(inverse, 2, 1)
    return np.concatenate([-g.sum(axis=1, keepdims=True), g], axis=1)


def laplace(points, tets):
    """A matrix over the vertices: the three components do not depend on each other."""
    g = gradients(points, tets)
    k = np.einsum("eik,ejk->eij", g, g)
    i, j = np.repeat(tets, 4, axis=1).ravel(), np.tile(tets, (1, 4)).ravel()
    return sp.csr_matrix((k.ravel(), (i, j)), shape=(len(points), len(points)))


def elasticity(points, tets, poisson=0.3):
    """The matrix of linear elasticity over the three components of each vertex, with Young's modulus 1 / V."""
    g = gradients(points, tets)
    lame = poisson / ((1 + poisson) * (1 - 2 * poisson))
    shear = 0.5 / (1 + poisson)
    k = lame * np.einsum("eia,ejb->eiajb", g, g) + shear * np.einsum("eib,eja->eiajb", g, g)
    k += shear * np.einsum("eik,ejk,ab->eiajb", g, g, np.eye(3))
    return _assemble(k, tets, len(points))


def _assemble(k, tets, n):
    rows = (3 * tets[:, :, None] + np.arange(3)).reshape(len(tets), 12)
    i = np.repeat(rows, 12, axis=1).ravel()
    j = np.tile(rows, (1, 12)).ravel()
    return sp.csr_matrix((k.reshape(-1), (i, j)), shape=(3 * n, 3 * n))


def extend(matrix, displacement, is_given):
    """Displacements of shape (n, 3), from the components where `is_given`."""
    if matrix.shape[0] == is_given.size:
        return _solve(matrix, displacement.ravel(), is_given.ravel()).reshape(-1, 3)
    return np.column_stack([_solve(matrix, displacement[:, k], is_given[:, k]) for k in range(3)])


def _solve(matrix, displacement, given):
    """Conjugate gradients to 1e-6."""
    d = np.where(given, displacement, 0)
    free = ~given
    a = matrix[free][:, free]
    right = -(matrix[free][:, given] @ d[given])
    d[free], failed = sla.cg(a, right, rtol=1e-6, maxiter=20000, M=sp.diags(1 / a.diagonal()))
    if failed:
        raise RuntimeError("the solver did not converge")
    return d
