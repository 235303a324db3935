#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the surface of a mesh before and after sliding: each triangle colored by the smallest dihedral angle of the
tetrahedron behind it, edges where the surface turns by more than 45 degrees in red.

    tetune optimize fandisk.mesh -o after.mesh --boundary slide
    slide_fandisk.py fandisk.mesh after.mesh slide_fandisk.png

Needs pyvista, meshio and pillow.
"""

import sys

import meshio
import numpy as np
import PIL.Image
import pyvista

FACES = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))
NAME = "smallest dihedral angle of the tetrahedron behind (degrees)"


def smallest_dihedral(points, tets):
    p = points[tets]
    normals = [np.cross(p[:, b] - p[:, a], p[:, c] - p[:, a]) for a, b, c in FACES]
    normals = [n / np.linalg.norm(n, axis=1)[:, None] for n in normals]
    least = np.full(len(tets), 180.0)
    for i in range(4):
        for j in range(i):
            cosine = -np.einsum("ij,ij->i", normals[i], normals[j])
            least = np.minimum(least, np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return least


def surface(path):
    mesh = meshio.read(path)
    tets = np.vstack([block.data for block in mesh.cells if block.type == "tetra"])
    faces = np.vstack([tets[:, f] for f in FACES])
    angle = np.tile(smallest_dihedral(mesh.points, tets), 4)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    outer = first[count == 1]
    poly = pyvista.PolyData.from_regular_faces(mesh.points, faces[outer])
    poly.cell_data[NAME] = angle[outer]
    return poly


def main(before, after, picture):
    plotter = pyvista.Plotter(shape=(1, 2), window_size=(1240, 660), border=False, off_screen=True)
    for column, (title, path) in enumerate((("before", before), ("after", after))):
        poly = surface(path)
        plotter.subplot(0, column)
        plotter.add_mesh(poly, scalars=NAME, cmap="viridis", clim=(0, 50), show_edges=True, edge_color="#606060",
                         line_width=0.3, ambient=0.45, diffuse=0.65, show_scalar_bar=column == 1,
                         scalar_bar_args={"title_font_size": 15, "label_font_size": 14, "color": "black", "fmt": "%.0f",
                                          "position_x": 0.15, "position_y": 0.02, "width": 0.7, "height": 0.09})
        features = poly.extract_feature_edges(45, boundary_edges=False, manifold_edges=False)
        plotter.add_mesh(features, color="#e02020", line_width=3)
        plotter.add_text(title, font_size=12, color="black")
        plotter.view_vector((-1.0, -0.9, 0.7), (0, 0, 1))
        plotter.camera.zoom(1.35)
    plotter.set_background("white")
    image = plotter.screenshot(None, return_img=True)
    PIL.Image.fromarray(image).quantize(96, dither=PIL.Image.Dither.NONE).save(picture, optimize=True)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
