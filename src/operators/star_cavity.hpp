// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mesh/constrained_edges.hpp"
#include "operators/edge_star.hpp"
#include "operators/star_candidate.hpp"
#include "relocation/min_angle_ring.hpp"
#include "relocation/step.hpp"

namespace tetune {

/// A star-shaped cavity, retriangulated from one point, the apex, by a tetrahedron on each face that the apex is not
/// on. Where all these are positive, they fill the cavity and nothing else (docs/method.md, "Insertion and
/// contraction"): with a new vertex inside as the apex a vertex is inserted; with one on the cavity of all tetrahedra
/// around a vertex that vertex is removed. In the memory of one thread.
class StarCavity {
 public:
  TETUNE_HD StarCavity(const RatedMesh& mesh, const ConstrainedEdges& constrained)
      : mesh_(mesh), constrained_(constrained) {}

  /// Takes all tetrahedra around an edge of t. Like the next two, returns false where a constraint or the size forbids
  /// it.
  TETUNE_HD bool take_edge(Index t, int edge) {
    const EdgeCorners e = edge_corners(edge);
    const Tet tet = mesh_.tet2vertex[t];
    const FaceAdjacency links = mesh_.tet2tet[t];
    if (is_locked(links[e.k]) || is_locked(links[e.l])) return false;
    if (constrained_.contains(tet[e.i], tet[e.j])) return false;
    const Index last = tet_of(links[e.l]);
    tets_[tet_count_++] = t;
    for (EdgeWalk walk{tet[e.l], links[e.k]};;) {
      if (2 * tet_count_ == kMaxStarFaces) return false;
      tets_[tet_count_++] = walk.tet();
      if (walk.tet() == last) break;
      if (!walk.step(mesh_)) return false;
    }
    return find_faces();
  }

  /// Takes all tetrahedra around a vertex of t that is on no surface.
  TETUNE_HD bool take_vertex(Index t, int corner) {
    tets_[tet_count_++] = t;
    return take_all_around(mesh_.tet2vertex[t][corner]);
  }
  /// Takes all tetrahedra around a vertex of the cavity, in addition to those it has.
  TETUNE_HD bool take_all_around(Index v) {
    for (int i = 0; i < tet_count_; ++i) {
      const Tet tet = mesh_.tet2vertex[tets_[i]];
      if (tet[local_index(tet, v)] != v) continue;
      const FaceAdjacency links = mesh_.tet2tet[tets_[i]];
      for (int f = 0; f < 4; ++f) {
        if (tet[f] == v) continue;
        if (is_locked(links[f])) return false;
        if (contains(tet_of(links[f]))) continue;
        if (tet_count_ == kMaxStarTets) return false;
        tets_[tet_count_++] = tet_of(links[f]);
      }
    }
    return find_faces();
  }

  TETUNE_HD int tet_count() const { return tet_count_; }
  TETUNE_HD Index tet(int i) const { return tets_[i]; }
  /// The candidate of the retriangulation from x.
  TETUNE_HD StarCandidate candidate(Index apex, Index removed, const Vec3& x) const {
    StarCandidate c;
    c.apex_position = x;
    c.apex = apex;
    c.removed = removed;
    c.tet_count = tet_count_;
    for (int i = 0; i < tet_count_; ++i) {
      c.tets[i] = tets_[i];
      c.outer_faces[i] = 0;
    }
    for (int k = 0; k < face_count_; ++k) {
      int i = 0;
      while (tets_[i] != tet_of(sides_[k])) ++i;
      c.outer_faces[i] = static_cast<std::uint8_t>(c.outer_faces[i] | 1 << face_of(sides_[k]));
    }
    return c;
  }

