# SPDX-License-Identifier: Apache-2.0
"""Meshes of CAD parts, with vertices on the exact surface."""

import numpy as np
import pytest
import tetune

gmsh = pytest.importorskip("gmsh")


@pytest.fixture(scope="module")
def cylinder(tmp_path_factory):
    """A cylinder of radius 1 and height 1: its STEP file, and a mesh whose vertices are a little off it."""
    path = tmp_path_factory.mktemp("cad") / "cylinder.step"
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.4)
        gmsh.option.setNumber("Mesh.Optimize", 0)
        gmsh.model.mesh.generate(3)
        tags, points, _ = gmsh.model.mesh.getNodes()
        _, _, nodes = gmsh.model.mesh.getElements(3)
    finally:
        gmsh.finalize()
    row = np.zeros(int(tags.max()) + 1, dtype=np.int32)
    row[tags] = np.arange(len(tags))
    points = points.reshape(-1, 3).round(3)
    return path, points, row[np.asarray(nodes[0], dtype=np.int64)].reshape(-1, 4)


def geometry_of(path, **arguments):
    try:
        return tetune.Geometry(path, **arguments)
    except tetune.FileError as e:
        if "libocct" in str(e):
            pytest.skip("built without OpenCASCADE")
        raise


def off_cylinder(points, dimensions):
    """The largest distance of vertices on faces and edges from the cylinder."""
    p = points[(dimensions == 1) | (dimensions == 2)]
    on_ends = np.abs(np.abs(p[:, 2] - 0.5) - 0.5)
    on_side = np.abs(np.hypot(p[:, 0], p[:, 1]) - 1)
    return np.minimum(on_ends, on_side).max()


def test_vertices_end_on_the_model(cylinder):
    path, points, tets = cylinder
    model = geometry_of(path)
    assert model.counts[2:] == [3, 1] and np.allclose(model.low, [-1, -1, 0]) and np.allclose(model.high, [1, 1, 1])
    result = tetune.optimize(points, tets, geometry=model, boundary="slide", snap=np.bool_(True))
    account = result.geometry
    before, after = account.before, account.after
    assert off_cylinder(points, before.dimensions) > 1e-5
    assert off_cylinder(result.mesh.points, after.dimensions) < 1e-12
    assert account.snapped == 1 and account.vertices_snapped > 0 and account.rounds == 1
    assert account.deviation_before.vertices.largest > 1e-5 and account.deviation_after.vertices.largest < 1e-12
    assert [f.number for f in account.deviation_after.faces] == [1, 2, 3]
    assert after.ambiguous_triangles == 0 and after.without_entity == 0
    assert len(after.faces) == len(after.triangles) and set(after.faces) == {1, 2, 3}
    assert sum(after.on_entities) == np.count_nonzero(after.dimensions < 3) and np.all(after.numbers[after.dimensions == 3] == 0)
    assert tetune.validate(result.mesh) == ""
    assert tetune.quality(result.mesh).dihedral_min >= tetune.quality(points, tets).dihedral_min
    assert np.array_equal(model.match(result.mesh).dimensions, after.dimensions)


def test_unit_and_mismatch(cylinder):
    path, points, tets = cylinder
    model = geometry_of(path, unit=1000)
    in_m = tetune.TetMesh(points / 1000, tets)
    assert np.array_equal(model.match(in_m).dimensions, geometry_of(path).match(tetune.TetMesh(points, tets)).dimensions)
    with pytest.raises(tetune.MeshError, match="geometry"):
        tetune.optimize(points, tets, geometry=model, boundary="slide")
    with pytest.raises(tetune.OptionError, match="boundary=slide"):
        tetune.optimize(points, tets, geometry=str(path))
    with pytest.raises(tetune.OptionError, match="exclude"):
        tetune.optimize(points, tets, geometry=str(path), boundary="slide", criteria="abaqus")
    for missing in (str(path) + ".missing.step", path.with_name("missing.step")):
        with pytest.raises(tetune.FileError, match="missing.step"):
            tetune.Geometry(missing)
    assert model.file == str(path)


def test_mid_side_nodes_are_on_the_model(cylinder):
    path, points, tets = cylinder
    model = geometry_of(path)
    mesh = tetune.optimize(points, tets, geometry=model, boundary="slide").mesh
    result = tetune.curve(mesh, geometry=model)
    assert result.report.edges_off_geometry == 0 and len(result.report.straightened) == 0
    middles = result.mesh.curved_middles
    assert len(middles) > 50 and off_cylinder(middles, np.full(len(middles), 2)) < 1e-12
    assert result.report.min_scaled_jacobian > 0.1
    for name in (path, str(path)):
        assert len(tetune.curve(mesh, geometry=name).mesh.curved_middles) == len(middles)
    with pytest.raises(tetune.OptionError, match="exclude"):
        tetune.curve(mesh, geometry=model, surface=mesh)
