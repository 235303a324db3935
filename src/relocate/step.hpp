// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/motion.hpp"
#include "energy/ring.hpp"
#include "relocate/brent.hpp"

/// One vertex in its ring (Alg. 1, lines 4 to 30), over PlainRing or SimdRing. On each of the spaces a vertex may move
/// in, the energy is convex (docs/method.md): there is one minimum, and it is inversion-free.
namespace tetune {

struct StepResult {
  Vec3 position;
  double decrease = 0;       ///< of the sum of the energy over the ring; 0 when the vertex stays
  double gradient2 = 0;      ///< squared norm of grad tr = grad eta / 9 within the space of motion, before the step
  double relative_move = 0;  ///< length of the move by the local length
};

inline constexpr double kTraceFactor = 1.0 / 9;  ///< tr(L) = eta / d^2 (Eq. 3)

/// Direction of descent for the quadratic model in the space of motion; zero where there is none.
TETUNE_HD inline Vec3 newton_direction(const RingModel& m, const Motion& motion) {
  switch (motion.kind) {
    case Mobility::free: {
      // Cholesky, with the diagonal lifted by less than rounding can tell.
      const Sym3& h = m.hessian;
      const double lift = 1e-15 * (h.xx + h.yy + h.zz);
      const double d0 = h.xx + lift;
      const double l1 = h.xy / d0;
      const double l2 = h.xz / d0;
      const double d1 = h.yy + lift - l1 * h.xy;
      const double e1 = h.yz - l1 * h.xz;
      const double l3 = e1 / d1;
      const double d2 = h.zz + lift - l2 * h.xz - l3 * e1;
      if (!(d0 > 0) || !(d1 > 0) || !(d2 > 0)) return -1.0 * m.gradient;
      const Vec3& g = m.gradient;
      const double b1 = g.y - l1 * g.x;
      const double b2 = g.z - l2 * g.x - l3 * b1;
      const double z = b2 / d2;
      const double y = b1 / d1 - l3 * z;
      const double x = g.x / d0 - l1 * y - l2 * z;
      return {-x, -y, -z};
    }
    case Mobility::plane: {
      const PlaneBasis basis = plane_basis(motion.axis);
      const Vec3 hu = m.hessian * basis.u;
      const Vec3 hv = m.hessian * basis.v;
      const double gu = dot(m.gradient, basis.u);
      const double gv = dot(m.gradient, basis.v);
      const double uu = dot(basis.u, hu);
      const double uv = dot(basis.u, hv);
      const double vv = dot(basis.v, hv);
      const double lift = 1e-15 * (uu + vv);
      const double det = (uu + lift) * (vv + lift) - uv * uv;
      if (!(det > 0)) return (-gu) * basis.u + (-gv) * basis.v;
      const double s = (uv * gv - (vv + lift) * gu) / det;
      const double t = (uv * gu - (uu + lift) * gv) / det;
      return s * basis.u + t * basis.v;
    }
    case Mobility::line: {
      const double curvature = dot(motion.axis, m.hessian * motion.axis);
      const double slope = dot(m.gradient, motion.axis);
      return (curvature > 0 ? -slope / curvature : -slope) * motion.axis;
    }
    default:
      return {0, 0, 0};
  }
}

/// Gradient within the space of motion (Alg. 2).
TETUNE_HD inline Vec3 tangent_gradient(const Vec3& g, const Motion& motion) {
  switch (motion.kind) {
    case Mobility::free:
      return g;
    case Mobility::plane: {
      const PlaneBasis basis = plane_basis(motion.axis);
      return dot(g, basis.u) * basis.u + dot(g, basis.v) * basis.v;
    }
    case Mobility::line:
      return dot(g, motion.axis) * motion.axis;
    default:
      return {0, 0, 0};
  }
}

struct NewtonStep {
  double relaxation;  ///< 1 <= omega < 2
  /// Part of the ring's energy that the model must promise to take away for a step to be taken. A measure by decrease,
  /// not by length: beside a sliver the way out starts with steps as short as the sliver is flat.
  double min_gain;

  /// Part of the distance to the first inversion that a step may use.
  static constexpr double kReach = 0.9;
  /// A step that takes away this part of the ring's energy was far from a quadratic: another one follows at once.
  static constexpr double kRepeat = 0.1;
  /// Farthest point of a search along a ray, in local lengths: boundary rings may be open along it.
  static constexpr double kFarthest = 4;
  static constexpr int kMaxRepeats = 30;
  static constexpr int kMaxHalvings = 30;

