// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/gather.hpp"
#include "energy/ring.hpp"

namespace tetune {

/// The ring on the CPU: gathered once a visit, kLanes tetrahedra at a time in vector registers. The sums run in a
/// fixed order, so the result is the same on every run of one build.
class SimdRing {
 public:
  static constexpr int kLanes = 4;
  static constexpr Size kCapacity = 128;
  typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double)), may_alias));

  SimdRing(const EnergyLaw& law, Span<const Point> points, const LinkFace* faces, Size count,
           const QualityFloor& floor = QualityFloor::none())
      : law_(law), floor_(floor), count_(count), packs_(static_cast<int>((count + kLanes - 1) / kLanes)) {
    for (int k = 0; k < packs_; ++k) {
      const LinkFace* links[kLanes];
      for (int l = 0; l < kLanes; ++l) {
        const Size i = Size{k} * kLanes + l;
        links[l] = &faces[i < count ? i : count - 1];
      }
      // As opposite_face(), but in place.
      const Vec3T<Lanes> p0 = gather(points, links, 0);
      const Vec3T<Lanes> a = gather(points, links, 2) - p0;
      const Vec3T<Lanes> b = gather(points, links, 1) - p0;
      put(p0, faces_[k].p0);
      put(a, faces_[k].a);
      put(b, faces_[k].b);
      put(cross(a, b), faces_[k].n);
    }
    // The last pack is filled up with copies of the last face, which count for nothing.
    const int used = static_cast<int>(count - Size{packs_ - 1} * kLanes);
    for (int l = 0; l < kLanes; ++l) last_weight_[l] = l < used ? 1 : 0;
  }

  RingModel model(const Vec3& x) {
    const Vec3T<Lanes> xs = spread(x);
    ModelSum<Lanes> total{};
    Lanes w_min = zero() + 1.0;
    for (int k = 0; k < packs_; ++k) {
      const OppositeFace<Lanes>& f = faces_[k];
      const Vec3T<Lanes> y = xs - f.p0;
      const Lanes w = dot(f.n, y);
      w_min = w < w_min ? w : w_min;
      inverse_volume_[k] = 1.0 / w;
      total.add(law_, f, y, inverse_volume_[k], weight(k));
    }
    // Beyond the bound on its error each volume is, if the smallest is beyond that of the largest faces there could be:
    // permanent <= sqrt(2) |a| |b| |y|, and |a|, |b| are at most twice the longest y.
    const double length2 = sum(total.length2);
    if (!(least(w_min) > 6 * kOrientBound * length2 * std::sqrt(length2))) return doubtful_model(x);
    const Sym3T<Lanes>& h = total.h;
    return to_model(law_,
                    {sum(total.e),
                     sum(total.length2),
                     {sum(total.g.x), sum(total.g.y), sum(total.g.z)},
                     {sum(h.xx), sum(h.yy), sum(h.zz), sum(h.xy), sum(h.xz), sum(h.yz)}},
                    count_);
  }

  /// After model() at the same position.
  double step_bound(const Vec3&, const Vec3& p) {
    const Vec3T<Lanes> ps = spread(p);
    Lanes rate = zero();
    for (int k = 0; k < packs_; ++k) {
      const Lanes r = -(dot(faces_[k].n, ps) * inverse_volume_[k]);
      rate = r > rate ? r : rate;
    }
    return 1 / most(rate);
  }

  RingValue value(const Vec3& x) {
    const Vec3T<Lanes> xs = spread(x);
    Lanes e = zero();
    Lanes margin = zero() + 1.0;
    Lanes worst = zero();
    for (int k = 0; k < packs_; ++k) {
      const OppositeFace<Lanes>& f = faces_[k];
      const Vec3T<Lanes> y = xs - f.p0;
      const Lanes w = dot(f.n, y);
      const Lanes m = volume_margin(f, y, w > 0.0 ? w : zero());
      margin = m < margin ? m : margin;
      Lanes shape;
      e += weight(k) * law_.term(area_term(f, y), 1.0 / w, shape);
      worst = shape > worst ? shape : worst;
    }
    return {law_.factor * sum(e),
            least(margin) > 0 && (most(worst) <= floor_.safe_shape / kShapeFactor || keeps_floor(x))};
  }

  class Ray {
   public:
    Ray(const SimdRing& ring, const Vec3& x, const Vec3& p) : law_(ring.law_), count_(ring.count_) {
      for (Size i = 0; i < count_; ++i) {
        const OppositeFace<double> f = ring.face(i);
        terms_[i] = ray_term(f, x - f.p0, p);
      }
    }
    double value(double t) const {
      double sum = 0;
      for (Size i = 0; i < count_; ++i) sum += terms_[i].value(law_, t);
      return sum;
    }

   private:
    EnergyLaw law_;
    Size count_;
    RayTerm terms_[kCapacity];
  };
  Ray ray(const Vec3& x, const Vec3& p) const { return {*this, x, p}; }

 private:
  Lanes weight(int pack) const { return pack + 1 < packs_ ? zero() + 1.0 : last_weight_; }
  static Lanes zero() { return Lanes{}; }
  static Vec3T<Lanes> spread(const Vec3& x) { return {zero() + x.x, zero() + x.y, zero() + x.z}; }
  static double sum(const Lanes& v) {
    double s = v[0];
    for (int l = 1; l < kLanes; ++l) s += v[l];
    return s;
  }
  static double most(const Lanes& v) {
    double s = v[0];
    for (int l = 1; l < kLanes; ++l) s = v[l] > s ? v[l] : s;
    return s;
  }
  static double least(const Lanes& v) {
    double s = v[0];
    for (int l = 1; l < kLanes; ++l) s = v[l] < s ? v[l] : s;
    return s;
  }

  /// One coordinate after the other: g++ copies the whole through the stack, in loads that wait for several stores
  /// each.
  TETUNE_INLINE static void put(const Vec3T<Lanes>& from, Vec3T<Lanes>& to) {
    to.x = from.x;
    to.y = from.y;
    to.z = from.z;
  }

  /// Corner k of kLanes faces.
  TETUNE_INLINE static Vec3T<Lanes> gather(Span<const Point> points, const LinkFace* const f[], int k) {
    return tetune::gather<Lanes>(points, {f[0]->v[k], f[1]->v[k], f[2]->v[k], f[3]->v[k]});
  }

  OppositeFace<double> face(Size i) const {
    const OppositeFace<Lanes>& f = faces_[i / kLanes];
    const int l = static_cast<int>(i % kLanes);
    return {{f.p0.x[l], f.p0.y[l], f.p0.z[l]},
            {f.a.x[l], f.a.y[l], f.a.z[l]},
            {f.b.x[l], f.b.y[l], f.b.z[l]},
            {f.n.x[l], f.n.y[l], f.n.z[l]}};
  }

  bool keeps_floor(const Vec3& x) const {
    for (Size i = 0; i < count_; ++i) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      const double shape = kShapeFactor * EnergyLaw::shape_term(area_term(f, y), 1 / dot(f.n, y));
      if (shape > floor_.safe_shape && !allowed(floor_, f, x, shape)) return false;
    }
    return true;
  }

  /// model() for a ring in which rounding leaves a volume in doubt: that volume counts with the bound on its error.
  RingModel doubtful_model(const Vec3& x) {
    ModelSum<double> total{};
    for (Size i = 0; i < Size{packs_} * kLanes; ++i) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      const double r = 1 / safe_volume(f, y);
      inverse_volume_[i / kLanes][static_cast<int>(i % kLanes)] = r;
      if (i < count_) total.add(law_, f, y, r, 1.0);
    }
    return to_model(law_, total, count_);
  }

  EnergyLaw law_;
  QualityFloor floor_;
  Size count_;
  int packs_;
  Lanes last_weight_;
  OppositeFace<Lanes> faces_[kCapacity / kLanes];
  Lanes inverse_volume_[kCapacity / kLanes];
};

}  // namespace tetune
