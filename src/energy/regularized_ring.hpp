// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/ring.hpp"

namespace tetune {

/// The ring of one vertex in which volumes may be negative: each w is replaced by chi(w) = (w + sqrt(eps^2 + w^2)) / 2,
/// which is positive everywhere and tends to max(w, 0) as eps tends to 0 (Garanzha et al. 2021, "Foldover-free maps in
/// 50 lines of code", Eq. 3). The interface is that of PlainRing, without a floor. The term in chi'' is left out of the
/// Hessian, which is then that of the convex energy at chi and never indefinite (docs/method.md, "Untangling").
class RegularizedRing : PlainRing<> {
 public:
  using PlainRing<>::kCapacity, PlainRing<>::PlainRing;

  TETUNE_HD RingModel model(const Vec3& x) {
    double length2 = 0;
    for (Size i = 0; i < count_; ++i) {
      const Vec3 y = x - face(i).p0;
      length2 += dot(y, y);
    }
    length2 /= static_cast<double>(count_);
    epsilon_ = objective_.regularization * length2 * std::sqrt(length2);
    ModelSum<double> sum{};
    for (Size i = 0; i < count_; ++i) {
      OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      const RegularizedVolume w = regularized(dot(f.n, y));
      // grad chi / chi = n / root.
      sum.add(objective_, f, y, 1 / w.chi, 1.0, w.chi / w.root);
    }
    return to_model(objective_, sum, count_);
  }

  /// The regularized energy is finite everywhere: there is no bound.
  TETUNE_HD double step_bound(const Vec3&, const Vec3&) const { return kInfeasible; }

  /// Requires a call of model() before.
  TETUNE_HD RingValue value(const Vec3& x) const {
    double e = 0;
    for (Size i = 0; i < count_; ++i) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      e += objective_.term(area_term(f, y), 1 / regularized(dot(f.n, y)).chi);
    }
    return {objective_.factor * e, true};
  }

  TETUNE_HD auto ray(const Vec3& x, const Vec3& p) const {
    return [this, x, p](double t) { return value(x + t * p).value; };
  }

 private:
  struct RegularizedVolume {
    double chi, root;
  };
  TETUNE_HD RegularizedVolume regularized(double w) const {
    const double root = std::sqrt(epsilon_ * epsilon_ + w * w);
    // For negative w, the second form of chi has no cancellation.
    return {w > 0 ? 0.5 * (w + root) : 0.5 * epsilon_ * epsilon_ / (root - w), root};
  }
  double epsilon_ = 0;
};

}  // namespace tetune
