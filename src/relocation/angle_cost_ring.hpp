// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "backend/team.hpp"
#include "boundary/sliding/deviation_bound.hpp"
#include "boundary/sliding/trace.hpp"
#include "boundary/vertex_dof.hpp"
#include "energy/criterion.hpp"
#include "energy/ring.hpp"
#include "math/orient.hpp"
#include "mesh/gather.hpp"
#include "mesh/work_mesh.hpp"
#include "relocation/minimax_model.hpp"
#include "relocation/step.hpp"

namespace tetune {

/// The extreme cotangents of the dihedral angles of a tetrahedron. Where its volume is not certified, the error bound
/// of the volume takes its place.
TETUNE_HD inline DihedralCots dihedral_cots(const MeshView& mesh, Size t) {
  const Tet tet = mesh.tet2vertex[t];
  const Vec3 p[4] = {vec(mesh.points[tet[0]]), vec(mesh.points[tet[1]]), vec(mesh.points[tet[2]]),
                     vec(mesh.points[tet[3]])};
  const Orient o = orient(p[0], p[1], p[2], p[3]);
  return QualityFloor::dihedral_cots(p, o.certified() ? o.det : o.bound);
}

/// The trial steps of a vertex in its space of motion.
struct FreeMotion {
  MotionSpace space;
  TETUNE_HD Vec3 tangent(const Vec3& gradient) const { return tangent_gradient(gradient, space); }
  /// The position after a step from x.
  TETUNE_HD Vec3 trial(const Vec3& x, const Vec3& step) const { return x + tangent_gradient(step, space); }
  /// Whether the vertex may move to the last trial position; if so, makes it the current one.
  TETUNE_HD bool accept(const Vec3&) const { return true; }
};

/// A surface without a bound on its deviation.
struct NoDeviationBound {
  TETUNE_HD bool allows(const Vec3&, const SurfacePoint&) const { return true; }
};

/// The trial steps of a vertex on the input surface: each ends at the boundary of the surface element at the latest.
template <class Deviation>
struct SlideMotion {
  ReferenceView reference;
  Deviation deviation;
  VertexDof dof;
  SurfacePoint surface_point;
  SurfacePoint trial_point;

  TETUNE_HD Vec3 tangent(const Vec3& gradient) const { return gradient; }
  TETUNE_HD Vec3 trial(const Vec3& x, const Vec3& step) {
    const TraceResult end = project_step(reference, dof, surface_point, x, step);
    trial_point = end.surface_point;
    return end.position;
  }
  TETUNE_HD bool accept(const Vec3& x) {
    if (!deviation.allows(x, trial_point)) return false;
    surface_point = trial_point;
    return true;
  }
};

/// The trial steps of the apex of a cavity, in one of the two ways.
struct ApexMotion {
  FreeMotion free;
  SlideMotion<NoDeviationBound> slide;

  TETUNE_HD bool slides() const { return slide.surface_point.kind != SurfacePointKind::none; }
  TETUNE_HD Vec3 tangent(const Vec3& gradient) const { return slides() ? gradient : free.tangent(gradient); }
  TETUNE_HD Vec3 trial(const Vec3& x, const Vec3& step) {
    return slides() ? slide.trial(x, step) : free.trial(x, step);
  }
  TETUNE_HD bool accept(const Vec3& x) { return !slides() || slide.accept(x); }
};

/// The extreme dihedral angles of the tetrahedra between a point and given faces, in terms of their cost
/// (DihedralCots::cost()), which is to be minimized. It is neither a smooth nor a convex function of the point: its
/// steps are those of a MinimaxModel.
class AngleCostRing {
 public:
  /// With `keeps_floor`, no position is feasible where an angle is beyond the floor.
  TETUNE_HD AngleCostRing(const RatedMesh& mesh, const LinkFace* faces, int count, bool keeps_floor)
      : mesh_(mesh), faces_(faces), count_(count), keeps_floor_(keeps_floor) {}

