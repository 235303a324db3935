# SPDX-License-Identifier: Apache-2.0
"""Acceptance criteria, and their measures against those of VTK."""

import numpy as np
import pytest
import tetune
from meshes import shaken_box


def needs_files(folder):
    """Skips a test where the package was built without toml++."""
    file = folder / "needs.toml"
    file.write_text("[edge_ratio]\nfail = 100\n")
    try:
        points, tets = shaken_box()
        tetune.check(points, file, tets=tets)
    except tetune.FileError as e:
        if "reads no criteria files" in str(e):
            pytest.skip("toml++ was not installed")
        raise


def test_presets_and_dicts(tmp_path):
    points, tets = shaken_box()
    for name in ("abaqus", "ansys", "calculix", "fluent", "nastran", "openfoam"):
        report = tetune.check(points, name, tets=tets)
        assert report.name == name and report.verdict in ("pass", "warn", "fail") and len(report.results) > 0
        assert all(r.source for r in report.results)
    limits = {"mean_ratio": {"warn": 0.99, "fail": 0.01, "allowed_percent": 50}, "edge_ratio": {"fail": 1.01}}
    report = tetune.check(points, limits, tets=tets)
    ratio, edges = report.results
    assert report.verdict == edges.verdict == "fail" and edges.failed == edges.count == len(tets)
    assert ratio.verdict == "warn" and ratio.warn == 0.99 and ratio.allowed_percent == 50
    worst = tetune.measure_each(points, tets)["mean_ratio"]
    assert ratio.worst == worst.min() and ratio.worst_tet == worst.argmin()
    needs_files(tmp_path)
    file = tmp_path / "mine.toml"
    file.write_text("[edge_ratio]\nfail = 1.01\nsource = 'ours'\n")
    from_file = tetune.check(points, file, tets=tets)
    assert from_file.name == "mine.toml" and from_file.verdict == "fail" and from_file.results[0].source == "ours"
    assert from_file.results[0].warn is None


def test_optimize_towards_criteria():
    points, tets = shaken_box()
    plain = tetune.optimize(points, tets)
    assert plain.criteria is None
    reached = tetune.check(plain.mesh, {"mean_ratio": {"fail": 0.0}}).results[0].worst
    limits = {"mean_ratio": {"fail": reached + 1e-3}, "edge_ratio": {"fail": 1.01}}
    result = tetune.optimize(points, tets, criteria=limits)
    assert (result.criteria.before.verdict, result.criteria.after.verdict) == ("fail", "fail")
    assert result.criteria.no_rounds == "" and len(result.criteria.rounds) > 0
    first = result.criteria.rounds[0]
    assert first.rings == 2 and first.active > 0 and first.failed_after <= first.failed_before
    judged = tetune.check(result.mesh, limits)
    assert [r.worst for r in judged.results] == [r.worst for r in result.criteria.after.results]
    edges = next(x for x in result.criteria.limits if x.measure == "edge_ratio")
    assert edges.fail == 1.01 and sum(edges.held_by.values()) == judged.results[1].failed
    assert edges.worst[0].value == judged.results[1].worst and edges.worst[0].held_by in edges.held_by
    assert len(result.parent) == len(result.mesh.tets) and result.report.tets_after == len(result.mesh.tets)
    stopped = tetune.optimize(points, tets, criteria=limits, progress=lambda _: False)
    assert stopped.report.stop == "cancelled" and len(stopped.criteria.rounds) == 0
    assert tetune.optimize(points, tets, criteria="openfoam").criteria.after.name == "openfoam"
    with pytest.raises(tetune.OptionError, match="did you mean 'collapse'"):
        tetune.optimize(points, tets, criteria={"colapse": {"warn": 1}})


def test_optimize_grids_towards_criteria():
    pv = pytest.importorskip("pyvista")
    points, tets = shaken_box()
    cells = np.hstack([np.full((len(tets), 1), 4), tets]).ravel()
    grid = pv.UnstructuredGrid(cells, np.full(len(tets), pv.CellType.TETRA), points)
    result = grid.tetune.run(criteria={"edge_ratio": {"fail": 100}})
    assert isinstance(result.mesh, pv.UnstructuredGrid) and result.criteria.after.verdict == "pass"
    assert grid.tetune.optimize(criteria="abaqus").n_points == len(points)


def test_errors(tmp_path):
    points, tets = shaken_box()
    needs_files(tmp_path)
    file = tmp_path / "mine.toml"
    file.write_text("[mean_ratio]\nwarn = 0.2\n[edge_ration]\nfail = 2\n")
    with pytest.raises(tetune.FileError, match=r"mine.toml:3: .*'edge_ration'; did you mean 'edge_ratio'\?"):
        tetune.check(points, file, tets=tets)
    with pytest.raises(tetune.FileError, match="did you mean 'abaqus'"):
        tetune.check(points, "abacus", tets=tets)
    with pytest.raises(tetune.OptionError, match="did you mean 'collapse'"):
        tetune.check(points, {"colapse": {"warn": 1}}, tets=tets)
    with pytest.raises(tetune.OptionError, match="'limit'"):
        tetune.check(points, {"collapse": {"limit": 1}}, tets=tets)
    with pytest.raises(tetune.OptionError, match="no limit"):
        tetune.check(points, {"collapse": {}}, tets=tets)


def test_measures_of_vtk():
    vtk = pytest.importorskip("vtk")
    random = np.random.default_rng(3)
    names = {"equiangle_skew": "TetEquiangleSkew", "volume_skew": "TetEquivolumeSkew", "edge_ratio": "TetEdgeRatio",
             "volume": "TetVolume"}
    for i in range(60):
        points = random.uniform(-1, 1, (4, 3)) * [1, 1, 0.1 if i % 2 else 1]
        edges = points[1:] - points[0]
        if np.linalg.det(edges) < 0:
            points[[2, 3]] = points[[3, 2]]
        cell = vtk.vtkTetra()
        for k in range(4):
            cell.GetPointIds().SetId(k, k)
            cell.GetPoints().SetPoint(k, points[k])
        limits = {name: {"warn": 2.0} for name in names}
        report = tetune.check(points, limits, tets=np.array([[0, 1, 2, 3]]))
        for result in report.results:
            expected = getattr(vtk.vtkMeshQuality, names[result.measure])(cell)
            assert result.worst == pytest.approx(expected, rel=1e-9, abs=1e-12), result.measure
