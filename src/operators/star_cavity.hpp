// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/ring_of.hpp"
#include "mesh/constrained_edges.hpp"
#include "mesh/small_set.hpp"
#include "operators/edge_star.hpp"
#include "operators/kernel_point.hpp"
#include "operators/star_candidate.hpp"
#include "relocation/angle_cost_ring.hpp"
#include "relocation/step.hpp"

namespace tetune {

/// A star-shaped cavity, retriangulated from one point, the apex, by a tetrahedron on each face that the apex is not
/// on. Where all these are positive, they fill the cavity and nothing else (docs/method.md, "Insertion and
/// contraction"): with a new vertex inside as the apex a vertex is inserted; with one on the cavity of all tetrahedra
/// around a vertex that vertex is removed.
///
/// A cavity of all tetrahedra around a simplex of the surface also replaces the surface triangles that contain it. With
/// an apex in their planes the surface keeps its shape; with another, on a curved surface, it bends within a bound
/// (SurfaceBend). Each thread of a team has the cavity in its own memory.
class StarCavity {
 public:
  TETUNE_HD StarCavity(const RatedMesh& mesh, const ConstrainedEdges& constrained)
      : mesh_(mesh), constrained_(constrained) {}

  /// Takes all tetrahedra around an edge of t. Like the next two, returns false if it may not.
  TETUNE_HD bool take_edge(Index t, int edge) {
    const EdgeCorners e = edge_corners(edge);
    const Tet tet = mesh_.tet2vertex[t];
    const FaceAdjacency links = mesh_.tet2tet[t];
    if (is_locked(links[e.k]) || is_locked(links[e.l])) return false;
    if (constrained_.contains(tet[e.i], tet[e.j])) return false;
    const Index last = tet_of(links[e.l]);
    tets_.add(t);
    for (EdgeWalk walk{tet[e.l], links[e.k]};;) {
      if (2 * tets_.size() == kMaxStarFaces) return false;
      tets_.add(walk.tet());
      if (walk.tet() == last) break;
      if (!walk.step(mesh_)) return false;
    }
    return find_faces();
  }

  /// Takes t alone.
  TETUNE_HD bool take_tet(Index t) {
    tets_.add(t);
    return find_faces();
  }
  /// Takes all tetrahedra around a vertex of t that is on no surface.
  TETUNE_HD bool take_vertex(Index t, int corner) {
    tets_.add(t);
    return take_all_around(mesh_.tet2vertex[t][corner]);
  }
  /// Takes all tetrahedra around a simplex of the surface of which t is one, on all sides of interfaces too.
  TETUNE_HD bool take_surface(Index t, const SurfaceSimplex& simplex) {
    simplex_ = simplex;
    tets_.add(t);
    for (int i = 0; i < tets_.size(); ++i) {
      const Tet tet = mesh_.tet2vertex[tets_[i]];
      for (int f = 0; f < 4; ++f) {
        if (!simplex.is_on_face(tet, f)) continue;
        const HalfFace across = mesh_.tet2tet[tets_[i]][f];
        if (across != kNoHalfFace && !tets_.contains(tet_of(across))) {
          if (tets_.is_full()) return false;
          tets_.add(tet_of(across));
        }
        if (!is_locked(across) || (across != kNoHalfFace && tet_of(across) < tets_[i])) continue;
        if (base_count_ == kMaxStarTriangles) return false;
        bases_[base_count_++] = link_face(tet, f);
      }
    }
    return base_count_ > 0 && find_faces();
  }
  /// Takes all tetrahedra around a vertex of the cavity, in addition to those it has.
  TETUNE_HD bool take_all_around(Index v) {
    for (int i = 0; i < tets_.size(); ++i) {
      const Tet tet = mesh_.tet2vertex[tets_[i]];
      if (tet[local_index(tet, v)] != v) continue;
      const FaceAdjacency links = mesh_.tet2tet[tets_[i]];
      for (int f = 0; f < 4; ++f) {
        if (tet[f] == v) continue;
        if (is_locked(links[f])) return false;
        if (tets_.contains(tet_of(links[f]))) continue;
        if (tets_.is_full()) return false;
        tets_.add(tet_of(links[f]));
      }
    }
    return find_faces();
  }

