// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/constrained_edges.hpp"
#include "core/work_mesh.hpp"
#include "flips/flip.hpp"
#include "relocate/step.hpp"
#include "vertices/angle_ring.hpp"

namespace tetune {

/// Largest cavity, and most faces around one.
inline constexpr int kMaxStarTets = 48;
inline constexpr int kMaxStarFaces = 64;
/// The apex of a star that is a vertex yet to be inserted.
inline constexpr Index kNewVertex = -1;

/// A cavity, and how it is filled from one point, the apex, by a tetrahedron on each face that the apex is not on.
/// Where all these are positive, they fill the cavity and nothing else (docs/method.md, "Vertices inserted and
/// removed"): with a new vertex inside as the apex a vertex is inserted, with one on the cavity of all tetrahedra
/// around a vertex that vertex is removed. In the memory of one thread.
class Star {
 public:
  TETUNE_HD Star(const MeshView& mesh, const ConstrainedEdges& constrained) : mesh_(mesh), constrained_(constrained) {}

  /// Takes all tetrahedra around an edge of t. Like the next two, false where a constraint or the size forbids it.
  TETUNE_HD bool take_edge(Index t, int edge) {
    const EdgeCorners e = edge_corners(edge);
    const Tet tet = mesh_.tet2vertex[t];
    const Links links = mesh_.tet2tet[t];
    if (is_locked(links[e.k]) || is_locked(links[e.l])) return false;
    if (constrained_.contains(tet[e.i], tet[e.j])) return false;
    const Index last = link_tet(links[e.l]);
    tets_[tet_count_++] = t;
    Index behind = tet[e.l];
    Link link = links[e.k];
    for (Index next = link_tet(link);; next = link_tet(link)) {
      if (2 * tet_count_ == kMaxStarFaces) return false;
      tets_[tet_count_++] = next;
      if (next == last) break;
      const Tet there = mesh_.tet2vertex[next];
      const int entry = link_face(link);
      link = mesh_.tet2tet[next][place_of(there, behind)];
      if (is_locked(link)) return false;
      behind = there[entry];
    }
    return find_faces();
  }

  /// Takes all tetrahedra around a vertex of t that is on no surface.
  TETUNE_HD bool take_vertex(Index t, int corner) {
    tets_[tet_count_++] = t;
    return spread(mesh_.tet2vertex[t][corner]);
  }
  /// The same of a vertex of the cavity, beside what it has.
  TETUNE_HD bool spread(Index v) {
    for (int i = 0; i < tet_count_; ++i) {
      const Tet tet = mesh_.tet2vertex[tets_[i]];
      if (tet[place_of(tet, v)] != v) continue;
      const Links links = mesh_.tet2tet[tets_[i]];
      for (int f = 0; f < 4; ++f) {
        if (tet[f] == v) continue;
        if (is_locked(links[f])) return false;
        if (contains(link_tet(links[f]))) continue;
        if (tet_count_ == kMaxStarTets) return false;
        tets_[tet_count_++] = link_tet(links[f]);
      }
    }
    return find_faces();
  }

  /// Takes a cavity that was found before.
  TETUNE_HD bool take(const Index* tets, int count) {
    for (int i = 0; i < count; ++i) tets_[i] = tets[i];
    tet_count_ = count;
    return find_faces();
  }

  TETUNE_HD int tet_count() const { return tet_count_; }
  TETUNE_HD Index tet(int i) const { return tets_[i]; }
  TETUNE_HD int face_count() const { return face_count_; }
  /// A face of the cavity, as the apex sees it.
  TETUNE_HD const LinkFace& face(int i) const { return faces_[i]; }
  /// The same as a face of the tetrahedron of the cavity that has it.
  TETUNE_HD Link side(int i) const { return sides_[i]; }
  TETUNE_HD bool touches(int face, Index vertex) const {
    const LinkFace& f = faces_[face];
    return f.v[0] == vertex || f.v[1] == vertex || f.v[2] == vertex;
  }

  /// Cotangent of the smallest dihedral angle in the cavity as it is.
  TETUNE_HD double cot_before() const {
    double most = -1;
    for (int i = 0; i < tet_count_; ++i) {
      const double cot = largest_cot(mesh_, tets_[i]);
      most = cot > most ? cot : most;
    }
    return most;
  }
  /// The same of the filling from x; `limit` where it is not below that, or where a tetrahedron is not certified
  /// positive or worse than the floor.
  TETUNE_HD double cot_after(Index apex, const Vec3& x, double limit) const {
    double most = -1;
    for (int i = 0; i < face_count_; ++i) {
      if (touches(i, apex)) continue;
      int first = 0;
      const double cot = AngleRing(mesh_, &faces_[i], 1).largest_cot(x, limit, first);
      if (!(cot < limit)) return limit;
      most = cot > most ? cot : most;
    }
    return most;
  }