  template <class Ring>
  TETUNE_HD StepResult operator()(Ring& ring, Vec3 x, const Motion& motion) const {
    StepResult result;
    result.position = x;
    for (int repeat = 0; repeat < kMaxRepeats; ++repeat) {
      const RingModel m = ring.model(x);
      if (repeat == 0) {
        const Vec3 g = tangent_gradient(m.gradient, motion);
        result.gradient2 = kTraceFactor * kTraceFactor * dot(g, g);
      }
      const Vec3 p = newton_direction(m, motion);
      if (!(-dot(m.gradient, p) > min_gain * m.value)) break;
      const double leash = motion.leash.reach(x, p);
      if (!(leash > Leash::kShortest)) break;
      double bound = kReach * ring.step_bound(x, p);
      if (leash < bound) bound = leash;
      const Vec3 start = x;
      double decrease = try_steps(ring, m, p, bound < relaxation ? bound : relaxation, x);
      if (decrease == 0) decrease = search_down(ring, m, motion, x);
      if (decrease == 0) break;
      result.decrease += decrease;
      result.relative_move += norm(x - start) / std::sqrt(m.length2);
      if (decrease < kRepeat * m.value) break;
    }
    result.position = x;
    return result;
  }

 private:
  /// Beside a volume that rounding hides, the Hessian is all noise but for one direction: looks along the gradient. So
  /// seldom that it is a function of its own in the machine code, which needs no registers elsewhere.
  template <class Ring>
  TETUNE_HD __attribute__((noinline)) static double search_down(Ring& ring, const RingModel& m, const Motion& motion,
                                                                Vec3& x) {
    const Vec3 g = tangent_gradient(m.gradient, motion);
    const Vec3 down = (-1 / norm(g)) * g;
    const double reach = kReach * ring.step_bound(x, down);
    double farthest = kFarthest * std::sqrt(m.length2);
    const double end = motion.leash.reach(x, down);
    if (end < farthest) farthest = end;
    return try_steps(ring, m, down, brent_minimum(ring.ray(x, down), 0, reach < farthest ? reach : farthest), x);
  }
  /// Halves t until x + t p is certified and lower; moves x there and returns the decrease, or 0.
  template <class Ring>
  TETUNE_HD static double try_steps(Ring& ring, const RingModel& m, const Vec3& p, double t, Vec3& x) {
    for (int halving = 0; halving < kMaxHalvings; ++halving, t *= 0.5) {
      const Vec3 trial = x + t * p;
      const RingValue v = ring.value(trial);
      if (v.certified && v.value < m.value) {
        x = trial;
        return m.value - v.value;
      }
    }
    return 0;
  }
};

struct GradientStep {
  double min_gradient;  ///< the paper's eps_g, on the norm of grad tr

  static constexpr double kReach = 0.95;  ///< the paper's mu
  static constexpr int kMaxHalvings = 30;

  template <class Ring>
  TETUNE_HD StepResult operator()(Ring& ring, Vec3 x, const Motion& motion) const {
    StepResult result;
    result.position = x;
    const RingModel m = ring.model(x);
    const Vec3 g = tangent_gradient(m.gradient, motion);
    const double norm_g = norm(g);
    result.gradient2 = kTraceFactor * kTraceFactor * norm_g * norm_g;
    if (!(kTraceFactor * norm_g >= min_gradient)) return result;
    const Vec3 p = (-1 / norm_g) * g;
    double lambda = kReach * ring.step_bound(x, p);
    const double length = std::sqrt(m.length2);
    // A ring always closes in on its vertex, but a boundary ring may be open along a ray.
    if (!(lambda < 4 * length)) lambda = 4 * length;
    const double leash = motion.leash.reach(x, p);
    if (!(leash > Leash::kShortest * length)) return result;
    if (leash < lambda) lambda = leash;
    for (int halving = 0; halving < kMaxHalvings && !ring.value(x + lambda * p).certified; ++halving) lambda *= 0.5;
    const auto ray = ring.ray(x, p);
    double alpha = brent_minimum(ray, 0, lambda);
    for (int halving = 0; halving < kMaxHalvings; ++halving, alpha *= 0.5) {
      const Vec3 trial = x + alpha * p;
      const RingValue v = ring.value(trial);
      if (v.certified && v.value < m.value) {
        result.decrease = m.value - v.value;
        result.relative_move = alpha / length;
        result.position = trial;
        break;
      }
    }
    return result;
  }
};

}  // namespace tetune