  TETUNE_HD int tet_count() const { return tets_.size(); }
  /// The surface triangles that the cavity replaces.
  TETUNE_HD int base_count() const { return base_count_; }
  TETUNE_HD const LinkFace& base(int i) const { return bases_[i]; }
  /// Restricts the motion of the apex; on the reference surface where it has a surface point.
  TETUNE_HD void restrict_apex(const NewVertexDof& dof, const ReferenceView& reference) {
    motion_ = {{{dof.dof, dof.axis}}, {reference, {}, dof.dof, dof.surface_point, dof.surface_point}};
  }
  TETUNE_HD bool has_free_apex() const { return motion_.free.space.dof == VertexDof::free && !motion_.slides(); }
  /// The place of the apex on the reference surface.
  TETUNE_HD const SurfacePoint& surface_point() const { return motion_.slide.surface_point; }
  /// Whether no face with a vertex as the apex ends at an edge of a replaced triangle: it would become a part of the
  /// surface.
  TETUNE_HD bool keeps_faces_of(Index apex) const {
    for (int i = 0; i < face_count_; ++i) {
      const LinkFace& f = faces_[i];
      for (int k = 0; k < 3; ++k) {
        if (f.v[k] == apex && is_base_edge(f.v[(k + 1) % 3], f.v[(k + 2) % 3])) return false;
      }
    }
    return true;
  }
  TETUNE_HD Index tet(int i) const { return tets_[i]; }
  TETUNE_HD int face_count() const { return face_count_; }
  TETUNE_HD const LinkFace& face(int i) const { return faces_[i]; }
  /// The energy of a tetrahedron on a face with its fourth vertex at x.
  TETUNE_HD double energy(const LinkFace& f, const Vec3& x) const {
    const Span<const Point> p = mesh_.points;
    const TetEnergy e = tet_energy(mesh_.objective, x, vec(p[f.v[0]]), vec(p[f.v[1]]), vec(p[f.v[2]]));
    return e.certified ? e.energy : kInfeasible;
  }
  /// The candidate of the retriangulation from x.
  TETUNE_HD StarCandidate candidate(Index apex, Index removed, const Vec3& x) const {
    StarCandidate c;
    c.apex_position = x;
    c.apex = apex;
    c.removed = removed;
    c.is_moved = false;
    c.tet_count = tets_.size();
    c.simplex = simplex_;
    for (int i = 0; i < tets_.size(); ++i) c.tets[i] = tets_[i];
    for (int i = 0; i < tets_.size(); ++i) c.outer_faces[i] = 0;
    for (int k = 0; k < face_count_; ++k) {
      const int i = tets_.find(tet_of(sides_[k]));
      c.outer_faces[i] = static_cast<std::uint8_t>(c.outer_faces[i] | 1 << face_of(sides_[k]));
    }
    return c;
  }

  /// The largest cost of the dihedral angles (DihedralCots::cost()) in the cavity as it is.
  template <class Team = backend::SingleThread>
  TETUNE_HD double cost_before(const Team& team = {}) const {
    backend::Max largest{-1};
    for (int i = team.rank(); i < tets_.size(); i += Team::kSize) {
      largest.merge({dihedral_cots(mesh_, tets_[i]).cost(mesh_.obtuse_weight)});
    }
    return team.merge(largest).value;
  }
  /// That of the retriangulation from x; `limit` where it is not below that, or where a tetrahedron is not certified
  /// positive or worse than the floor.
  template <class Team = backend::SingleThread>
  TETUNE_HD double cost_after(Index apex, const Vec3& x, double limit, bool keeps_floor = false,
                              const Team& team = {}) const {
    if (apex == kNewVertex) {
      int first = 0;
      return AngleCostRing(mesh_, faces_, face_count_, keeps_floor).largest_cost(x, limit, first, team);
    }
    backend::Max largest{-1};
    for (int begin = 0; begin < face_count_; begin += Team::kSize) {
      const int i = begin + team.rank();
      bool fails = false;
      if (i < face_count_ && !has_vertex(faces_[i], apex)) {
        int first = 0;
        const double cost = AngleCostRing(mesh_, &faces_[i], 1, keeps_floor).largest_cost(x, limit, first);
        largest.merge({cost});
        fails = !(cost < limit);
      }
      if (team.any(fails)) return limit;
    }
    return team.merge(largest).value;
  }