  /// Moves x by steps of `motion` (FreeMotion, SlideMotion, ApexMotion) while these decrease the cost, until it is at
  /// most `target_cost`. Returns whether x moved. `model` is scratch memory that the threads of the team share; each
  /// thread has x and the motion for itself.
  template <class VertexMotion, class Team = backend::SingleThread>
  TETUNE_HD bool minimize(Vec3& x, VertexMotion& motion, double target_cost, MinimaxModel& model,
                          const Team& team = {}) const {
    double length2 = 0;
    for (int k = 0; k < count_; ++k) {
      const Vec3 d = corner(k, 0) - x;
      length2 += dot(d, d);
    }
    const double length = std::sqrt(length2 / count_);
    int worst = 0;
    double cost = largest_cost(x, kInfeasible, worst, team);
    bool moved = false;
    double radius = kFirstStep * length;
    while (cost > target_cost && radius > kLastStep * length) {
      find_model(x, cost, motion, model, team);
      const double limit = cost - kMinGain * (1 + cost);
      bool improved = false;
      for (; radius > kLastStep * length; radius *= 0.5) {
        const Vec3 trial = motion.trial(x, model.step(radius, team));
        const double trial_cost = largest_cost(trial, limit, worst, team);
        if (!(trial_cost < limit) || !motion.accept(trial)) continue;
        x = trial;
        cost = trial_cost;
        improved = moved = true;
        break;
      }
      if (improved && radius < kFirstStep * length) radius *= 2;
    }
    return moved;
  }

  /// The largest cost with the point at x; `limit` where it is not below `limit`, or where a tetrahedron is not
  /// certified positive or is worse than the floor. Tetrahedron `first` is evaluated first, and the one of the largest
  /// cost replaces it: this saves work, and does not affect the result.
  template <class Team = backend::SingleThread>
  TETUNE_HD double largest_cost(const Vec3& x, double limit, int& first, const Team& team = {}) const {
    using Pack = backend::TermsOf<Team>;
    if constexpr (kLanesOf < Pack >> 1) {
      return largest_of_packs<Pack>(x, limit, first);
    } else {
      return largest_of_team(x, limit, first, team);
    }
  }

 private:
  template <class Team>
  TETUNE_HD double largest_of_team(const Vec3& x, double limit, int& first, const Team& team) const {
    backend::IndexedMax worst{-1, first};
    const int start = first;
    for (int begin = 0; begin < count_; begin += Team::kSize) {
      const int k = begin + team.rank();
      bool fails = false;
      if (k < count_) {
        const int at = k == 0 ? start : k <= start ? k - 1 : k;
        const double cost = cost_of(x, at);
        if (cost > worst.value) worst = {cost, at};
        fails = !(worst.value < limit);
      }
      if (team.any(fails)) {
        first = team.merge(worst).index;
        return limit;
      }
    }
    worst = team.merge(worst);
    first = worst.index;
    return worst.value;
  }
  template <class Pack>
  TETUNE_HD double largest_of_packs(const Vec3& x, double limit, int& first) const {
    constexpr int kLanes = kLanesOf<Pack>;
    const int start = first / kLanes;
    backend::IndexedMax worst{-1, first};
    for (int k = 0; kLanes * k < count_; ++k) {
      const int begin = kLanes * (k == 0 ? start : k <= start ? k - 1 : k);
      const Pack costs = costs_of<Pack>(x, begin);
      for (int l = 0; l < kLanes; ++l) worst.add(costs[l], begin + l);
      if (worst.value < limit) continue;
      first = worst.index;
      return limit;
    }
    first = worst.index;
    return worst.value;
  }

  /// cost_of() the faces from `begin` on; of the last one where there are no more.
  template <class Pack>
  TETUNE_HD TETUNE_INLINE Pack costs_of(const Vec3& x, int begin) const {
    const Pack zero{};
    Vec3T<Pack> p[4] = {{zero + x.x, zero + x.y, zero + x.z}};
    for (int k = 0; k < 3; ++k) {
      Index ids[kLanesOf<Pack>];
      for (int l = 0; l < kLanesOf<Pack>; ++l) ids[l] = faces_[begin + l < count_ ? begin + l : count_ - 1].v[k];
      p[k + 1] = gather<Pack>(mesh_.points, ids);
    }
    const TetEnergyT<Pack> e = tet_energy(mesh_.objective, p[0], p[1], p[2], p[3]);
    const DihedralCotsT<Pack> cots = QualityFloor::dihedral_cots(p, e.w);
    const Pack infinite = zero + HUGE_VAL;
    Pack cost = cots.cost(mesh_.obtuse_weight);
    cost = e.certified ? cost : infinite;
    cost = e.shape > mesh_.floor.worst_shape ? infinite : cost;
    if (keeps_floor_) cost = mesh_.floor.allows(cots) ? cost : infinite;
    return cost;
  }
  /// The cost of the tetrahedron at a face; infinite where it is not certified positive or is worse than the floor.
  TETUNE_HD double cost_of(const Vec3& x, int face) const {
    const Vec3 p[4] = {x, corner(face, 0), corner(face, 1), corner(face, 2)};
    const TetEnergy e = tet_energy(mesh_.objective, p[0], p[1], p[2], p[3]);
    if (!e.certified || e.shape > mesh_.floor.worst_shape) return HUGE_VAL;
    const DihedralCots cots = QualityFloor::dihedral_cots(p, e.w);
    return !keeps_floor_ || mesh_.floor.allows(cots) ? cots.cost(mesh_.obtuse_weight) : HUGE_VAL;
  }

