// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/vertex_dof.hpp"
#include "energy/ring.hpp"
#include "math/brent.hpp"

/// The relocation of one vertex in its ring (Alg. 1, lines 4 to 30), over any of the rings. On each space of motion the
/// energy is convex (docs/method.md): it has one minimum, which is free of inversions.
namespace tetune {

struct StepResult {
  Vec3 position;
  double decrease = 0;       ///< of the sum of the energy over the ring; 0 where the vertex does not move
  double gradient2 = 0;      ///< squared norm of grad tr = grad eta / 9 within the space of motion, before the step
  double relative_move = 0;  ///< length of the move over the local length
};

inline constexpr double kTraceFactor = 1.0 / 9;  ///< tr(L) = eta / d^2 (Eq. 3)

namespace step_detail {

inline constexpr int kMaxHalvings = 30;

/// Halves t until x + t p is certified and lower; moves x there and returns the decrease, or 0.
template <class Ring>
TETUNE_HD double backtrack(Ring& ring, const RingModel& m, const Vec3& p, double& t, Vec3& x) {
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

}  // namespace step_detail

/// Newton direction of the quadratic model in the space of motion, or the negative gradient where the Hessian is not
/// positive definite; zero for a fixed vertex.
TETUNE_HD inline Vec3 newton_direction(const RingModel& m, const MotionSpace& motion) {
  switch (motion.dof) {
    case VertexDof::free: {
      // Cholesky factorization; the diagonal is raised by less than the rounding error.
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
    case VertexDof::plane: {
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
    case VertexDof::line: {
      const double curvature = dot(motion.axis, m.hessian * motion.axis);
      const double slope = dot(m.gradient, motion.axis);
      return (curvature > 0 ? -slope / curvature : -slope) * motion.axis;
    }
    default:
      return {0, 0, 0};
  }
}

/// The over-relaxed Newton step; repeated where the energy is far from quadratic.
struct NewtonStep {
  double relaxation;  ///< 1 <= omega < 2
  /// The smallest predicted decrease for which a step is taken, relative to the ring's energy. The criterion is not the
  /// length of the step: beside a sliver the first steps are as short as the sliver is flat.
  double min_gain;

  /// The longest step, relative to the distance to the first inversion.
  static constexpr double kInversionFraction = 0.9;
  /// After a relative decrease of at least this the energy was far from quadratic, and another step follows.
  static constexpr double kRepeatDecrease = 0.1;
  /// The longest line search, in local lengths: the ring of a boundary vertex may not bound the ray.
  static constexpr double kMaxSearch = 4;
  static constexpr int kMaxRepeats = 30;

  template <class Ring>
  TETUNE_HD StepResult operator()(Ring& ring, Vec3 x, const MotionSpace& motion) const {
    StepResult result;
    result.position = x;
    for (int repeat = 0; repeat < kMaxRepeats; ++repeat) {
      const RingModel m = ring.model(x);
      if (repeat == 0) {
        const Vec3 g = project(m.gradient, motion);
        result.gradient2 = kTraceFactor * kTraceFactor * dot(g, g);
      }
      const Vec3 p = newton_direction(m, motion);
      if (!(-dot(m.gradient, p) > min_gain * m.value)) break;
      const double displacement_step = motion.displacement_bound.max_step(x, p);
      if (!(displacement_step > DisplacementBound::kMinStep)) break;
      double max_step = kInversionFraction * ring.step_bound(x, p);
      if (displacement_step < max_step) max_step = displacement_step;
      const Vec3 start = x;
      double t = max_step < relaxation ? max_step : relaxation;
      double decrease = step_detail::backtrack(ring, m, p, t, x);
      if (decrease == 0) {
        // Copies for the rare case, so that the compiler may keep ring, model and position in registers.
        Ring ring_of_search = ring;
        Vec3 end = x;
        decrease = search_along_gradient(ring_of_search, RingModel(m), MotionSpace(motion), end);
        x = end;
      }
      if (decrease == 0) break;
      result.decrease += decrease;
      result.relative_move += norm(x - start) / std::sqrt(m.length2);
      if (decrease < kRepeatDecrease * m.value) break;
    }
    result.position = x;
    return result;
  }

 private:
  /// Line search along the negative gradient: beside a volume below the rounding error, the Hessian is noise in all
  /// directions but one. Cold path; kept out of line to reduce register pressure.
  template <class Ring>
  TETUNE_HD __attribute__((noinline)) static double search_along_gradient(Ring& ring, const RingModel& m,
                                                                          const MotionSpace& motion, Vec3& x) {
    const Vec3 g = project(m.gradient, motion);
    const Vec3 descent = (-1 / norm(g)) * g;
    const double before_inversion = kInversionFraction * ring.step_bound(x, descent);
    double end = kMaxSearch * std::sqrt(m.length2);
    const double displacement_step = motion.displacement_bound.max_step(x, descent);
    if (displacement_step < end) end = displacement_step;
    if (before_inversion < end) end = before_inversion;
    double t = brent_minimum(ring.ray(x, descent), 0, end);
    return step_detail::backtrack(ring, m, descent, t, x);
  }
};

/// The step of the paper: Brent's line search along the negative gradient, up to the first inversion.
struct GradientStep {
  double min_gradient;  ///< the paper's eps_g, on the norm of grad tr

  static constexpr double kInversionFraction = 0.95;  ///< the paper's mu

  template <class Ring>
  TETUNE_HD StepResult operator()(Ring& ring, Vec3 x, const MotionSpace& motion) const {
    StepResult result;
    result.position = x;
    const RingModel m = ring.model(x);
    const Vec3 g = project(m.gradient, motion);
    const double norm_g = norm(g);
    result.gradient2 = kTraceFactor * kTraceFactor * norm_g * norm_g;
    if (!(kTraceFactor * norm_g >= min_gradient)) return result;
    const Vec3 p = (-1 / norm_g) * g;
    double lambda = kInversionFraction * ring.step_bound(x, p);
    const double length = std::sqrt(m.length2);
    if (!(lambda < NewtonStep::kMaxSearch * length)) lambda = NewtonStep::kMaxSearch * length;
    const double displacement_step = motion.displacement_bound.max_step(x, p);
    if (!(displacement_step > DisplacementBound::kMinStep * length)) return result;
    if (displacement_step < lambda) lambda = displacement_step;
    for (int halving = 0; halving < step_detail::kMaxHalvings && !ring.value(x + lambda * p).certified; ++halving)
      lambda *= 0.5;
    double alpha = brent_minimum(ring.ray(x, p), 0, lambda);
    result.decrease = step_detail::backtrack(ring, m, p, alpha, result.position);
    if (result.decrease > 0) result.relative_move = alpha / length;
    return result;
  }
};

}  // namespace tetune