  /// move_into_kernel() of the cavity's faces.
  template <class Team = backend::SingleThread>
  TETUNE_HD bool find_kernel_point(Vec3& x, const Team& team = {}) const {
    return move_into_kernel<kMaxStarFaces>(mesh_.points, faces_, face_count_, x, team);
  }
  /// Whether all vertices and constrained edges of the cavity, except for the apex inside it, are on its faces.
  template <class Team = backend::SingleThread>
  TETUNE_HD bool preserves_constraints(Index apex, const Team& team = {}) const {
    bool preserves = true;
    for (int i = team.rank(); i < tets_.size() && preserves; i += Team::kSize) {
      preserves = preserves_constraints_of(mesh_.tet2vertex[tets_[i]], apex);
    }
    return !team.any(!preserves);
  }

  /// A place for the apex where the energy is lower, from one in the kernel; x itself where the apex slides.
  template <class Team = backend::SingleThread>
  TETUNE_HD Vec3 relax(const Vec3& x, const Team& = {}) const {
    if (motion_.slides()) return x;
    RingOfTeam<Team> ring(mesh_.objective, mesh_.points, faces_, face_count_);
    return NewtonStep{1, kMinGain}(ring, x, motion_.free.space).position;
  }
  /// Enlarges the cavity and relaxes the apex in turn, while that lowers the energy.
  template <class Team = backend::SingleThread>
  TETUNE_HD Vec3 relax_and_grow(Vec3 x, const Team& team = {}) {
    for (int round = 0; round < kGrowthRounds && grow(x, team); ++round) x = relax(x, team);
    return x;
  }
  /// Enlarges the cavity across the face whose new tetrahedron costs most, until all cost less than `limit` with the
  /// apex at x. Returns false where a constraint or the size forbids it.
  template <class Team = backend::SingleThread>
  TETUNE_HD bool grow_below(Index apex, const Vec3& x, double limit, const Team& team = {}) {
    // Face i belongs to thread i % kSize of the team.
    double costs[(kMaxStarFaces + Team::kSize - 1) / Team::kSize];
    find_costs(apex, x, costs, team);
    for (int step = 0; step < kMaxStarTets; ++step) {
      backend::IndexedMax worst{-1, kMaxStarFaces};  // the last of equals: indices count from the last face on
      for (int i = team.rank(); i < face_count_; i += Team::kSize) {
        const double cost = costs[i / Team::kSize];
        if (cost >= limit) worst.merge({cost, kMaxStarFaces - 1 - i});
      }
      worst = team.merge(worst);
      if (worst.index == kMaxStarFaces) return true;
      const Growth g = has_room() ? growth_across(kMaxStarFaces - 1 - worst.index) : Growth{};
      if (g.t < 0) return false;
      const int places[3] = {g.face, g.second >= 0 ? g.other : face_count_, face_count_ + 1};
      take(g);
      for (int k = 0; k < (g.second >= 0 ? 2 : 3); ++k) {
        if (places[k] % Team::kSize == team.rank()) costs[places[k] / Team::kSize] = face_cost(apex, x, places[k]);
      }
    }
    return false;
  }
  /// A place for the apex where the largest cost of the angles is lower; `model` as in AngleCostRing::minimize().
  template <class Team = backend::SingleThread>
  TETUNE_HD Vec3 lower_cost(Vec3 x, MinimaxModel& model, const Team& team = {}) {
    AngleCostRing(mesh_, faces_, face_count_, false).minimize(x, motion_, 0, model, team);
    return x;
  }