  /// Finds the costs that are close to the largest, and their gradients in the space of motion. They are added in the
  /// order of the faces.
  template <class VertexMotion, class Team>
  TETUNE_HD void find_model(const Vec3& x, double cost, const VertexMotion& motion, MinimaxModel& model,
                            const Team& team) const {
    model.clear(team);
    for (int begin = 0; begin < count_; begin += Team::kSize) {
      AngleCosts angles;
      const int i = begin + team.rank();
      if (i < count_) {
        const Vec3 p[4] = {x, corner(i, 0), corner(i, 1), corner(i, 2)};
        angles.find(p, orient(p[0], p[1], p[2], p[3]).det, cost - kBand * (1 + cost), mesh_.obtuse_weight, motion);
      }
      const int turns = count_ - begin < Team::kSize ? count_ - begin : Team::kSize;
      for (int turn = 0; turn < turns; ++turn) {
        if (turn == team.rank()) {
          for (int k = 0; k < angles.count; ++k) model.add(angles.cost[k], angles.gradient[k]);
        }
        team.sync();
      }
    }
  }
  /// Angles of a tetrahedron with their gradients.
  struct AngleCosts {
    int count = 0;
    double cost[6];
    Vec3 gradient[6];

    /// Finds the angles whose cost is above a bound. With n_i the normals of the faces, cos / sin = -n_i . n_j / (w
    /// |e|); when x moves by d, n_i changes by d x s_i with s_i the side of face i opposite x.
    template <class VertexMotion>
    TETUNE_HD void find(const Vec3 p[4], double w, double bound, double obtuse_weight, const VertexMotion& motion) {
      Vec3 n[4];
      Vec3 side[4];
      for (int f = 0; f < 4; ++f) {
        const Vec3& a = p[face_vertex(f, 0)];
        const Vec3& b = p[face_vertex(f, 1)];
        const Vec3& c = p[face_vertex(f, 2)];
        n[f] = cross(b - a, c - a);
        side[f] = f == 0 ? Vec3{0, 0, 0} : face_vertex(f, 0) == 0 ? b - c : face_vertex(f, 1) == 0 ? c - a : a - b;
      }
      const Vec3 dw = (dot(n[0], p[0] - p[1]) > 0 ? 1 / w : -1 / w) * n[0];
      for_each_dihedral_cot(p, n, w, [&](double cot, int i, int j, int k, int l) {
        const double angle_cost = DihedralCots{cot, cot}.cost(obtuse_weight);
        if (!(angle_cost > bound)) return;
        const Vec3 edge = p[k] - p[l];
        Vec3 g = (-1 / (w * norm(edge))) * (cross(side[i], n[j]) + cross(side[j], n[i])) - cot * dw;
        if (k == 0) g = g - (cot / dot(edge, edge)) * edge;
        cost[count] = angle_cost;
        gradient[count++] = motion.tangent(angle_cost > cot ? -obtuse_weight * g : g);
      });
    }
  };

  /// In local lengths.
  static constexpr double kFirstStep = 0.2;
  static constexpr double kLastStep = 5e-3;
  /// The smallest relative decrease of the cost for which a step is taken.
  static constexpr double kMinGain = 1e-3;
  /// Angles within this part of the largest cost take part in a step.
  static constexpr double kBand = 0.6;

  TETUNE_HD Vec3 corner(int face, int k) const { return vec(mesh_.points[faces_[face].v[k]]); }

  RatedMesh mesh_;
  const LinkFace* faces_;
  int count_;
  bool keeps_floor_;
};

}  // namespace tetune
