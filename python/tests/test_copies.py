# SPDX-License-Identifier: Apache-2.0
import copy
import pickle
import warnings

import numpy as np
import pytest

import tetune
from meshes import everything_of, inverted_pyramid, shaken_box, volumes


GROUPS_AND_MORE = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 7 "wall"
3 1 "steel"
3 2 "air"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 1 1 1
$EndNodes
$Elements
4
1 2 2 7 3 1 2 3
2 4 2 1 1 1 2 3 4
3 4 2 2 2 2 3 4 5
4 15 2 0 9 5
$EndElements
$Periodic
1
0 1 2
1
2 1
$EndPeriodic
$NodeData
1
"heat"
1
0.0
3
0
1
5
1 1.5
2 2.5
3 3.5
4 4.5
5 5.5
$EndNodeData
"""


def full_mesh(tmp_path):
    """A mesh with groups, data, tags, periodic links, and more."""
    (tmp_path / "in.msh").write_text(GROUPS_AND_MORE)
    return tetune.read_mesh(tmp_path / "in.msh")


def test_groups(tmp_path):
    groups = full_mesh(tmp_path).groups
    assert sorted(groups) == [("air", 3, [2]), ("steel", 3, [1]), ("wall", 2, [7])]
    assert tetune.TetMesh(*shaken_box(2, 2, 2)).groups == []


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))])
def test_copies_of_meshes(tmp_path, copied):
    mesh = full_mesh(tmp_path)
    assert len(mesh.periodic) == 1 and len(mesh.others) == 1 and len(mesh.groups) == 3
    points, tets = shaken_box(2, 2, 2)
    listed = tetune.TetMesh(
        points, tets, point_tags=np.arange(len(points)), tet_tags=np.arange(len(tets)), triangles=[tets[0][:3]], triangle_tags=[4],
        edges=[[0, 1], [1, 2]], edge_tags=[5, 6], corners=[0], required_vertices=[13], ridges=[1], required_edges=[0],
        required_triangles=[0], required_tets=[3, 4], curved_edges=[[0, 1]], curved_middles=[[0.5, 0.1, 0]])
    for m in (mesh, listed, tetune.TetMesh(points, tets[:, [0, 1, 3, 2]])):
        other = copied(m)
        assert everything_of(other) == everything_of(m) and not np.shares_memory(other.points, m.points)
        # All that a file can hold, as data: each text is the same to the byte.
        for name in ("a.msh", "a.mesh"):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                written = [(tetune.write_mesh(tmp_path / name, x), (tmp_path / name).read_bytes())[1] for x in (m, other)]
            assert written[0] == written[1] and len(written[0]) > 100
    assert b'"heat"' in (tetune.write_mesh(tmp_path / "b.msh", copied(mesh)), (tmp_path / "b.msh").read_bytes())[1]


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))])
def test_copies_keep_the_numbers_of_nodes(tmp_path, copied):
    (tmp_path / "in.bdf").write_text("GRID,10\nGRID,20,,1.\nGRID,30,,,1.\nGRID,40,,,,1.\nCTETRA,1,1,10,20,30,40\nENDDATA\n")
    tetune.write_mesh(tmp_path / "out.bdf", copied(tetune.read_mesh(tmp_path / "in.bdf")))
    assert "      10      20      30      40" in (tmp_path / "out.bdf").read_text()


@pytest.mark.filterwarnings("ignore:max_deviation")
def test_reports_and_results_are_pickled():
    points, tets = shaken_box()
    tags = (points[tets].mean(axis=1)[:, 0] > 4).astype(int)
    mesh = tetune.TetMesh(points, tets, tet_tags=tags)
    corner = np.flatnonzero((tets == 0).any(axis=1))[0]  # the middle of an edge folds a triangle of the bottom
    a, b, c = (v for v in tets[corner] if points[v, 2] == 0)
    folded = tetune.TetMesh(points, tets, curved_edges=[sorted([a, b])], curved_middles=[points[[a, b]].mean(axis=0) * 0.45 + points[c] * 0.55])
    inside = tets[volumes(points, tets).argmax()][:3]
    linked = tetune.TetMesh(points, tets, triangles=[inside, [0, 1, 10]], triangle_tags=[0, 7], edges=[[0, 1], [0, 100]],
                            edge_tags=[0, 0], corners=np.arange(len(points)))
    linked.link_box_faces("x")
    results = [
        tetune.optimize(mesh, effort="best", data="interpolate", targets={"min_dihedral_deg": 60}, trace_angles=True),
        tetune.optimize(mesh, only_below={"min_dihedral_deg": 20}, boundary="slide", max_deviation=0.1),
        tetune.optimize(folded, untangle=True, straighten=True),
        tetune.optimize(mesh, only_below={"min_dihedral_deg": 1}, data="conserve"),
        tetune.optimize(linked, max_deviation=1, device="auto"),
        tetune.move(points, tets, points * [-1, 1, 1] + [8, 0, 0]),
    ]
    for r in results:
        back = pickle.loads(pickle.dumps(r))
        assert type(back) is type(r)
        assert everything_of(back.report) == everything_of(r.report) and everything_of(back.mesh) == everything_of(r.mesh)
        assert np.array_equal(back.moved, r.moved) and np.array_equal(back.parent, r.parent)
    report = results[0].report
    assert len(report.targets[0].worst) > 1 and len(report.place_vertices) > 0 and len(report.worst_rounds) > 0 < len(report.flip_passes)
    listed = results[4].report
    assert listed.periodic_vertices > 0 < listed.triangles_dropped == listed.edges_dropped and listed.warnings and listed.device_reason
    motion = results[5].motion
    assert len(results[2].report.straightened) > 0 and len(motion.blocking_tets) > 0
    assert everything_of(pickle.loads(pickle.dumps(motion))) == everything_of(motion)
    mesh, to = inverted_pyramid()
    motion = tetune.move(mesh, to=to, frozen_vertices=np.arange(len(to)) == len(to) - 1).motion
    assert len(motion.inverted_others) == motion.frozen_moved == 1
    assert everything_of(pickle.loads(pickle.dumps(motion))) == everything_of(motion)


def test_what_is_not_pickled(tmp_path):
    (tmp_path / "in.inp").write_text("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n** end\n")
    deck = tetune.read_mesh(tmp_path / "in.inp")
    with pytest.raises(TypeError, match="the text of a deck"):
        pickle.dumps(deck)
    tetune.write_mesh(tmp_path / "out.inp", copy.deepcopy(deck))
    assert (tmp_path / "out.inp").read_text().endswith("** end\n")
    mesh = tetune.TetMesh(*shaken_box(2, 2, 2))
    state = mesh.__getstate__()
    for wrong, said in ((state[:-10], "ends early"), (b"", "ends early"), (state.replace(b"tetune ", b"tetunf "), "not one of tetune")):
        with pytest.raises(ValueError, match=said):
            tetune.TetMesh.__new__(tetune.TetMesh).__setstate__(wrong)