 private:
  /// The cost of the new tetrahedron at a face; -1 where the apex is on it.
  TETUNE_HD double face_cost(Index apex, const Vec3& x, int face) const {
    int first = 0;
    return has_vertex(faces_[face], apex)
               ? -1
               : AngleCostRing(mesh_, &faces_[face], 1, false).largest_cost(x, kInfeasible, first);
  }
  /// face_cost() of the faces of this thread.
  template <class Team>
  TETUNE_HD void find_costs(Index apex, const Vec3& x, double* costs, const Team& team) const {
    using Pack = backend::TermsOf<Team>;
    if constexpr (kLanesOf<Pack> != 1) {
      const AngleCostRing ring(mesh_, faces_, face_count_, false);
      for (int begin = 0; begin < face_count_; begin += kLanesOf<Pack>) {
        const Pack pack = ring.template costs_of<Pack>(x, begin);
        for (int l = 0; l < kLanesOf<Pack> && begin + l < face_count_; ++l) {
          const bool is_at_apex = has_vertex(faces_[begin + l], apex);
          costs[begin + l] = is_at_apex ? -1 : pack[l] < kInfeasible ? pack[l] : kInfeasible;
        }
      }
    } else {
      for (int i = team.rank(); i < face_count_; i += Team::kSize) costs[i / Team::kSize] = face_cost(apex, x, i);
    }
  }

  static constexpr int kGrowthRounds = 3;
  /// The part of the energy that a step must reduce, by its model.
  static constexpr double kMinGain = 1e-3;

  /// Whether the edge is one of a replaced triangle, opposite a vertex of the simplex.
  TETUNE_HD bool is_base_edge(Index a, Index b) const {
    for (int i = 0; i < base_count_; ++i) {
      if (!has_vertex(bases_[i], a) || !has_vertex(bases_[i], b)) continue;
      for (const Index v : bases_[i].v) {
        if (v != a && v != b && simplex_.has(v)) return true;
      }
    }
    return false;
  }
  /// preserves_constraints() for one tetrahedron of the cavity.
  TETUNE_HD bool preserves_constraints_of(const Tet& tet, Index apex) const {
    for (int k = 0; k < 4; ++k) {
      for (int l = 0; l <= k && tet[k] != apex; ++l) {
        const bool must_stay = l == k || constrained_.contains(tet[k], tet[l]);
        if (must_stay && !share_face(faces_, face_count_, tet[k], tet[l])) return false;
      }
    }
    return true;
  }
  TETUNE_HD int place_of_side(HalfFace side) const {
    int i = 0;
    while (sides_[i] != side) ++i;
    return i;
  }

  TETUNE_HD bool find_faces() {
    face_count_ = 0;
    for (int i = 0; i < tets_.size(); ++i) {
      const Tet tet = mesh_.tet2vertex[tets_[i]];
      const FaceAdjacency links = mesh_.tet2tet[tets_[i]];
      for (int f = 0; f < 4; ++f) {
        const bool is_base = is_locked(links[f]) && simplex_.is_on_face(tet, f);
        if (links[f] != kNoHalfFace && tets_.contains(tet_of(links[f]))) {
          if (is_locked(links[f]) && !is_base) return false;
          continue;
        }
        if (is_base) continue;
        if (face_count_ == kMaxStarFaces) return false;
        faces_[face_count_] = link_face(tet, f);
        sides_[face_count_++] = make_half_face(tets_[i], f);
      }
    }
    return true;
  }

