# SPDX-License-Identifier: Apache-2.0

import numpy as np
import pytest

import tetune
from meshes import BRACKET, shaken_box, smallest_dihedral


def test_options_take_effect():
    points, tets = shaken_box()
    frozen = np.zeros(len(points), dtype=bool)
    frozen[::2] = True
    r = tetune.optimize(points, tets, frozen_vertices=frozen, max_iterations=2, boundary="fixed", max_ring=3)
    assert not r.moved[frozen].any() and r.moved.any()
    r = tetune.optimize(points, tets, frozen_vertices=256 * frozen, max_iterations=2, boundary="fixed")  # any flag other than 0
    assert not r.moved[frozen].any() and r.moved.any()
    r = tetune.optimize(points, tets, frozen_vertices=frozen, max_iterations=2, boundary="fixed", max_ring=3)
    assert len(r.report.sweeps) == 2 and r.report.stop == "iteration limit"
    assert r.report.edge_removals == r.report.face_removals == 0
    tags = (points[tets].mean(axis=1)[:, 0] > 4).astype(int)
    r = tetune.optimize(tetune.TetMesh(points, tets, tet_tags=tags), frozen_regions=[1], max_iterations=np.int64(3))
    assert {tuple(sorted(t)) for t in tets[tags == 1]} == {tuple(sorted(t)) for t in r.mesh.tets[r.mesh.tet_tags == 1]}
    default = tetune.optimize(points, tets).mesh
    for name, value, differs in [
        ("device", "cpu", False), ("boundary", "preserve", False), ("effort", "standard", False),
        ("keep_vertices", True, False), ("feature_angle", 30, False), ("boundary", "slide", True),
        ("energy", "harmonic", True), ("effort", "fast", True), ("relocation", "gradient", True),
        ("termination", "paper", True),
    ]:
        points_now = tetune.optimize(points, tets, **{name: value}).mesh.points
        assert np.array_equal(points_now, default.points) != differs, name
    bracket = tetune.read_mesh(str(BRACKET))
    assert tetune.optimize(bracket).report.boundary_flips > 0
    assert tetune.optimize(bracket, boundary_flips=False).report.boundary_flips == 0
    r = tetune.optimize(points, tets, boundary="slide", max_deviation=1e-3)
    assert r.report.energy_after < r.report.energy_before


def test_the_automatic_device_says_why():
    points, tets = shaken_box(2, 2, 2)
    assert tetune.optimize(points, tets).report.device_reason == ""
    report = tetune.optimize(points, tets, device="auto").report
    assert (report.device, report.device_reason) == ("CPU", "below 500000 tetrahedra")


def test_traced_angles():
    points, tets = shaken_box()
    r = tetune.optimize(points, tets, trace_angles=True)
    last = (r.report.worst_rounds or r.report.sweeps)[-1]
    assert last.dihedral_min == pytest.approx(tetune.quality(r.mesh).dihedral_min, abs=1e-6)
    plain = tetune.optimize(points, tets)
    assert plain.report.sweeps[0].dihedral_min == 0 and np.array_equal(plain.mesh.points, r.mesh.points)


def test_only_below():
    points, tets = shaken_box()
    angles = smallest_dihedral(points, tets)
    limit = float(np.sort(angles)[2:4].mean())
    r = tetune.optimize(points, tets, only_below={"min_dihedral_deg": limit}, rings=0)
    assert r.report.tets_bad == 3 and r.report.tets_active == 3
    rest = angles >= limit
    assert np.array_equal(r.mesh.points[tets[rest]], points[tets[rest]])
    same = tetune.optimize(points, tets, only_below={"min_dihedral_deg": 0.99 * float(angles.min())})
    assert same.report.tets_active == 0 and np.array_equal(same.mesh.tets, tets)


def test_targets():
    points, tets = shaken_box()
    r = tetune.optimize(points, tets, targets={"min_dihedral_deg": 65, "mean_ratio": 1e-3})
    angle, ratio = r.report.targets
    assert not angle.met and angle.measure == "min_dihedral_deg" and angle.value == 65
    assert angle.missed == (smallest_dihedral(r.mesh.points, r.mesh.tets) < 65).sum()
    assert sum(angle.held_by.values()) == angle.missed
    assert angle.worst[0].value == pytest.approx(smallest_dihedral(r.mesh.points, r.mesh.tets).min())
    assert ratio.met


