// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/sliding/trace.hpp"
#include "relocation/step.hpp"

/// The relocation of one boundary vertex in its ring, on the input surface (Sect. 4.3, Alg. 3 and 4).
namespace tetune {

struct SlideResult {
  StepResult step;
  SurfacePoint surface_point;
};

namespace slide_detail {

/// A path over the surface.
struct SurfacePath {
  SurfacePlace end;
  double length;
};

/// The Newton direction within a surface element for a given Hessian; a multiple of the descent where the Hessian is
/// not positive definite or the Newton direction leads out of the element.
TETUNE_HD inline TangentVector newton_direction(const ReferenceView& ref, const Sym3& hessian, const SurfacePoint& from,
                                                const SurfaceElement& element) {
  const Frame& frame = element.frame;
  const TangentVector& b = element.negative_gradient;
  const TangentVector& descent = element.descent;
  const Vec3 hu = hessian * frame.u;
  const double huu = dot(frame.u, hu);
  if (element.on.kind != SurfacePointKind::triangle) return huu > 0 ? TangentVector{b.u / huu, 0} : descent;
  const double huv = dot(frame.v, hu);
  const double hvv = dot(frame.v, hessian * frame.v);
  // The determinant is raised by less than the rounding error.
  const double det = (1 + 1e-15) * huu * hvv - huv * huv;
  if (det > 0) {
    const TangentVector p = (1 / det) * TangentVector{hvv * b.u - huv * b.v, huu * b.v - huv * b.u};
    // At an edge or vertex the descent leads into the element; the Newton direction may not.
    if (from.kind == SurfacePointKind::triangle || frame.increases(entered_from(ref, from, element.on.item), p))
      return p;
  }
  const double curvature =
      dot(descent, TangentVector{huu * descent.u + huv * descent.v, huv * descent.u + hvv * descent.v});
  return (curvature > 0 ? element.descent2 / curvature : 1) * descent;
}

}  // namespace slide_detail

/// The over-relaxed Newton step on the surface. A path of descent for the quadratic model of the ring's energy at x is
/// traced over triangles and edges; the step is accepted where the energy at its end is lower.
struct NewtonSlide {
  double relaxation;  ///< 1 <= omega < 2
  double min_gain;    ///< as in NewtonStep

  static constexpr int kMaxTraceSteps = 16;
  static constexpr double kMaxRelaxation = 1.9;  ///< below 2 each trace step decreases the model

  template <class Ring, class Deviation>
  TETUNE_HD SlideResult operator()(Ring& ring, SurfacePlace at, const ReferenceView& ref, Deviation& deviation,
                                   const DisplacementBound& displacement_bound) const {
    SlideResult result;
    for (int repeat = 0; repeat < NewtonStep::kMaxRepeats; ++repeat) {
      const RingModel m = ring.model(at.position);
      const SurfaceElement first = steepest(ref, at.dof, at.surface_point, m.gradient);
      if (repeat == 0) result.step.gradient2 = kTraceFactor * kTraceFactor * first.descent2;
      if (first.on.kind == SurfacePointKind::none) break;
      const TangentVector p = slide_detail::newton_direction(ref, m.hessian, at.surface_point, first);
      if (!(dot(first.negative_gradient, p) > min_gain * m.value)) break;
      const double length = std::sqrt(m.length2);
      double max_length = NewtonStep::kMaxSearch * length;
      double decrease = 0;
      for (int halving = 0; halving < step_detail::kMaxHalvings; ++halving) {
        const slide_detail::SurfacePath path = trace(ref, m, at, first, p, max_length);
        if (!displacement_bound.contains(path.end.position)) {
          max_length = 0.5 * path.length;
          if (max_length > DisplacementBound::kMinStep * length) continue;
          break;
        }
        const RingValue v = ring.value(path.end.position);
        if (v.certified && v.value < m.value && deviation.allows(path.end.position, path.end.surface_point)) {
          decrease = m.value - v.value;
          result.step.relative_move += path.length / length;
          at = path.end;
          break;
        }
        max_length = 0.5 * path.length;
        if (halving > 0) continue;
        // The distance to the first inversion is computed only after a failed step, as few steps fail.
        const double before_inversion = NewtonStep::kInversionFraction *
                                        ring.step_bound(at.position, first.frame.in_space(p)) * first.frame.length(p);
        if (before_inversion < path.length) max_length = before_inversion;
      }
      if (decrease == 0) break;
      result.step.decrease += decrease;
      if (decrease < NewtonStep::kRepeatDecrease * m.value) break;
    }
    result.step.position = at.position;
    result.surface_point = at.surface_point;
    return result;
  }