  /// Takes more tetrahedra into the cavity, one at a time, across the first face, from the last one on, where that
  /// lowers the energy of the retriangulation from x. Returns whether it took one.
  template <class Team>
  TETUNE_HD bool grow(const Vec3& x, const Team& team) {
    bool grown = false;
    for (int begin = 0; begin < face_count_ && has_room();) {
      const int i = begin + team.rank();
      const Growth own = i < face_count_ ? gainful_growth_across(i, x) : Growth{};
      const bool grows = own.t >= 0;
      const int first = team.merge(backend::IndexedMax{grows ? 1.0 : 0.0, grows ? team.rank() : Team::kSize}).index;
      begin += first;
      if (first == Team::kSize) continue;
      take(team.broadcast(own, first));
      grown = true;
    }
    return grown;
  }

  /// The tetrahedron across a face, with its faces towards the cavity: one or two of them.
  struct Growth {
    Tet tet{};
    Index t = -1;  ///< -1: it cannot be taken
    int face = 0, first = 0, second = -1, other = -1;
  };
  /// Where the tetrahedron across face i may be taken. Its faces towards the cavity vanish, one or two of them: with
  /// three, a vertex would vanish as well.
  TETUNE_HD Growth growth_across(int i) const {
    Growth g;
    const HalfFace across = mesh_.tet2tet[tet_of(sides_[i])][face_of(sides_[i])];
    if (is_locked(across)) return {};
    const Index t = tet_of(across);
    g.face = i;
    g.first = face_of(across);
    g.tet = mesh_.tet2vertex[t];
    const FaceAdjacency links = mesh_.tet2tet[t];
    for (int f = 0; f < 4; ++f) {
      if (f == g.first || links[f] == kNoHalfFace || !tets_.contains(tet_of(links[f]))) continue;
      if (g.second >= 0 || is_locked(links[f])) return {};
      g.second = f;
    }
    if (g.second >= 0) {
      // The edge between the two vanishes.
      const int k = g.first * g.second != 0 ? 0 : g.first + g.second == 1 ? 2 : 1;
      const int l = 6 - g.first - g.second - k;
      if (constrained_.contains(g.tet[k], g.tet[l]) || is_base_edge(g.tet[k], g.tet[l])) return {};
      g.other = place_of_side(links[g.second]);
    }
    g.t = t;
    return g;
  }
  TETUNE_HD void take(const Growth& g) {
    tets_.add(g.t);
    const int places[3] = {g.face, g.second >= 0 ? g.other : face_count_, face_count_ + 1};
    if (g.second < 0) face_count_ += 2;
    int n = 0;
    for (int f = 0; f < 4; ++f) {
      if (f == g.first || f == g.second) continue;
      faces_[places[n]] = link_face(g.tet, f);
      sides_[places[n++]] = make_half_face(g.t, f);
    }
  }
  TETUNE_HD bool has_room() const { return !tets_.is_full() && face_count_ + 2 <= kMaxStarFaces; }

  /// growth_across() where that lowers the energy.
  TETUNE_HD Growth gainful_growth_across(int i, const Vec3& x) const {
    const Growth g = growth_across(i);
    if (g.t < 0) return {};
    double before = energy(faces_[i], x) + energy(link_face(g.tet, g.first), vec(mesh_.points[g.tet[g.first]]));
    if (g.second >= 0) before += energy(faces_[g.other], x);
    double after = 0;
    for (int f = 0; f < 4; ++f) {
      if (f != g.first && f != g.second) after += energy(link_face(g.tet, f), x);
    }
    return after < before ? g : Growth{};
  }

  RatedMesh mesh_;
  ConstrainedEdges constrained_;
  SmallSet<kMaxStarTets> tets_;
  LinkFace faces_[kMaxStarFaces];
  HalfFace sides_[kMaxStarFaces];
  LinkFace bases_[kMaxStarTriangles];
  SurfaceSimplex simplex_;
  ApexMotion motion_{{{VertexDof::free, {}}}, {}};
  int face_count_ = 0;
  int base_count_ = 0;
};

}  // namespace tetune
