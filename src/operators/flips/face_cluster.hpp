// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/criterion.hpp"
#include "energy/harmonic.hpp"
#include "mesh/constrained_edges.hpp"
#include "operators/flips/flip_candidate.hpp"

/// The faces of a face removal: those that lie between the same two vertices a and b. Two that share an edge have four
/// tetrahedra around it, so clusters grow from a face across such edges. Each edge of a cluster carries one new
/// tetrahedron, each face two old ones: the gain of a cluster is a sum over a tree, and its best part that has the
/// first face is found from the leaves (Shewchuk, "Two discrete optimization algorithms for the topological improvement
/// of tetrahedral meshes", 2002).
namespace tetune {

/// The cluster around one face, in the memory of one thread.
class FaceCluster {
 public:
  TETUNE_HD FaceCluster(const RatedMesh& mesh, const ConstrainedEdges& constrained)
      : mesh_(mesh), constrained_(constrained) {}

  /// Starts from face `face` of t, which must not be locked, and takes at most `max_faces` faces. Returns false where
  /// no two others are beside it: of a cluster of three or more faces at least one has two beside it, and smaller ones
  /// are other flips.
  TETUNE_HD bool grow(Index t, int face, int max_faces) {
    const HalfFace shared = mesh_.tet2tet[t][face];
    const Tet tet = mesh_.tet2vertex[t];
    a_ = tet[face];
    b_ = mesh_.opposite_vertex(shared);
    Index v[3];
    for (int k = 0; k < 3; ++k) v[k] = tet[face_vertex(face, k)];
    add({t, tet_of(shared)}, v);
    for (int side = 0; side < 3; ++side) take_beyond(0, side, max_faces);
    if (count_ < 3) return false;
    for (int i = 1; i < count_; ++i) {
      for (int side = 1; side < 3; ++side) take_beyond(i, side, max_faces);
    }
    return true;
  }

  /// Finds the best part of the cluster that has the first face. Returns by how much its removal changes the energy: a
  /// number near kInfeasible or above where each of these parts leaves a volume that is not certified.
  TETUNE_HD double best_subtree(Span<const double> energies) {
    for (int i = count_ - 1; i >= 0; --i) {
      Face& f = faces_[i];
      f.change = -(energies[f.tets[0]] + energies[f.tets[1]]);
      for (int side = i == 0 ? 0 : 1; side < 3; ++side) {
        const double kept = energy_at(f.v[side], f.v[after(side)]);
        const double beyond = f.beyond[side] > 0 ? faces_[f.beyond[side]].change : kInfeasible;
        if (!(beyond < kept)) f.beyond[side] = 0;
        f.change += beyond < kept ? beyond : kept;
      }
    }
    return faces_[0].change;
  }

  /// After best_subtree(), the removal of that part.
  TETUNE_HD FlipCandidate candidate() const {
    FlipCandidate c;
    c.kind = FlipKind::face_removal;
    c.a = a_;
    c.b = b_;
    c.ring_size = 0;
    // Around the cluster, depth first: beyond a side before the next side.
    int used[kMaxRemovedFaces];
    int faces = 0;
    struct Step {
      int face, side;
    } path[kMaxRemovedFaces];
    int depth = 0;
    path[0] = {0, 0};
    used[faces++] = 0;
    while (depth >= 0) {
      Step& s = path[depth];
      if (s.side == 3) {
        --depth;
        continue;
      }
      const Face& f = faces_[s.face];
      const int side = s.side++;
      if (f.beyond[side] > 0) {
        used[faces++] = f.beyond[side];
        path[++depth] = {f.beyond[side], 1};
      } else {
        c.ring[c.ring_size++] = f.v[side];
      }
    }
    for (int s = 0; s < faces; ++s) {
      const Face& f = faces_[used[s]];
      std::uint8_t place[3];
      for (int k = 0; k < 3; ++k) {
        place[k] = 0;
        while (c.ring[place[k]] != f.v[k]) ++place[k];
      }
      // In the order of the ring, from the lowest place on.
      int lowest = place[1] < place[0] ? 1 : 0;
      if (place[2] < place[lowest]) lowest = 2;
      for (int k = 0; k < 3; ++k) c.triangulation.corner[s][k] = place[(lowest + k) % 3];
      c.tets[2 * s] = f.tets[0];
      c.tets[2 * s + 1] = f.tets[1];
    }
    return c;
  }

 private:
  /// A face (v0, v1, v2), (a, v0, v1, v2) positive. Side k is from v_k to the next; side 0 leads to the parent.
  struct Face {
    Index v[3];
    Index tets[2];  ///< on the side of a and of b
    int beyond[3];  ///< the face beyond each side; 0: none
    double change;  ///< of the energy, at best, when this face and those beyond it are removed
  };
  struct Tets {
    Index above, below;
  };

  TETUNE_HD static int after(int side) { return side < 2 ? side + 1 : 0; }

  TETUNE_HD void add(const Tets& tets, const Index v[3]) {
    Face& f = faces_[count_++];
    for (int k = 0; k < 3; ++k) {
      f.v[k] = v[k];
      f.beyond[k] = 0;
    }
    f.tets[0] = tets.above;
    f.tets[1] = tets.below;
  }

  /// Takes the face beyond a side of face i, where it lies between a and b as well.
  TETUNE_HD void take_beyond(int i, int side, int max_faces) {
    const Face& f = faces_[i];
    const Index opposite = f.v[side == 0 ? 2 : side - 1];
    const HalfFace above = across(f.tets[0], opposite);
    const HalfFace below = across(f.tets[1], opposite);
    if (count_ == max_faces || is_locked(above) || is_locked(below)) return;
    const Tet tet = mesh_.tet2vertex[tet_of(above)];
    const Index apex = tet[face_of(above)];
    if (mesh_.opposite_vertex(below) != apex) return;
    // In a mesh that overlaps itself the two need not lie on one face.
    const HalfFace between = mesh_.tet2tet[tet_of(above)][local_index(tet, a_)];
    if (is_locked(between) || tet_of(between) != tet_of(below)) return;
    for (int k = 0; k < count_; ++k) {
      if (faces_[k].tets[0] == tet_of(above)) return;
    }
    if (constrained_.contains(f.v[side], f.v[after(side)])) return;
    const Index v[3] = {f.v[after(side)], f.v[side], apex};
    faces_[i].beyond[side] = count_;
    add({tet_of(above), tet_of(below)}, v);
  }
  TETUNE_HD HalfFace across(Index t, Index opposite) const {
    return mesh_.tet2tet[t][local_index(mesh_.tet2vertex[t], opposite)];
  }

  TETUNE_HD double energy_at(Index from, Index to) const {
    const TetEnergy e = tet_energy(mesh_.objective, vec(mesh_.points[a_]), vec(mesh_.points[from]),
                                   vec(mesh_.points[to]), vec(mesh_.points[b_]));
    return e.certified ? e.energy : kInfeasible;
  }

  RatedMesh mesh_;
  ConstrainedEdges constrained_;
  Index a_, b_;
  Face faces_[kMaxRemovedFaces];
  int count_ = 0;
};

}  // namespace tetune