def test_options_without_effect_and_former_names_are_warnings():
    points, tets = shaken_box(2, 2, 2)
    with pytest.warns(UserWarning, match="max_deviation=1 has no effect without boundary=slide"):
        report = tetune.optimize(points, tets, max_deviation=1).report
    assert report.warnings == ["max_deviation=1 has no effect without boundary=slide"]
    with pytest.warns(DeprecationWarning, match="'automatic' is the former name of 'auto'"):
        tetune.optimize(points, tets, device="automatic")
    assert report.sweeps[0].gradient_norm == report.sweeps[0].gradient_norm2


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        ({"max_ring": 9}, tetune.OptionError, "max_ring=9 is out of range: it must be 3 to 7"),
        ({"max_iterations": -1}, tetune.OptionError, "max_iterations=-1 is out of range: it must be 0 or more"),
        ({"max_iterations": 1.5}, tetune.OptionError, "max_iterations is 1.5; it must be an integer"),
        ({"threads": -2}, tetune.OptionError, "threads=-2 is out of range: it must be 0 to 4096"),
        ({"boundary": "Slide"}, tetune.OptionError, "boundary is 'Slide'; it must be one of 'fixed'|boundary is 'Slide'"),
        ({"effort": 3}, tetune.OptionError, "effort is 3; it must be one of 'fast', 'standard', 'best'"),
        ({"frozen_vertices": [1, 0]}, tetune.OptionError, "frozen_vertices has 2 entries"),
        ({"targets": {"minSICN": 1}}, tetune.OptionError, "there is no measure 'minSICN'; the measures are min_dih"),
        ({"targets": 15}, tetune.OptionError, "targets is 15; it must be a dict"),
        ({"device": "cuda"}, tetune.DeviceError, "CUDA"),
        ({"iterations": 3}, TypeError, "optimize() has no option 'iterations'; the options are boundary, feature_angle"),
    ],
)
def test_bad_options(options, kind, message):
    points, tets = shaken_box(2, 2, 2)
    with pytest.raises(kind) as error:
        tetune.optimize(points, tets, **options)
    assert message.split("|")[-1] in str(error.value)


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        (lambda p, t: (p, t[:, :3]), ValueError, "tets has the shape (40, 3); it must be (n, 4)"),
        (lambda p, t: (p[:, :2], t), ValueError, "points has the shape (27, 2); it must be (n, 3)"),
        (lambda p, t: (p, t.astype(float)), TypeError, "tets must be an array of integers"),
        (lambda p, t: (p.astype(str), t), TypeError, "points must be an array of numbers; its type is <U"),
        (lambda p, t: (p, t + 2**33), tetune.MeshError, "tets has 85899345"),
        (lambda p, t: (p, t + 1), tetune.MeshError, "out of range"),
        (lambda p, t: (np.where(p == 1, np.nan, p), t), tetune.MeshError, "finite"),
        (lambda p, t: (np.where(np.arange(27)[:, None] == 13, 3.0, p), t), tetune.MeshError, "inverted"),
    ],
)
def test_bad_meshes(change, kind, message):
    points, tets = shaken_box(2, 2, 2)
    with pytest.raises(kind) as error:
        tetune.optimize(*change(points, tets))
    assert message in str(error.value)


def test_errors_share_a_base():
    for kind in (tetune.MeshError, tetune.OptionError, tetune.FileError, tetune.DeviceError):
        assert issubclass(kind, tetune.Error)
    with pytest.raises(tetune.FileError, match="no-such-file"):
        tetune.read_mesh("no-such-file.mesh")


def test_booleans_of_numpy():
    points, tets = shaken_box()
    kept = tetune.optimize(points, tets, effort="best", keep_vertices=np.bool_(True))
    assert len(kept.vertex_map) == len(points) and (kept.vertex_map >= 0).all()
    assert np.array_equal(kept.mesh.points, tetune.optimize(points, tets, effort="best", keep_vertices=True).mesh.points)
    assert tetune.optimize(points, tets, flips=np.bool_(False)).report.flip_passes == []
    assert tetune.optimize(points, tets, flips=np.bool_(True)).report.flip_passes != []
    for value in (np.int64(1), "yes"):
        with pytest.raises(tetune.OptionError, match="it must be a bool"):
            tetune.optimize(points, tets, flips=value)
