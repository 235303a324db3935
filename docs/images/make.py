# SPDX-License-Identifier: Apache-2.0
"""Draws meshes cut open, before and after tetune, colored by the smallest dihedral angle of each tetrahedron.

  python docs/images/make.py             docs/images/bracket.png: the mesh of the demo
  python docs/images/make.py FOLDER      also docs/gallery.md and its pictures, of meshes of other projects in FOLDER, which
                                         has the files that MESHES names

Needs pip install '.[test]'.
"""

import sys
from pathlib import Path

import numpy as np
import pyvista as pv
from PIL import Image

import tetune

HERE = Path(__file__).parent
DOCS = HERE.parent

# Name, file, title, source, normal of the cut and its place along the normal (0 to 1), direction to the camera, upward.
MESHES = [
    ("house", "stellar_house2.ele", "House", "`house2` of Stellar 1.0, in [vmtk](https://github.com/vmtk/vmtk)", (0, 1, 0), 0.45, (-0.5, -2, 0.7), (0, 0, 1)),
    ("tire", "mesquite_tire.vtk", "Tire", "`tire.vtk` of [Mesquite](https://github.com/trilinos/mesquite)", (0, 0, 1), 0.5, (0.6, 0.5, -2), (0, 1, 0)),
    ("dolphin", "ipc_dolphin5K.msh", "Dolphin", "[IPC](https://github.com/ipc-sim/IPC), `input/tetMeshes`", (0, 0, 1), 0.5, (0.3, 0.4, -2), (0, 1, 0)),
    ("armadillo", "codimipc_Armadillo28K.vtk", "Armadillo", "[Codim-IPC](https://github.com/ipc-sim/Codim-IPC)", (0, 0, 1), 0.5, (0.4, 0.3, -2), (0, 1, 0)),
    ("raptor", "sofa_raptorTetra_12580.vtu", "Raptor", "[SOFA](https://github.com/sofa-framework/sofa)", (1, 0, 0), 0.5, (-2, 0.3, 0.4), (0, 1, 0)),
    ("cylinder", "sfepy_multi_material_cylinder_plate.vtk", "Cylinder in a plate, two materials", "[SfePy](https://github.com/sfepy/sfepy)", (0, 1, 0), 0.5, (-0.6, -2, 0.8), (0, 0, 1)),
]


def draw(path, meshes, keep, camera, zoom=0):
    """Two meshes side by side. `keep` selects the tetrahedra to show from their centroids; with a zoom these fill the picture."""
    plotter = pv.Plotter(shape=(1, 2), border=False, off_screen=True, window_size=(1200, 540))
    for column, (title, mesh) in enumerate(zip(("before", "after"), meshes)):
        grid = pv.UnstructuredGrid({pv.CellType.TETRA: mesh.tets}, mesh.points)
        angles = tetune.measure_each(mesh)["min_dihedral_deg"]
        grid.cell_data["angle"] = angles
        plotter.subplot(0, column)
        plotter.add_text(f"{title}: {angles.min():.1f} degrees smallest angle", font_size=12, color="black")
        plotter.add_mesh(
            grid.extract_cells(keep(grid.cell_centers().points)), show_edges=True, line_width=0.5, edge_color="gray",
            ambient=0.45, diffuse=0.6, clim=[0, 60], cmap="viridis", show_scalar_bar=column == 1,
            scalar_bar_args={"title": "smallest dihedral angle, degrees\n", "color": "black", "position_x": 0.3, "position_y": 0.03,
                             "n_labels": 4, "fmt": "%.0f", "title_font_size": 18, "label_font_size": 16},
        )
        plotter.camera_position = camera
        if zoom:
            plotter.reset_camera()
            plotter.camera.zoom(zoom)
        plotter.background_color = "white"
    # A palette takes a third of the size.
    image = Image.fromarray(plotter.screenshot(return_img=True)).quantize(128, dither=Image.Dither.NONE)
    image.save(path, optimize=True)
    plotter.close()


def figures(mesh):
    q = tetune.quality(mesh)
    return f"{len(mesh.tets):,} | {q.dihedral_min:.1f}° | {q.dihedral_max:.1f}° | {q.mean_ratio:.3f}"


def draw_bracket():
    mesh = tetune.read_mesh(str(HERE.parents[1] / "data" / "bracket.meshb"))
    after = tetune.optimize(mesh, effort="best").mesh
    draw(HERE / "bracket.png", (mesh, after), lambda centers: centers[:, 1] > 25, [(10, -95, 75), (40, 30, 22), (0, 0, 1)])


def draw_gallery(folder):
    page = ["# Gallery", "", "Meshes of other projects, cut open, before and after `tetune optimize IN -o OUT --boundary slide --effort best`."
            " Made by `python docs/images/make.py FOLDER`; each title's file is in the named project.", ""]
    for name, file, title, source, normal, place, toward, up in MESHES:
        mesh = tetune.read_mesh(str(folder / file))
        after = tetune.optimize(mesh, boundary="slide", effort="best").mesh
        along = np.asarray(mesh.points) @ np.array(normal, float)
        cut = along.min() + place * np.ptp(along)
        low, high = np.min(mesh.points, axis=0), np.max(mesh.points, axis=0)
        center, size = (low + high) / 2, np.linalg.norm(high - low)
        direction = np.array(toward, float) / np.linalg.norm(toward)
        camera = [tuple(center + 1.75 * size * direction), tuple(center), up]
        draw(HERE / f"gallery-{name}.png", (mesh, after), lambda centers: centers @ np.array(normal, float) > cut, camera, zoom=0.85)
        page += [f"## {title}", "", f"From {source}.", "", f"![{title}, cut open, before and after](images/gallery-{name}.png)", "",
                 "| | tetrahedra | smallest angle | largest | mean ratio |", "|---|---|---|---|---|",
                 f"| before | {figures(mesh)} |", f"| after | {figures(after)} |", ""]
    (DOCS / "gallery.md").write_text("\n".join(page[:-1]) + "\n", encoding="utf-8")


draw_bracket()
if len(sys.argv) > 1:
    draw_gallery(Path(sys.argv[1]))
