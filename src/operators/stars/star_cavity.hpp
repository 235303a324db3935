// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/dihedral_cots.hpp"
#include "energy/ring_of.hpp"
#include "operators/stars/kernel_point.hpp"
#include "operators/stars/star_shape.hpp"
#include "relocation/angle_cost_ring.hpp"
#include "relocation/step.hpp"
#include "relocation/trial_motion.hpp"

namespace tetune {

/// A star-shaped cavity, retriangulated from one point, the apex, by a tetrahedron on each face that the apex is not
/// on. Where all these are positive, they fill the cavity and nothing else (docs/method.md, "Insertion and
/// contraction"): with a new vertex inside as the apex a vertex is inserted; with one on the cavity of all tetrahedra
/// around a vertex that vertex is removed.
///
/// A cavity of all tetrahedra around a simplex of the surface also replaces the surface triangles that contain it. With
/// an apex in their planes the surface keeps its shape; with another, on a curved surface, it bends within a bound
/// (SurfaceBend). All threads of a team call the functions that take a team, with equal arguments; the others change
/// nothing.
class StarCavity : StarShape {
 public:
  /// An empty cavity in the memory of the team.
  template <class Team>
  TETUNE_HD StarCavity(const RatedMesh& mesh, const ConstrainedEdges& constrained, StarArrays& arrays, const Team& team)
      : StarShape(mesh, constrained, arrays) {
    change(team, [this] { arrays_.clear(); });
  }
  /// A copy would have the same memory: see assign().
  StarCavity(const StarCavity&) = delete;
  StarCavity& operator=(const StarCavity&) = delete;
  /// Becomes equal to another cavity, in its own memory.
  template <class Team>
  TETUNE_HD void assign(const StarCavity& other, const Team& team) {
    change(team, [&] { arrays_ = other.arrays_; });
    motion_ = other.motion_;
  }

  /// Takes all tetrahedra around an edge of t. Returns false, as do the next four, where a constraint or the capacity
  /// forbids it.
  template <class Team>
  TETUNE_HD bool take_edge(Index t, int edge, const Team& team) {
    return try_change(team, [&] { return add_edge(t, edge) && find_faces(); });
  }
  /// Takes t alone.
  template <class Team>
  TETUNE_HD bool take_tet(Index t, const Team& team) {
    return try_change(team, [&] {
      arrays_.tets.add(t);
      return find_faces();
    });
  }
  /// Takes all tetrahedra around a simplex of the surface of which t is one, on all sides of interfaces too. Returns
  /// false also where they are more than `max_tets`. The next function likewise.
  template <class Team>
  TETUNE_HD bool take_surface(Index t, const SurfaceSimplex& simplex, int max_tets, const Team& team) {
    return try_change(team, [&] { return add_surface(t, simplex, max_tets) && find_faces(); });
  }
  /// Takes all tetrahedra around a vertex of t that is on no surface.
  template <class Team>
  TETUNE_HD bool take_vertex(Index t, int corner, int max_tets, const Team& team) {
    return try_change(team, [&] {
      const Index v = mesh_.tet2vertex[t][corner];
      arrays_.tets.add(t);
      return add_all_around(v, max_tets) && find_faces(v);
    });
  }
  /// Takes all tetrahedra around a vertex of the cavity, in addition to those it has.
  template <class Team>
  TETUNE_HD bool take_all_around(Index v, const Team& team) {
    return try_change(team, [&] { return add_all_around(v) && find_faces(v); });
  }

