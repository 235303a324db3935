// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "relocate/step.hpp"
#include "surface/deviation.hpp"

/// One boundary vertex in its ring, on the input surface (Sect. 4.3, Alg. 3 and 4).
namespace tetune {

struct SlideResult {
  StepResult step;
  Site site;
};

namespace slide_detail {

/// A way over the surface and where it ends.
struct Walk {
  Vec3 at;
  Site site;
  double length;
};

/// Newton direction within a primitive, for the Hessian there.
TETUNE_HD inline Way newton_direction(const ReferenceView& ref, const Sym3& hessian, const Site& site,
                                      const Primitive& primitive) {
  const Frame& frame = primitive.frame;
  const Way& fall = primitive.fall;
  const Way& down = primitive.down;
  const Vec3 bend = hessian * frame.along;
  const double along = dot(frame.along, bend);
  if (primitive.on.kind != SiteKind::triangle) return along > 0 ? Way{fall.along / along, 0} : down;
  const double mixed = dot(frame.aside, bend);
  const double aside = dot(frame.aside, hessian * frame.aside);
  // The determinant is lifted by less than rounding can tell.
  const double det = (1 + 1e-15) * along * aside - mixed * mixed;
  if (det > 0) {
    const Way p = (1 / det) * Way{aside * fall.along - mixed * fall.aside, along * fall.aside - mixed * fall.along};
    // From an edge or vertex the gradient leads inside; Newton's direction may not.
    if (site.kind == SiteKind::triangle || frame.leads_inside(entered_from(ref, site, primitive.on.item), p)) return p;
  }
  const double curvature =
      dot(down, Way{along * down.along + mixed * down.aside, mixed * down.along + aside * down.aside});
  return (curvature > 0 ? primitive.down2 / curvature : 1) * down;
}

}  // namespace slide_detail

/// The over-relaxed Newton step on the surface: the ring's energy to second order around x is walked down over
/// triangles and edges, and the end of the way is taken when the energy is lower there.
struct NewtonSlide {
  double relaxation;  ///< 1 <= omega < 2
  double min_gain;    ///< as in NewtonStep

  static constexpr int kMaxHops = 16;
  static constexpr double kMostRelaxed = 1.9;  ///< below 2 each hop lowers the model

  template <class Ring>
  TETUNE_HD SlideResult operator()(Ring& ring, Vec3 x, Site site, Mobility walker, const ReferenceView& ref,
                                   const DeviationBound& bound, const Leash& leash) const {
    SlideResult result;
    for (int repeat = 0; repeat < NewtonStep::kMaxRepeats; ++repeat) {
      const RingModel m = ring.model(x);
      const Primitive first = steepest(ref, walker, site, m.gradient);
      if (repeat == 0) result.step.gradient2 = kTraceFactor * kTraceFactor * first.down2;
      if (first.on.kind == SiteKind::none) break;
      const Way p = slide_detail::newton_direction(ref, m.hessian, site, first);
      if (!(dot(first.fall, p) > min_gain * m.value)) break;
      const double length = std::sqrt(m.length2);
      double reach = NewtonStep::kFarthest * length;
      double decrease = 0;
      for (int halving = 0; halving < NewtonStep::kMaxHalvings; ++halving) {
        const slide_detail::Walk walk = descend(ref, walker, m, x, site, first, p, reach);
        if (!leash.holds(walk.at)) {
          reach = 0.5 * walk.length;
          if (reach > Leash::kShortest * length) continue;
          break;
        }
        const RingValue v = ring.value(walk.at);
        if (v.certified && v.value < m.value && bound.allows(walk.at, walk.site)) {
          decrease = m.value - v.value;
          result.step.relative_move += walk.length / length;
          x = walk.at;
          site = walk.site;
          break;
        }
        reach = 0.5 * walk.length;
        if (halving > 0) continue;
        // Where the ring inverts is only asked when a walk failed, as few do.
        const double inverts = NewtonStep::kReach * ring.step_bound(x, first.frame.in_space(p)) * first.frame.length(p);
        if (inverts < walk.length) reach = inverts;
      }
      if (decrease == 0) break;
      result.step.decrease += decrease;
      if (decrease < NewtonStep::kRepeat * m.value) break;
    }
    result.step.position = x;
    result.site = site;
    return result;
  }

