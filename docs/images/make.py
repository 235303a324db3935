# SPDX-License-Identifier: Apache-2.0
"""Draws docs/images/bracket.png: the demo's bracket cut open, before and after --effort best. Needs pip install '.[test]'."""

from pathlib import Path

import pyvista as pv
from PIL import Image

import tetune

HERE = Path(__file__).parent
mesh = tetune.read_mesh(str(HERE.parents[1] / "data" / "bracket.meshb"))
plotter = pv.Plotter(shape=(1, 2), border=False, off_screen=True, window_size=(1200, 540))
for column, (title, m) in enumerate((("before", mesh), ("after", tetune.optimize(mesh, effort="best").mesh))):
    grid = pv.UnstructuredGrid({pv.CellType.TETRA: m.tets}, m.points)
    angles = tetune.measure_each(m)["min_dihedral_deg"]
    grid.cell_data["angle"] = angles
    plotter.subplot(0, column)
    plotter.add_text(f"{title}: {angles.min():.1f} degrees smallest angle", font_size=12, color="black")
    plotter.add_mesh(
        grid.extract_cells(grid.cell_centers().points[:, 1] > 25), show_edges=True, line_width=0.5, edge_color="gray",
        ambient=0.45, diffuse=0.6, clim=[0, 60], cmap="viridis", show_scalar_bar=column == 1,
        scalar_bar_args={"title": "smallest dihedral angle, degrees\n", "color": "black", "position_x": 0.3, "position_y": 0.03, "n_labels": 4, "fmt": "%.0f",
                         "title_font_size": 18, "label_font_size": 16},
    )
    plotter.camera_position = [(10, -95, 75), (40, 30, 22), (0, 0, 1)]
    plotter.background_color = "white"
# A palette takes a third of the size.
image = Image.fromarray(plotter.screenshot(return_img=True)).quantize(128, dither=Image.Dither.NONE)
image.save(HERE / "bracket.png", optimize=True)