 private:
  /// Traces a path of descent of the model around `start`, of length `max_length` at most: first along p.
  TETUNE_HD slide_detail::SurfacePath trace(const ReferenceView& ref, const RingModel& m, const SurfacePlace& start,
                                            const SurfaceElement& first, const TangentVector& p,
                                            double max_length) const {
    slide_detail::SurfacePath path{start, 0};
    double omega = trace_step(ref, first, p, relaxation, max_length, path);
    for (int steps = 1; omega > 0 && steps < kMaxTraceSteps; ++steps) {
      const SurfacePlace& at = path.end;
      const Vec3 gradient = m.gradient + m.hessian * (at.position - start.position);
      const SurfaceElement next = steepest(ref, at.dof, at.surface_point, gradient);
      if (next.on.kind == SurfacePointKind::none) break;
      omega = trace_step(ref, next, slide_detail::newton_direction(ref, m.hessian, at.surface_point, next), omega,
                         max_length, path);
    }
    return path;
  }

  /// Extends the path by omega p, to the boundary of the element or to `max_length` at most; returns the relaxation for
  /// the next step, or 0 at the end of the path.
  TETUNE_HD double trace_step(const ReferenceView& ref, const SurfaceElement& element, const TangentVector& p,
                              double omega, double max_length, slide_detail::SurfacePath& path) const {
    const double speed = element.frame.length(p);
    const double left = max_length - path.length;
    if (!(left > 0)) return 0;
    double t = omega;
    if (omega * speed > left) t = left / speed;
    const TraceResult end = advance(ref, path.end, element, p, t);
    path.end.position = end.position;
    path.end.surface_point = end.surface_point;
    path.length += end.t * speed;
    // Beyond the minimum of the model no direction of descent leads on.
    if (!end.at_boundary || !(end.t < 1)) return 0;
    const double rest = (omega - end.t) / (1 - end.t);
    return rest < kMaxRelaxation ? rest : kMaxRelaxation;
  }
};

/// The step of the paper: Brent's line search on [0, lambda] along the steepest of the adjacent elements, where lambda
/// is the distance to the first inversion or to the boundary of the element.
struct GradientSlide {
  double min_gradient;  ///< the paper's eps_g, on the norm of grad tr

  template <class Ring, class Deviation>
  TETUNE_HD SlideResult operator()(Ring& ring, const SurfacePlace& start, const ReferenceView& ref,
                                   Deviation& deviation, const DisplacementBound& displacement_bound) const {
    const Vec3& x = start.position;
    SlideResult result;
    result.step.position = x;
    result.surface_point = start.surface_point;
    const RingModel m = ring.model(x);
    const SurfaceElement element = steepest(ref, start.dof, start.surface_point, m.gradient);
    const double slope = std::sqrt(element.descent2);
    result.step.gradient2 = kTraceFactor * kTraceFactor * element.descent2;
    if (element.on.kind == SurfacePointKind::none || !(kTraceFactor * slope >= min_gradient)) return result;
    const TangentVector direction = (1 / slope) * element.descent;
    const Vec3 p = element.frame.in_space(direction);
    const double length = std::sqrt(m.length2);
    double lambda = GradientStep::kInversionFraction * ring.step_bound(x, p);
    if (!(lambda < NewtonStep::kMaxSearch * length)) lambda = NewtonStep::kMaxSearch * length;
    lambda = advance(ref, start, element, direction, lambda).t;
    for (int halving = 0; halving < step_detail::kMaxHalvings && !ring.value(x + lambda * p).certified; ++halving)
      lambda *= 0.5;
    double alpha = brent_minimum(ring.ray(x, p), 0, lambda);
    // Brent's method never returns the end of its interval.
    if (alpha > (1 - kEndTolerance) * lambda) alpha = lambda;
    for (int halving = 0; halving < step_detail::kMaxHalvings; ++halving, alpha *= 0.5) {
      const TraceResult end = advance(ref, start, element, direction, alpha);
      if (!displacement_bound.contains(end.position)) continue;
      const RingValue v = ring.value(end.position);
      if (v.certified && v.value < m.value && deviation.allows(end.position, end.surface_point)) {
        result.step.decrease = m.value - v.value;
        result.step.relative_move = end.t / length;
        result.step.position = end.position;
        result.surface_point = end.surface_point;
        break;
      }
    }
    return result;
  }

 private:
  static constexpr double kEndTolerance = 1e-5;
};

/// The slide of boundary vertices that belongs to the step of the other vertices.
TETUNE_HD inline NewtonSlide slide_of(const NewtonStep& step) { return {step.relaxation, step.min_gain}; }
TETUNE_HD inline GradientSlide slide_of(const GradientStep& step) { return {step.min_gradient}; }

}  // namespace tetune