 private:
  /// Walks the model down from x, at most `reach` far: first along p.
  TETUNE_HD slide_detail::Walk descend(const ReferenceView& ref, Mobility walker, const RingModel& m, const Vec3& x,
                                       const Site& start, const Primitive& first, const Way& p, double reach) const {
    slide_detail::Walk walk{x, start, 0};
    double omega = hop(ref, walker, first, p, relaxation, reach, walk);
    for (int hops = 1; omega > 0 && hops < kMaxHops; ++hops) {
      const Primitive next = steepest(ref, walker, walk.site, m.gradient + m.hessian * (walk.at - x));
      if (next.on.kind == SiteKind::none) break;
      omega =
          hop(ref, walker, next, slide_detail::newton_direction(ref, m.hessian, walk.site, next), omega, reach, walk);
    }
    return walk;
  }

  /// Goes by omega p, to the primitive's rim or to the end of the reach; returns the omega to go on with, or 0.
  TETUNE_HD double hop(const ReferenceView& ref, Mobility walker, const Primitive& primitive, const Way& p,
                       double omega, double reach, slide_detail::Walk& walk) const {
    const double speed = primitive.frame.length(p);
    const double left = reach - walk.length;
    if (!(left > 0)) return 0;
    double t = omega;
    if (omega * speed > left) t = left / speed;
    const Landing landing = advance(ref, walker, primitive, walk.site, walk.at, p, t);
    walk.at = landing.at;
    walk.site = landing.site;
    walk.length += landing.t * speed;
    // Beyond the model's minimum there is no way on that leads down.
    if (!landing.at_rim || !(landing.t < 1)) return 0;
    const double rest = (omega - landing.t) / (1 - landing.t);
    return rest < kMostRelaxed ? rest : kMostRelaxed;
  }
};

/// The paper's step: along the steepest of the adjacent primitives, Brent's line search on [0, lambda], where lambda
/// reaches to the first inversion or to the primitive's rim.
struct GradientSlide {
  double min_gradient;  ///< the paper's eps_g, on the norm of grad tr

  template <class Ring>
  TETUNE_HD SlideResult operator()(Ring& ring, const Vec3& x, const Site& site, Mobility walker,
                                   const ReferenceView& ref, const DeviationBound& bound, const Leash& leash) const {
    SlideResult result;
    result.step.position = x;
    result.site = site;
    const RingModel m = ring.model(x);
    const Primitive primitive = steepest(ref, walker, site, m.gradient);
    const double slope = std::sqrt(primitive.down2);
    result.step.gradient2 = kTraceFactor * kTraceFactor * primitive.down2;
    if (primitive.on.kind == SiteKind::none || !(kTraceFactor * slope >= min_gradient)) return result;
    const Way way = (1 / slope) * primitive.down;
    const Vec3 p = primitive.frame.in_space(way);
    const double length = std::sqrt(m.length2);
    double lambda = GradientStep::kReach * ring.step_bound(x, p);
    if (!(lambda < NewtonStep::kFarthest * length)) lambda = NewtonStep::kFarthest * length;
    lambda = advance(ref, walker, primitive, site, x, way, lambda).t;
    for (int halving = 0; halving < GradientStep::kMaxHalvings && !ring.value(x + lambda * p).certified; ++halving)
      lambda *= 0.5;
    double alpha = brent_minimum(ring.ray(x, p), 0, lambda);
    // Brent's method never returns the end of its interval.
    if (alpha > (1 - kAtEnd) * lambda) alpha = lambda;
    for (int halving = 0; halving < GradientStep::kMaxHalvings; ++halving, alpha *= 0.5) {
      const Landing landing = advance(ref, walker, primitive, site, x, way, alpha);
      if (!leash.holds(landing.at)) continue;
      const RingValue v = ring.value(landing.at);
      if (v.certified && v.value < m.value && bound.allows(landing.at, landing.site)) {
        result.step.decrease = m.value - v.value;
        result.step.relative_move = landing.t / length;
        result.step.position = landing.at;
        result.site = landing.site;
        break;
      }
    }
    return result;
  }

 private:
  static constexpr double kAtEnd = 1e-5;
};

/// How boundary vertices slide where all others take `Step`.
TETUNE_HD inline NewtonSlide slide_of(const NewtonStep& step) { return {step.relaxation, step.min_gain}; }
TETUNE_HD inline GradientSlide slide_of(const GradientStep& step) { return {step.min_gradient}; }

}  // namespace tetune
