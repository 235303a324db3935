# SPDX-License-Identifier: Apache-2.0
"""Gmsh -> tetune -> Gmsh without a file: a block with a ball of another material in it."""

import gmsh
import numpy as np

import tetune

TRIANGLE, TETRAHEDRON = 2, 4  # Gmsh's numbers of these elements


def elements(dimension, kind, node_row):
    """Rows of nodes, and the tag of the entity that each element is on."""
    rows, tags = [], []
    for _, tag in gmsh.model.getEntities(dimension):
        nodes = node_row[gmsh.model.mesh.getElementsByType(kind, tag)[1]].reshape(-1, dimension + 1)
        rows.append(nodes)
        tags.append(np.full(len(nodes), tag))
    return np.concatenate(rows), np.concatenate(tags)


gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
occ = gmsh.model.occ
occ.fragment([(3, occ.addBox(0, 0, 0, 3, 2, 2))], [(3, occ.addSphere(1.5, 1, 1, 0.6))])
occ.synchronize()
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.15)
gmsh.option.setNumber("Mesh.Optimize", 0)  # tetune does that
gmsh.model.mesh.generate(3)

node_tags, points, _ = gmsh.model.mesh.getNodes()
node_row = np.zeros(node_tags.max() + 1, dtype=np.int64)
node_row[node_tags] = np.arange(len(node_tags))
tets, volumes = elements(3, TETRAHEDRON, node_row)
triangles, surfaces = elements(2, TRIANGLE, node_row)
mesh = tetune.TetMesh(points.reshape(-1, 3), tets, tet_tags=volumes, triangles=triangles, triangle_tags=surfaces)

# Nodes keep their number and the surface its triangles: only positions and tetrahedra change.
result = tetune.optimize(mesh, boundary_flips=False)

for row in np.flatnonzero(result.moved):
    gmsh.model.mesh.setNode(node_tags[row], result.mesh.points[row], [])
for _, volume in gmsh.model.getEntities(3):
    gmsh.model.mesh.removeElements(3, volume)
    inside = result.mesh.tets[result.mesh.tet_tags == volume]
    gmsh.model.mesh.addElementsByType(volume, TETRAHEDRON, [], node_tags[inside].ravel())

element_tags, _ = gmsh.model.mesh.getElementsByType(TETRAHEDRON)
worst = np.min(gmsh.model.mesh.getElementQualities(element_tags, "minSICN"))
print(f"tetrahedra                      {len(tets)} -> {len(element_tags)}")
print(f"smallest dihedral angle         {tetune.quality(mesh).dihedral_min:.1f} -> "
      f"{tetune.quality(result.mesh).dihedral_min:.1f} degrees")
print(f"smallest minSICN, by Gmsh       {tetune.quality(mesh).measures['sicn'].min:.3f} -> {worst:.3f}")
gmsh.finalize()