  /// Cotangent of the smallest dihedral angle in the cavity as it is.
  TETUNE_HD double cot_before() const {
    double max_cot = -1;
    for (int i = 0; i < tet_count_; ++i) {
      const double cot = max_dihedral_cot(mesh_, tets_[i]);
      max_cot = cot > max_cot ? cot : max_cot;
    }
    return max_cot;
  }
  /// That of the retriangulation from x; `limit` where it is not below that, or where a tetrahedron is not certified
  /// positive or worse than the floor.
  TETUNE_HD double cot_after(Index apex, const Vec3& x, double limit) const {
    double max_cot = -1;
    for (int i = 0; i < face_count_; ++i) {
      if (has_vertex(faces_[i], apex)) continue;
      int first = 0;
      const double cot = MinAngleRing(mesh_, &faces_[i], 1).max_dihedral_cot(x, limit, first);
      if (!(cot < limit)) return limit;
      max_cot = cot > max_cot ? cot : max_cot;
    }
    return max_cot;
  }

  /// Moves x into the kernel of the cavity, that is to where all faces are visible, by steps over the plane of the most
  /// violated face (relaxation after Motzkin and Schoenberg). Returns false where it finds no such place.
  TETUNE_HD bool find_kernel_point(Vec3& x) const {
    Vec3 normal[kMaxStarFaces];
    double height[kMaxStarFaces];  // of the plane that x is to be above
    for (int i = 0; i < face_count_; ++i) {
      const Vec3 p = vec(mesh_.points[faces_[i].v[0]]);
      const Vec3 n = opposite_face(p, vec(mesh_.points[faces_[i].v[1]]), vec(mesh_.points[faces_[i].v[2]])).n;
      const double area = norm(n);
      normal[i] = (1 / area) * n;
      height[i] = dot(normal[i], p) + kHeight * std::sqrt(area);
    }
    for (int step = 0; step < kRelaxations; ++step) {
      double min_above = 0;
      int lowest = -1;
      for (int i = 0; i < face_count_; ++i) {
        const double above = dot(normal[i], x) - height[i];
        lowest = above < min_above ? i : lowest;
        min_above = above < min_above ? above : min_above;
      }
      if (lowest < 0) return true;
      x = x - (kOverRelaxation * min_above) * normal[lowest];
    }
    return false;
  }
  /// Whether all vertices and constrained edges of the cavity, except for the apex inside it, are on its faces.
  TETUNE_HD bool preserves_constraints(Index apex) const {
    for (int i = 0; i < tet_count_; ++i) {
      const Tet tet = mesh_.tet2vertex[tets_[i]];
      for (int k = 0; k < 4; ++k) {
        if (tet[k] == apex) continue;
        if (!on_face(tet[k], tet[k])) return false;
        for (int l = 0; l < k; ++l) {
          if (constrained_.contains(tet[k], tet[l]) && !on_face(tet[k], tet[l])) return false;
        }
      }
    }
    return true;
  }

  /// A place for the apex where the energy of the retriangulation is lower, from one in the kernel.
  TETUNE_HD Vec3 relax(const Vec3& x) const {
    PlainRing ring(mesh_.objective, mesh_.points, faces_, face_count_);
    return NewtonStep{1, kMinGain}(ring, x, MotionSpace{VertexDof::free, {}}).position;
  }
  /// Enlarges the cavity and relaxes the apex in turn, while that lowers the energy.
  TETUNE_HD Vec3 relax_and_grow(Vec3 x) {
    for (int round = 0; round < kGrowthRounds && grow(x); ++round) x = relax(x);
    return x;
  }
  /// A place for the apex with a larger smallest angle.
  TETUNE_HD Vec3 open_angle(Vec3 x) const {
    FreeMotion motion{{VertexDof::free, {}}};
    MinAngleRing(mesh_, faces_, face_count_).maximize(x, motion, 0);
    return x;
  }

 private:
  static constexpr int kGrowthRounds = 3;
  static constexpr int kRelaxations = 30;
  static constexpr double kOverRelaxation = 1.5;
  /// The height required over a face, in parts of the square root of its area.
  static constexpr double kHeight = 0.1;
  /// The part of the energy that a step must reduce, by its model.
  static constexpr double kMinGain = 1e-3;

