# SPDX-License-Identifier: Apache-2.0
"""Which data of meshio and pyvista meshes are tags."""

import warnings

import numpy as np
import pytest

import tetune
from meshes import interface_area, two_regions

meshio = pytest.importorskip("meshio")
pv = pytest.importorskip("pyvista")


def test_tags_choose_the_regions():
    points, tets, region = two_regions()
    # A wavy interface: only tags hold it.
    shifted = points + np.outer((points[:, 0] == 4) * 0.25 * np.sin(points[:, 1] + points[:, 2]), [1, 0, 0])
    def area_after(mesh, **options):
        r = tetune.optimize(mesh, **options)
        tags = region[r.parent]
        return interface_area(r.mesh.points, r.mesh.cells[0].data, tags) if tags.min() != tags.max() else 0
    mesh = meshio.Mesh(shifted, [("tetra", tets)], cell_data={"material": [region.astype(float)]})
    before = interface_area(shifted, tets, region)
    assert area_after(mesh, tags="material") == pytest.approx(before, rel=1e-12)
    assert area_after(mesh) != pytest.approx(before, rel=1e-3)
    known = meshio.Mesh(shifted, [("tetra", tets)], cell_data={"gmsh:physical": [region]})
    assert area_after(known) == pytest.approx(before, rel=1e-12)
    assert area_after(known, tags=False) != pytest.approx(before, rel=1e-3)
    with pytest.raises(tetune.OptionError, match="tags is 'mat'; the cell data of this mesh are: material"):
        tetune.optimize(mesh, tags="mat")
    unusable = [(region / 4, "not whole"), (np.where(region == 1, np.nan, 2), "not whole"), (region.astype(str), "no numbers")]
    for values, message in unusable:
        with warnings.catch_warnings(), pytest.raises(tetune.OptionError, match=message):
            warnings.simplefilter("error")
            tetune.optimize(meshio.Mesh(points, [("tetra", tets)], cell_data={"material": [values]}), tags="material")
    vectors = meshio.Mesh(points, [("tetra", tets)], cell_data={"material": [np.ones((len(tets), 3))]})
    with pytest.raises(tetune.OptionError, match="has 3 numbers per cell"):
        tetune.optimize(vectors, tags="material")


@pytest.mark.parametrize("name", ["tetgen:ref", "refs"])
@pytest.mark.parametrize("package", ["meshio", "pyvista"])
def test_all_names_of_tags_in_files(name, package):
    points, tets, region = two_regions()
    shifted = points + np.outer((points[:, 0] == 4) * 0.25 * np.sin(points[:, 1] + points[:, 2]), [1, 0, 0])
    mesh = meshio.Mesh(shifted, [("tetra", tets)], cell_data={name: [region]})
    r = tetune.optimize(mesh if package == "meshio" else pv.from_meshio(mesh))
    new = r.mesh.cells_dict["tetra" if package == "meshio" else 10]
    before = interface_area(shifted, tets, region)
    assert r.moved.any() and interface_area(np.asarray(r.mesh.points), new, region[r.parent]) == pytest.approx(before, rel=1e-12)


def test_data_that_are_no_tags():
    points, tets, region = two_regions()
    mesh = meshio.Mesh(points, [("tetra", tets)], cell_data={"medit:ref": [region / 4], "refs": [region]})
    with pytest.warns(UserWarning, match='"medit:ref" does not hold integers of 32 bits: kept as data, not as tags') as record:
        r = tetune.optimize(mesh)
    assert record[0].filename == __file__
    tagged = tetune.optimize(tetune.TetMesh(points, tets, tet_tags=region))
    assert np.array_equal(r.mesh.points, tagged.mesh.points) and np.array_equal(r.mesh.cell_data["medit:ref"][0], region[r.parent] / 4)
