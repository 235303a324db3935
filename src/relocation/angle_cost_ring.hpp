// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "backend/team.hpp"
#include "energy/criterion.hpp"
#include "energy/dihedral_cots.hpp"
#include "energy/ring.hpp"
#include "math/orient.hpp"
#include "mesh/gather.hpp"
#include "mesh/work_mesh.hpp"
#include "relocation/minimax_model.hpp"
#include "relocation/trial_motion.hpp"

namespace tetune {

/// Whether the cost of a tetrahedron with an angle beyond the floor is infinite. It is so in any case where the shape
/// energy or the mean ratio is worse than the floor.
enum class FloorRule : std::uint8_t { ignored, kept };

/// The extreme dihedral angles of the tetrahedra between a point and given faces, in terms of their cost
/// (DihedralCots::cost()), which is to be minimized. It is neither a smooth nor a convex function of the point: its
/// steps are those of a MinimaxModel.
class AngleCostRing {
 public:
  TETUNE_HD AngleCostRing(const RatedMesh& mesh, const LinkFace* faces, int count, FloorRule floor)
      : mesh_(mesh), faces_(faces), count_(count), keeps_floor_(floor == FloorRule::kept) {}

  /// Moves x by steps of `motion` (FreeMotion, SlideMotion, ApexMotion) while these decrease the cost, until it is at
  /// most `target_cost`. Returns whether x moved. `model` is scratch memory that the threads of the team share; each
  /// thread has x and the motion for itself.
  template <class TrialMotion, class Team = backend::SingleThread>
  TETUNE_HD bool minimize(Vec3& x, TrialMotion& motion, double target_cost, MinimaxModel& model,
                          const Team& team = {}) const {
    int worst = 0;
    double cost = largest_cost(x, kInfeasible, worst, team);
    if (!(cost > target_cost)) return false;
    const double length = local_length(x, team);
    bool moved = false;
    double radius = kFirstStep * length;
    while (cost > target_cost && radius > kLastStep * length) {
      find_model(x, cost, motion, model, team);
      const double limit = cost - kMinGain * (1 + cost);
      bool improved = false;
      for (; radius > kLastStep * length; radius *= 0.5) {
        const MinimaxStep step = model.step(radius, team);
        // A shorter step is predicted to gain even less.
        if (!(step.value < limit)) return moved;
        const Vec3 trial = motion.trial(x, step.d);
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
  /// certified positive or is worse than the floor (FloorRule). Tetrahedron `first` is evaluated first, and the one of
  /// the largest cost replaces it: this saves work, and does not affect the result.
  template <class Team = backend::SingleThread>
  TETUNE_HD double largest_cost(const Vec3& x, double limit, int& first, const Team& team = {}) const {
    using Pack = backend::TermsOf<Team>;
    if constexpr (kLanesOf<Pack> != 1) {
      return largest_of_packs<Pack>(x, limit, first);
    } else {
      return largest_of_team(x, limit, first, team);
    }
  }

  /// The costs of the tetrahedra at the faces from `begin` on, one per lane, at the last one where there are no more;
  /// infinite where one is not certified positive or is worse than the floor (FloorRule).
  template <class Pack>
  TETUNE_HD TETUNE_INLINE Pack costs_of(const Vec3& x, int begin) const {
    Vec3T<Pack> p[4];
    gather_corners(x, begin, p);
    const TetEnergyT<Pack> e = tet_energy(mesh_.objective, p[0], p[1], p[2], p[3]);
    const DihedralCotsT<Pack> cots = QualityFloor::dihedral_cots(p, e.w);
    const Pack infinite = Pack{} + HUGE_VAL;
    Pack cost = cots.cost(mesh_.obtuse_weight);
    cost = e.certified ? cost : infinite;
    cost = mesh_.floor.allows_shape(e.shape, p, e.w) ? cost : infinite;
    if (keeps_floor_) cost = mesh_.floor.allows(cots) ? cost : infinite;
    return cost;
  }

 private:
  static constexpr int kAngles = 6;

  /// The root of the mean squared distance to a vertex of each face. Summed in the order of the faces.
  template <class Team>
  TETUNE_HD double local_length(const Vec3& x, const Team& team) const {
    double length2 = 0;
    for (int begin = 0; begin < count_; begin += Team::kSize) {
      const int own = begin + team.rank();
      const Vec3 d = own < count_ ? corner(own, 0) - x : Vec3{};
      const double own_length2 = dot(d, d);
      for (int k = 0; k < Team::kSize && begin + k < count_; ++k) length2 += team.broadcast(own_length2, k);
    }
    return std::sqrt(length2 / count_);
  }
  template <class Team>
  TETUNE_HD TETUNE_OUTLINE double largest_of_team(const Vec3& x, double limit, int& first, const Team& team) const {
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

  /// The cost of the tetrahedron at a face, as costs_of() has it.
  TETUNE_HD TETUNE_OUTLINE double cost_of(const Vec3& x, int face) const {
    const Vec3 p[4] = {x, corner(face, 0), corner(face, 1), corner(face, 2)};
    const TetEnergy e = tet_energy(mesh_.objective, p[0], p[1], p[2], p[3]);
    if (!e.certified || !mesh_.floor.allows_shape(e.shape, p, e.w)) return HUGE_VAL;
    const DihedralCots cots = QualityFloor::dihedral_cots(p, e.w);
    return !keeps_floor_ || mesh_.floor.allows(cots) ? cots.cost(mesh_.obtuse_weight) : HUGE_VAL;
  }

  /// Finds the costs that are close to the largest, and their gradients in the space of motion. They are added in the
  /// order of the faces. Where there are too many, fewer are close.
  template <class TrialMotion, class Team>
  TETUNE_HD TETUNE_OUTLINE void find_model(const Vec3& x, double cost, const TrialMotion& motion, MinimaxModel& model,
                                           const Team& team) const {
    using Pack = backend::TermsOf<Team>;
    double width = kBand;
    for (int attempt = 1; !add_costs_above(cost - width * (1 + cost), x, model, team) && attempt < kMaxBands;
         ++attempt) {
      width *= kBandDecrease * MinimaxModel::kMaxFunctions / model.added();
    }
    model.set_gradients([&](const int(&angles)[kLanesOf<Pack>]) { return angle_gradients<Pack>(x, angles); },
                        [&](const Vec3& gradient) { return motion.tangent(gradient); }, team);
  }
  /// Makes a model of the costs above a bound; returns whether it has room for all of them.
  template <class Team>
  TETUNE_HD bool add_costs_above(double bound, const Vec3& x, MinimaxModel& model, const Team& team) const {
    using Pack = backend::TermsOf<Team>;
    constexpr int kLanes = kLanesOf<Pack>;
    model.clear(team);
    for (int begin = 0; begin < count_; begin += Team::kSize * kLanes) {
      Pack costs[kAngles];
      const int first = begin + team.rank() * kLanes;
      if (first < count_) find_angle_costs(x, first, costs);
      const int faces = count_ - first < kLanes ? count_ - first : kLanes;
      model.add_in_order([&](const auto& add) { add_above(bound, costs, first, faces, add); }, team);
    }
    return model.added() <= MinimaxModel::kMaxFunctions;
  }
  /// Calls add(cost, number) for the costs above a bound, of some faces from `first` on.
  template <class Pack, class Add>
  TETUNE_HD TETUNE_INLINE static void add_above(double bound, const Pack (&costs)[kAngles], int first, int faces,
                                                const Add& add) {
    if constexpr (kLanesOf<Pack> == 1) {
      for (int k = 0; k < kAngles && faces > 0; ++k) {
        if (costs[k] > bound) add(costs[k], kAngles * first + k);
      }
    } else {
      // The bits of a face are those of its angles.
      backend::BitsOf<Pack> bits{};
      for (int l = 0; l < kLanesOf<Pack>; ++l) bits[l] = std::uint64_t{1} << kAngles * l;
      backend::BitsOf<Pack> above{};
      for (int k = 0; k < kAngles; ++k) above |= backend::where(costs[k] > bound, bits << k);
      const std::uint64_t of_faces = (std::uint64_t{1} << kAngles * faces) - 1;
      for (std::uint64_t left = backend::merged(above) & of_faces; left != 0; left &= left - 1) {
        const int angle = std::countr_zero(left);
        add(costs[angle % kAngles][angle / kAngles], kAngles * first + angle);
      }
    }
  }

  /// x and the vertices of faces from `begin` on, one face per lane; of the last one where there are no more.
  template <class Pack>
  TETUNE_HD TETUNE_INLINE void gather_corners(const Vec3& x, int begin, Vec3T<Pack> (&p)[4]) const {
    const Pack zero{};
    p[0] = {zero + x.x, zero + x.y, zero + x.z};
    for (int k = 0; k < 3; ++k) {
      Index ids[kLanesOf<Pack>];
      for (int l = 0; l < kLanesOf<Pack>; ++l) ids[l] = faces_[begin + l < count_ ? begin + l : count_ - 1].v[k];
      p[k + 1] = gather<Pack>(mesh_.points, ids);
    }
  }
  /// The cost of each dihedral angle, in the order of for_each_dihedral_cot().
  template <class Pack>
  TETUNE_HD TETUNE_INLINE void find_angle_costs(const Vec3& x, int begin, Pack (&costs)[kAngles]) const {
    Vec3T<Pack> p[4];
    gather_corners(x, begin, p);
    const Vec3T<Pack> n[4] = {area_normal(p, 0), area_normal(p, 1), area_normal(p, 2), area_normal(p, 3)};
    int angle = 0;
    for_each_dihedral_cot(p, n, orient_det(p), [&](const Pack& cot, int, int, int, int) {
      costs[angle++] = DihedralCotsT<Pack>{cot, cot}.cost(mesh_.obtuse_weight);
    });
  }
  /// The gradients of the costs of some angles, one per lane. At the edge (k, l) between the faces opposite i and j,
  /// cot = n_u . n_v / (|det| |e|) with e = l - k, u = i - k, v = j - k, n_u = e x u, n_v = e x v and det = u . n_v;
  /// x is vertex i, or k where it is an end of the edge.
  template <class Pack>
  TETUNE_HD TETUNE_INLINE Vec3T<Pack> angle_gradients(const Vec3& x, const int (&angles)[kLanesOf<Pack>]) const {
    Index ids_j[kLanesOf<Pack>], ids_other[kLanesOf<Pack>], ids_l[kLanesOf<Pack>];  // other: k or i, which x is not
    double at_end[kLanesOf<Pack>];
    for (int lane = 0; lane < kLanesOf<Pack>; ++lane) {
      const LinkFace& face = faces_[angles[lane] / kAngles];
      const int angle = angles[lane] % kAngles;
      const int i = angle < 3 ? 0 : angle < 5 ? 1 : 2;
      const int j = angle < 3 ? angle + 1 : angle < 5 ? angle - 1 : 3;
      const int k = i == 0 ? (j == 1 ? 2 : 1) : i;
      ids_j[lane] = face.v[j - 1];
      ids_other[lane] = face.v[k - 1];
      ids_l[lane] = face.v[(i == 0 ? 6 - j - k : 6 - i - j) - 1];
      at_end[lane] = i == 0 ? 0 : 1;
    }
    const Pack zero{};
    const auto is_end = backend::load<Pack>(at_end) > zero;
    const Vec3T<Pack> moving{zero + x.x, zero + x.y, zero + x.z};
    const Vec3T<Pack> other = gather<Pack>(mesh_.points, ids_other);
    const Vec3T<Pack> p_k = select(is_end, moving, other);
    const Vec3T<Pack> e = gather<Pack>(mesh_.points, ids_l) - p_k;
    const Vec3T<Pack> u = select(is_end, other, moving) - p_k;
    const Vec3T<Pack> v = gather<Pack>(mesh_.points, ids_j) - p_k;
    const Vec3T<Pack> n_u = cross(e, u);
    const Vec3T<Pack> n_v = cross(e, v);
    const Pack det = dot(u, n_v);
    const Pack length2 = dot(e, e);
    const Pack scale = 1.0 / ((det > zero ? det : -det) * square_root(length2));
    const Pack cot = scale * dot(n_u, n_v);
    const Vec3T<Pack> d_product = select(is_end, cross(n_v, u - e) + cross(n_u, v - e), cross(n_v, e));
    const Vec3T<Pack> d_det = select(is_end, n_u - n_v - cross(v, u), n_v);
    const Pack along = is_end ? cot / length2 : zero;
    const Vec3T<Pack> gradient = scale * d_product - (cot / det) * d_det + along * e;
    const Pack obtuse = -mesh_.obtuse_weight * cot;
    return (obtuse > cot ? zero - mesh_.obtuse_weight : zero + 1.0) * gradient;
  }
  template <class Condition, class T>
  TETUNE_HD TETUNE_INLINE static Vec3T<T> select(const Condition& condition, const Vec3T<T>& a, const Vec3T<T>& b) {
    return {condition ? a.x : b.x, condition ? a.y : b.y, condition ? a.z : b.z};
  }

  /// In local lengths.
  static constexpr double kFirstStep = 0.2;
  static constexpr double kLastStep = 5e-3;
  /// The smallest relative decrease of the cost for which a step is taken.
  static constexpr double kMinGain = 1e-3;
  /// Angles whose cost is within the fraction kBand of the largest take part in a step. Where there are more than
  /// there is room for, the fraction is decreased in proportion, and by a further factor, in at most kMaxBands
  /// attempts.
  static constexpr double kBand = 0.6;
  static constexpr double kBandDecrease = 0.8;
  static constexpr int kMaxBands = 4;

  TETUNE_HD Vec3 corner(int face, int k) const { return vec(mesh_.points[faces_[face].v[k]]); }

  RatedMesh mesh_;
  const LinkFace* faces_;
  int count_;
  bool keeps_floor_;
};

}  // namespace tetune