  TETUNE_HD int tet_count() const { return arrays_.tets.size(); }
  /// The surface triangles that the cavity replaces.
  TETUNE_HD int base_count() const { return arrays_.base_count; }
  TETUNE_HD const LinkFace& base(int i) const { return arrays_.bases[i]; }
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
    for (int i = 0; i < arrays_.face_count; ++i) {
      const LinkFace& f = arrays_.faces[i];
      for (int k = 0; k < 3; ++k) {
        if (f.v[k] == apex && is_base_edge(f.v[(k + 1) % 3], f.v[(k + 2) % 3])) return false;
      }
    }
    return true;
  }
  TETUNE_HD Index tet(int i) const { return arrays_.tets[i]; }
  TETUNE_HD int face_count() const { return arrays_.face_count; }
  TETUNE_HD const LinkFace& face(int i) const { return arrays_.faces[i]; }
  /// The energy of a tetrahedron on a face with its fourth vertex at x.
  TETUNE_HD TETUNE_OUTLINE double energy(const LinkFace& f, const Vec3& x) const {
    const Span<const Point> p = mesh_.points;
    const TetEnergy e = tet_energy(mesh_.objective, x, vec(p[f.v[0]]), vec(p[f.v[1]]), vec(p[f.v[2]]));
    return e.certified ? e.energy : kInfeasible;
  }
  /// The candidate of the retriangulation from x, without its tetrahedra.
  TETUNE_HD StarCandidate candidate(Index apex, Index removed, const Vec3& x) const {
    StarCandidate c;
    c.apex_position = x;
    c.apex = apex;
    c.removed = removed;
    c.is_moved = false;
    c.simplex = arrays_.simplex;
    return c;
  }
  /// Adds the tetrahedra to a candidate. One thread of a team calls it.
  TETUNE_HD TETUNE_OUTLINE void list_tets(StarCandidate& c) const {
    c.tet_count = arrays_.tets.size();
    for (int i = 0; i < arrays_.tets.size(); ++i) c.tets[i] = arrays_.tets[i];
    for (int i = 0; i < arrays_.tets.size(); ++i) c.outer_faces[i] = 0;
    for (int k = 0; k < arrays_.face_count; ++k) {
      const int i = arrays_.tets.find(tet_of(arrays_.sides[k]));
      c.outer_faces[i] = static_cast<std::uint8_t>(c.outer_faces[i] | 1 << face_of(arrays_.sides[k]));
    }
  }

  /// The largest cost of the dihedral angles (DihedralCots::cost()) in the cavity as it is.
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE double cost_before(const Team& team) const {
    using Pack = backend::TermsOf<Team>;
    constexpr int kLanes = kLanesOf<Pack>;
    backend::Max largest{-1};
    for (int begin = kLanes * team.rank(); begin < arrays_.tets.size(); begin += kLanes * Team::kSize) {
      Vec3T<Pack> p[4];
      gather_corners(begin, p);
      const Pack costs = dihedral_cots(p).cost(mesh_.obtuse_weight);
      for (int l = 0; l < kLanes; ++l) largest.merge(backend::Max{lane(costs, l)});
    }
    return team.merge(largest).value;
  }
  /// The largest cost of the retriangulation from x; `limit` where it is not below `limit`, or where a tetrahedron is
  /// not certified positive or is worse than the floor (FloorRule).
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE double cost_after(Index apex, const Vec3& x, double limit, FloorRule floor,
                                             const Team& team) const {
    if (apex == kNewVertex) {
      int first = 0;
      return AngleCostRing(mesh_, arrays_.faces, arrays_.face_count, floor).largest_cost(x, limit, first, team);
    }
    constexpr int kLanes = kLanesOf<backend::TermsOf<Team>>;
    backend::Max largest{-1};
    for (int begin = 0; begin < arrays_.face_count; begin += kLanes * Team::kSize) {
      const int first = begin + kLanes * team.rank();
      double costs[kLanes];
      if (first < arrays_.face_count) {
        find_costs_from(first, apex, x, floor, costs, team);
        for (const double cost : costs) largest.merge(backend::Max{cost});
      }
      if (team.any(!(largest.value < limit))) return limit;
    }
    return team.merge(largest).value;
  }

  /// move_into_kernel() of the cavity's faces.
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE bool find_kernel_point(Vec3& x, const Team& team) const {
    return move_into_kernel(mesh_.points, arrays_.faces, arrays_.face_count, x, team);
  }
  /// Whether all vertices and constrained edges of the cavity, except for the apex inside it, are on its faces.
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE bool preserves_constraints(Index apex, const Team& team) const {
    bool preserves = true;
    for (int i = team.rank(); i < arrays_.tets.size() && preserves; i += Team::kSize) {
      preserves = preserves_constraints_of(mesh_.tet2vertex[arrays_.tets[i]], apex);
    }
    return !team.any(!preserves);
  }