  TETUNE_HD bool contains(Index t) const {
    for (int i = 0; i < tet_count_; ++i) {
      if (tets_[i] == t) return true;
    }
    return false;
  }
  TETUNE_HD bool on_face(Index v, Index w) const {
    for (int i = 0; i < face_count_; ++i) {
      if (has_vertex(faces_[i], v) && has_vertex(faces_[i], w)) return true;
    }
    return false;
  }
  TETUNE_HD int place_of_side(HalfFace side) const {
    int i = 0;
    while (sides_[i] != side) ++i;
    return i;
  }
  TETUNE_HD double energy(const LinkFace& f, const Vec3& x) const {
    const TetEnergy e =
        tet_energy(mesh_.objective, x, vec(mesh_.points[f.v[0]]), vec(mesh_.points[f.v[1]]), vec(mesh_.points[f.v[2]]));
    return e.certified ? e.energy : kInfeasible;
  }

  TETUNE_HD bool find_faces() {
    face_count_ = 0;
    for (int i = 0; i < tet_count_; ++i) {
      const Tet tet = mesh_.tet2vertex[tets_[i]];
      const FaceAdjacency links = mesh_.tet2tet[tets_[i]];
      for (int f = 0; f < 4; ++f) {
        if (links[f] != kNoHalfFace && contains(tet_of(links[f]))) {
          if (is_locked(links[f])) return false;
          continue;
        }
        if (face_count_ == kMaxStarFaces) return false;
        faces_[face_count_] = link_face(tet, f);
        sides_[face_count_++] = make_half_face(tets_[i], f);
      }
    }
    return true;
  }

  /// Takes more tetrahedra into the cavity, across one face at a time, where that lowers the energy of the
  /// retriangulation from x. Returns whether it took one.
  TETUNE_HD bool grow(const Vec3& x) {
    bool grown = false;
    for (int i = 0; i < face_count_; ++i) {
      while (tet_count_ < kMaxStarTets && face_count_ + 2 <= kMaxStarFaces && grow_across(i, x)) grown = true;
    }
    return grown;
  }

  /// Takes the tetrahedron across face i if that lowers the energy. Its faces towards the cavity vanish, one or two of
  /// them: with three, a vertex would vanish as well.
  TETUNE_HD bool grow_across(int i, const Vec3& x) {
    const HalfFace across = mesh_.tet2tet[tet_of(sides_[i])][face_of(sides_[i])];
    if (is_locked(across)) return false;
    const Index t = tet_of(across);
    const int first = face_of(across);
    const Tet tet = mesh_.tet2vertex[t];
    const FaceAdjacency links = mesh_.tet2tet[t];
    int second = -1;
    for (int f = 0; f < 4; ++f) {
      if (f == first || links[f] == kNoHalfFace || !contains(tet_of(links[f]))) continue;
      if (second >= 0 || is_locked(links[f])) return false;
      second = f;
    }
    int other = -1;  // place of the second face
    if (second >= 0) {
      // The edge between the two vanishes.
      const int k = first * second != 0 ? 0 : first + second == 1 ? 2 : 1;
      if (constrained_.contains(tet[k], tet[6 - first - second - k])) return false;
      other = place_of_side(links[second]);
    }
    double before = energy(faces_[i], x) + energy(link_face(tet, first), vec(mesh_.points[tet[first]]));
    if (second >= 0) before += energy(faces_[other], x);
    double after = 0;
    for (int f = 0; f < 4; ++f) {
      if (f != first && f != second) after += energy(link_face(tet, f), x);
    }
    if (!(after < before)) return false;

    tets_[tet_count_++] = t;
    const int places[3] = {i, second >= 0 ? other : face_count_, face_count_ + 1};
    if (second < 0) face_count_ += 2;
    int n = 0;
    for (int f = 0; f < 4; ++f) {
      if (f == first || f == second) continue;
      faces_[places[n]] = link_face(tet, f);
      sides_[places[n++]] = make_half_face(t, f);
    }
    return true;
  }

  RatedMesh mesh_;
  ConstrainedEdges constrained_;
  Index tets_[kMaxStarTets];
  LinkFace faces_[kMaxStarFaces];
  HalfFace sides_[kMaxStarFaces];
  int tet_count_ = 0;
  int face_count_ = 0;
};

}  // namespace tetune
