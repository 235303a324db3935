// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/ring.hpp"

namespace tetune {

/// One vertex's ring in which volumes may be negative: each w is replaced by chi(w) = (w + sqrt(eps^2 + w^2)) / 2,
/// which is positive everywhere and tends to w where w is positive and eps small (Garanzha et al. 2021, "Foldover-free
/// maps in 50 lines of code", Eq. 3). The same interface as PlainRing. Without the term in chi'' the Hessian is that of
/// the convex energy at chi, and so never indefinite (docs/method.md, "Untangling").
class SoftRing {
 public:
  static constexpr Size kCapacity = PlainRing::kCapacity;

  TETUNE_HD SoftRing(const EnergyLaw& law, Span<const Point> points, const LinkFace* faces, Size count,
                     const QualityFloor&)
      : law_(law), points_(points), faces_(faces), count_(count) {}

  TETUNE_HD RingModel model(const Vec3& x) {
    double length2 = 0;
    for (Size i = 0; i < count_; ++i) {
      const Vec3 y = x - face(i).p0;
      length2 += dot(y, y);
    }
    length2 /= static_cast<double>(count_);
    epsilon_ = law_.softness * length2 * std::sqrt(length2);
    ModelSum<double> sum{};
    for (Size i = 0; i < count_; ++i) {
      OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      const Soft w = soft(dot(f.n, y));
      // grad chi / chi = n / root.
      sum.add(law_, f, y, 1 / w.chi, 1.0, w.chi / w.root);
    }
    return to_model(law_, sum, count_);
  }

  /// It never ends: nothing is out of reach.
  TETUNE_HD double step_bound(const Vec3&, const Vec3&) const { return kNever; }

  /// After model().
  TETUNE_HD RingValue value(const Vec3& x) const {
    double e = 0;
    for (Size i = 0; i < count_; ++i) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      e += law_.term(area_term(f, y), 1 / soft(dot(f.n, y)).chi);
    }
    return {law_.factor * e, true};
  }

  class Ray {
   public:
    TETUNE_HD Ray(const SoftRing& ring, const Vec3& x, const Vec3& p) : ring_(ring), x_(x), p_(p) {}
    TETUNE_HD double value(double t) const { return ring_.value(x_ + t * p_).value; }

   private:
    const SoftRing& ring_;
    Vec3 x_, p_;
  };
  TETUNE_HD Ray ray(const Vec3& x, const Vec3& p) const { return {*this, x, p}; }

 private:
  struct Soft {
    double chi, root;
  };
  TETUNE_HD Soft soft(double w) const {
    const double root = std::sqrt(epsilon_ * epsilon_ + w * w);
    // The same without cancellation where w is negative.
    return {w > 0 ? 0.5 * (w + root) : 0.5 * epsilon_ * epsilon_ / (root - w), root};
  }
  TETUNE_HD OppositeFace<double> face(Size i) const {
    const LinkFace f = faces_[i];
    return opposite_face(vec(points_[f.v[0]]), vec(points_[f.v[1]]), vec(points_[f.v[2]]));
  }

  EnergyLaw law_;
  Span<const Point> points_;
  const LinkFace* faces_;
  Size count_;
  double epsilon_ = 0;
};

}  // namespace tetune