  /// A position of the apex where the energy is lower, from one in the kernel; x itself where the apex slides.
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE Vec3 relax(const Vec3& x, const Team&) const {
    if (motion_.slides()) return x;
    RingOfTeam<Team> ring(mesh_.objective, mesh_.points, arrays_.faces, arrays_.face_count);
    return NewtonStep{1, kMinGain}(ring, x, motion_.free.space).position;
  }
  /// Enlarges the cavity and relaxes the apex in turn, while that lowers the energy.
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE Vec3 relax_and_grow(Vec3 x, const Team& team) {
    for (int round = 0; round < kGrowthRounds && grow(x, team); ++round) x = relax(x, team);
    return x;
  }
  /// Enlarges the cavity across the face whose new tetrahedron costs most, until all cost less than `limit` with the
  /// apex at x. Returns false where a constraint or the size forbids it.
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE bool grow_below(Index apex, const Vec3& x, double limit, const Team& team) {
    // Face i belongs to thread i % kSize of the team.
    constexpr int kLanes = kLanesOf<backend::TermsOf<Team>>;
    double costs[(kMaxStarFaces + Team::kSize - 1) / Team::kSize];
    for (int i = kLanes * team.rank(); i < arrays_.face_count; i += kLanes * Team::kSize) {
      double some[kLanes];
      find_costs_from(i, apex, x, FloorRule::ignored, some, team);
      for (int l = 0; l < kLanes; ++l) costs[i / Team::kSize + l] = some[l];
    }
    for (int step = 0; step < kMaxStarTets; ++step) {
      double largest = limit;
      int own_worst = -1;
      for (int i = team.rank(); i < arrays_.face_count; i += Team::kSize) {
        if (!(costs[i / Team::kSize] >= largest)) continue;
        largest = costs[i / Team::kSize];
        own_worst = i;
      }
      // The last of equals: indices count from the last face on.
      const int worst =
          kMaxStarFaces - 1 - team.merge(backend::IndexedMax{largest, kMaxStarFaces - 1 - own_worst}).index;
      if (worst < 0) return true;
      const Growth g = has_room() ? growth_across(worst) : Growth{};
      if (g.t < 0) return false;
      change(team, [&] { take(g); });
      for (int k = 0; k < g.new_faces(); ++k) {
        const int position = g.positions[k];
        if (position % Team::kSize == team.rank())
          costs[position / Team::kSize] = face_cost(apex, x, position, FloorRule::ignored);
      }
    }
    return false;
  }
  /// A position of the apex where the largest cost of the angles is lower; `model` as in AngleCostRing::minimize().
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE Vec3 lower_cost(Vec3 x, MinimaxModel& model, const Team& team) {
    AngleCostRing(mesh_, arrays_.faces, arrays_.face_count, FloorRule::ignored).minimize(x, motion_, 0, model, team);
    return x;
  }

 private:
  /// Lets one thread of a team change the memory that all of them read.
  template <class Team, class Change>
  TETUNE_HD static void change(const Team& team, const Change& change) {
    team.sync();
    if (team.rank() == 0) change();
    team.sync();
  }
  /// change() with a result.
  template <class Team, class Change>
  TETUNE_HD static bool try_change(const Team& team, const Change& change) {
    team.sync();
    const bool succeeds = team.any(team.rank() == 0 && change());
    team.sync();
    return succeeds;
  }