  /// Moves x to where it sees all faces, by way of the one that it sees least of (relaxation after Motzkin and
  /// Schoenberg). False where it finds no such place.
  TETUNE_HD bool face_all(Vec3& x) const {
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
      double least = 0;
      int lowest = -1;
      for (int i = 0; i < face_count_; ++i) {
        const double above = dot(normal[i], x) - height[i];
        lowest = above < least ? i : lowest;
        least = above < least ? above : least;
      }
      if (lowest < 0) return true;
      x = x - (kOverRelaxation * least) * normal[lowest];
    }
    return false;
  }
  /// Whether all vertices and constrained edges of the cavity, but for the apex inside it, are on its faces.
  TETUNE_HD bool keeps_all(Index apex) const {
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

  /// A place for the apex, from one that sees all faces: where the energy of the filling is less.
  TETUNE_HD Vec3 relax(const Vec3& x) const {
    PlainRing ring(mesh_.law, mesh_.points, faces_, face_count_);
    return NewtonStep{1, kMinGain}(ring, x, Motion{Mobility::free, {}}).position;
  }
  /// The same, the cavity enlarged where that lowers the energy further.
  TETUNE_HD Vec3 settle(Vec3 x) {
    for (int turn = 0; turn < kTurns && grow(x); ++turn) x = relax(x);
    return x;
  }
  /// One with a larger smallest angle.
  TETUNE_HD Vec3 open_angle(Vec3 x) const {
    FreeWay way{{Mobility::free, {}}};
    AngleRing(mesh_, faces_, face_count_).open(x, way, 0);
    return x;
  }

 private:
  static constexpr int kTurns = 3;
  static constexpr int kRelaxations = 30;
  static constexpr double kOverRelaxation = 1.5;
  /// The height over a face that is looked for, in parts of the root of its area.
  static constexpr double kHeight = 0.1;
  /// Part of the energy that a step must promise to take away.
  static constexpr double kMinGain = 1e-3;

  TETUNE_HD bool contains(Index t) const {
    for (int i = 0; i < tet_count_; ++i) {
      if (tets_[i] == t) return true;
    }
    return false;
  }
  TETUNE_HD bool on_face(Index v, Index w) const {
    for (int i = 0; i < face_count_; ++i) {
      if (touches(i, v) && touches(i, w)) return true;
    }
    return false;
  }
  TETUNE_HD int place_of_side(Link side) const {
    int i = 0;
    while (sides_[i] != side) ++i;
    return i;
  }
  TETUNE_HD static LinkFace face_of(const Tet& tet, int f) {
    return {{tet[face_vertex(f, 0)], tet[face_vertex(f, 1)], tet[face_vertex(f, 2)]}};
  }
  TETUNE_HD double energy(const LinkFace& f, const Vec3& x) const {
    const TetEnergy e =
        tet_energy(mesh_.law, x, vec(mesh_.points[f.v[0]]), vec(mesh_.points[f.v[1]]), vec(mesh_.points[f.v[2]]));
    return e.certified ? e.energy : kNever;
  }

  TETUNE_HD bool find_faces() {
    face_count_ = 0;
    for (int i = 0; i < tet_count_; ++i) {
      const Tet tet = mesh_.tet2vertex[tets_[i]];
      const Links links = mesh_.tet2tet[tets_[i]];
      for (int f = 0; f < 4; ++f) {
        if (links[f] != kNoLink && contains(link_tet(links[f]))) {
          if (is_locked(links[f])) return false;
          continue;
        }
        if (face_count_ == kMaxStarFaces) return false;
        faces_[face_count_] = face_of(tet, f);
        sides_[face_count_++] = make_link(tets_[i], f);
      }
    }
    return true;
  }

  /// Takes more tetrahedra into the cavity, across one face at a time, where that lowers the energy of the filling from
  /// x. Whether it took one.
  TETUNE_HD bool grow(const Vec3& x) {
    bool grown = false;
    for (int i = 0; i < face_count_; ++i) {
      while (tet_count_ < kMaxStarTets && face_count_ + 2 <= kMaxStarFaces && grow_across(i, x)) grown = true;
    }
    return grown;
  }

  /// Takes in the tetrahedron across face i if that pays. Its faces towards the cavity go, one or two of them: with
  /// three, a vertex would go as well.
  TETUNE_HD bool grow_across(int i, const Vec3& x) {
    const Link across = mesh_.tet2tet[link_tet(sides_[i])][link_face(sides_[i])];
    if (is_locked(across)) return false;
    const Index t = link_tet(across);
    const int first = link_face(across);
    const Tet tet = mesh_.tet2vertex[t];
    const Links links = mesh_.tet2tet[t];
    int second = -1;
    for (int f = 0; f < 4; ++f) {
      if (f == first || links[f] == kNoLink || !contains(link_tet(links[f]))) continue;
      if (second >= 0 || is_locked(links[f])) return false;
      second = f;
    }
    int other = -1;  // place of the second face
    if (second >= 0) {
      // The edge between the two goes.
      const int k = first * second != 0 ? 0 : first + second == 1 ? 2 : 1;
      if (constrained_.contains(tet[k], tet[6 - first - second - k])) return false;
      other = place_of_side(links[second]);
    }
    double before = energy(faces_[i], x) + energy(face_of(tet, first), vec(mesh_.points[tet[first]]));
    if (second >= 0) before += energy(faces_[other], x);
    double after = 0;
    for (int f = 0; f < 4; ++f) {
      if (f != first && f != second) after += energy(face_of(tet, f), x);
    }
    if (!(after < before)) return false;

    tets_[tet_count_++] = t;
    const int places[3] = {i, second >= 0 ? other : face_count_, face_count_ + 1};
    if (second < 0) face_count_ += 2;
    int n = 0;
    for (int f = 0; f < 4; ++f) {
      if (f == first || f == second) continue;
      faces_[places[n]] = face_of(tet, f);
      sides_[places[n++]] = make_link(t, f);
    }
    return true;
  }

  MeshView mesh_;
  ConstrainedEdges constrained_;
  Index tets_[kMaxStarTets];
  LinkFace faces_[kMaxStarFaces];
  Link sides_[kMaxStarFaces];
  int tet_count_ = 0;
  int face_count_ = 0;
};

}  // namespace tetune
