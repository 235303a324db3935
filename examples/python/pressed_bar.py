# SPDX-License-Identifier: Apache-2.0
"""A warm elastic bar is pressed to half its height, with scikit-fem: each step solves for the displacement and for the
temperature on the mesh as it is, the live mesh takes the surface along, and the heat goes to the new mesh."""

import numpy as np
import skfem
from skfem.helpers import ddot, dot, eye, grad, sym_grad, trace

import tetune

STEPS, DIFFUSIVITY = 10, 2e-3

# A bar of 4 x 4 x 8 cells of six tetrahedra each, between plates at z = 0 and z = 2.
n = np.array([4, 4, 8])
points = np.moveaxis(np.indices(n + 1), 0, -1).reshape(-1, 3) / 4.0
number = np.arange(len(points)).reshape(n + 1)
corner = np.stack([number[i : i + n[0], j : j + n[1], k : k + n[2]].ravel() for i in (0, 1) for j in (0, 1) for k in (0, 1)])
paths = [(0, 4, 6, 7), (0, 2, 3, 7), (0, 1, 5, 7), (0, 5, 4, 7), (0, 6, 2, 7), (0, 3, 1, 7)]
tets = np.concatenate([corner[list(path)].T for path in paths])
bottom, top = points[:, 2] == 0, points[:, 2] == 2


def linear(mesh):
    return skfem.MeshTet(np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.tets.T, dtype=np.int64))


def press(mesh, height):
    """The displacement of all vertices when the upper plate goes to `height`."""
    basis = skfem.Basis(linear(mesh), skfem.ElementVector(skfem.ElementTetP1()))
    stiffness = skfem.BilinearForm(
        lambda u, v, w: ddot(2 * sym_grad(u) + 3 * eye(trace(sym_grad(u)), 3), sym_grad(v))
    ).assemble(basis)
    u = np.zeros((len(mesh.points), 3))
    u[top, 2] = height - mesh.points[top, 2]
    held = np.flatnonzero(np.repeat(bottom | top, 3))
    return skfem.solve(*skfem.condense(stiffness, x=u.ravel(), D=held)).reshape(-1, 3)


def conduct(mesh, temperature):
    """One time step of heat conduction with insulated sides, and the mean temperature."""
    basis = skfem.Basis(linear(mesh), skfem.ElementTetP1())
    mass = skfem.BilinearForm(lambda u, v, w: u * v).assemble(basis)
    stiffness = skfem.BilinearForm(lambda u, v, w: DIFFUSIVITY * dot(grad(u), grad(v))).assemble(basis)
    temperature = skfem.solve(mass + stiffness, mass @ temperature)
    return temperature, (mass @ temperature).sum() / mass.sum()


live = tetune.LiveMesh(points, tets, data="conserve", threads=1)
temperature = np.exp(-8 * ((points - [0.5, 0.5, 1.4]) ** 2).sum(axis=1))
surface = np.isin(np.arange(len(points)), linear(live.mesh).boundary_nodes())
for height in np.linspace(2, 1, STEPS + 1)[1:]:
    before = live.mesh
    targets = np.where(surface[:, None], before.points + press(before, height), np.nan)  # NaN: the vertex follows
    report = live.move(targets)
    assert report.reached
    (temperature,), _ = tetune.conserve_data(before, live.mesh, report.optimization, [temperature[:, None]], [])
    temperature, mean = conduct(live.mesh, temperature[:, 0])
    quality = tetune.quality(live.points, live.tets)
    print(f"height {height:.1f}: smallest angle {quality.dihedral_min:.1f} degrees, mean temperature {mean:.4f}, highest {temperature.max():.3f}")
assert tetune.validate(live.mesh) == ""