  /// The cost of the new tetrahedron at a face, at most kInfeasible; -1 where the apex is on it.
  TETUNE_HD TETUNE_OUTLINE double face_cost(Index apex, const Vec3& x, int face, FloorRule floor) const {
    int first = 0;
    return has_vertex(arrays_.faces[face], apex)
               ? -1
               : AngleCostRing(mesh_, &arrays_.faces[face], 1, floor).largest_cost(x, kInfeasible, first);
  }
  /// face_cost() of the faces from `first` on, as many as the team's threads evaluate at a time; -1 beyond the last
  /// one.
  template <class Team, int kLanes>
  TETUNE_HD void find_costs_from(int first, Index apex, const Vec3& x, FloorRule floor, double (&costs)[kLanes],
                                 const Team&) const {
    if constexpr (kLanes == 1) {
      costs[0] = face_cost(apex, x, first, floor);
    } else {
      using Pack = backend::TermsOf<Team>;
      const AngleCostRing ring(mesh_, arrays_.faces, arrays_.face_count, floor);
      const Pack pack = ring.template costs_of<Pack>(x, first);
      for (int l = 0; l < kLanes; ++l) {
        const bool is_absent = first + l >= arrays_.face_count || has_vertex(arrays_.faces[first + l], apex);
        costs[l] = is_absent ? -1 : pack[l] < kInfeasible ? pack[l] : kInfeasible;
      }
    }
  }
  /// The vertices of the tetrahedra from `begin` on, one tetrahedron per lane; of the last one where there are no more.
  template <class Pack>
  TETUNE_HD TETUNE_INLINE void gather_corners(int begin, Vec3T<Pack> (&p)[4]) const {
    const int last = arrays_.tets.size() - 1;
    Index ids[4][kLanesOf<Pack>];
    for (int l = 0; l < kLanesOf<Pack>; ++l) {
      const Tet tet = mesh_.tet2vertex[arrays_.tets[begin + l < last ? begin + l : last]];
      for (int k = 0; k < 4; ++k) ids[k][l] = tet[k];
    }
    for (int k = 0; k < 4; ++k) p[k] = gather<Pack>(mesh_.points, ids[k]);
  }

  static constexpr int kGrowthRounds = 3;
  /// A step must lower the energy by this part at least, by its model.
  static constexpr double kMinGain = 1e-3;

  /// preserves_constraints() for one tetrahedron of the cavity.
  TETUNE_HD bool preserves_constraints_of(const Tet& tet, Index apex) const {
    for (int k = 0; k < 4; ++k) {
      for (int l = 0; l <= k && tet[k] != apex; ++l) {
        const bool must_stay = l == k || constrained_.contains(tet[k], tet[l]);
        if (must_stay && !share_face(arrays_.faces, arrays_.face_count, tet[k], tet[l])) return false;
      }
    }
    return true;
  }
  /// Visits the faces in order, and takes the tetrahedron across each where that lowers the energy of the
  /// retriangulation from x; faces that this adds follow. Returns whether it took one.
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE bool grow(const Vec3& x, const Team& team) {
    bool grown = false;
    for (int begin = 0; begin < arrays_.face_count && has_room();) {
      const int i = begin + team.rank();
      const Growth own = i < arrays_.face_count ? gainful_growth_across(i, x) : Growth{};
      const bool grows = own.t >= 0;
      const int first = team.merge(backend::IndexedMax{grows ? 1.0 : 0.0, grows ? team.rank() : Team::kSize}).index;
      begin += first;
      if (first == Team::kSize) continue;
      const Growth g = team.broadcast(own, first);
      change(team, [&] { take(g); });
      grown = true;
    }
    return grown;
  }

  /// growth_across() where that lowers the energy.
  TETUNE_HD Growth gainful_growth_across(int i, const Vec3& x) const {
    const Growth g = growth_across(i);
    if (g.t < 0) return {};
    double gain = energy(arrays_.faces[i], x) + energy(link_face(g.tet, g.first), vec(mesh_.points[g.tet[g.first]]));
    if (g.second >= 0) gain += energy(arrays_.faces[g.positions[1]], x);
    int left = g.new_faces();
    for (int f = 0; f < 4; ++f) {
      if (f == g.first || f == g.second) continue;
      if (!(gain > left-- * kMinShapeEnergy)) return {};
      gain -= energy(link_face(g.tet, f), x);
    }
    return gain > 0 ? g : Growth{};
  }

  ApexMotion motion_{{{VertexDof::free, {}}}, {}};
};

}  // namespace tetune
