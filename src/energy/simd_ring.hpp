// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "energy/ring.hpp"
#include "mesh/gather.hpp"

namespace tetune {

/// The ring of one vertex on the CPU: gathered once per visit and evaluated in vector registers, kLanes tetrahedra at a
/// time. The bits of all results are those of PlainRing.
class SimdRing {
 public:
  using Pack = backend::Pack4;
  static constexpr int kLanes = kLanesOf<Pack>;
  static_assert(kLanes == kRingLanes);
  static constexpr Size kCapacity = 128;

  SimdRing(const Objective& objective, Span<const Point> points, const LinkFace* faces, Size count,
           const QualityFloor& floor = QualityFloor::none())
      : objective_(objective), floor_(floor), count_(count), packs_(to_index((count + kLanes - 1) / kLanes)) {
    for (int k = 0; k < packs_; ++k) {
      const LinkFace* links[kLanes];
      for (int l = 0; l < kLanes; ++l) {
        const Size i = Size{k} * kLanes + l;
        links[l] = &faces[i < count ? i : count - 1];
      }
      // opposite_face(), computed in place.
      const Vec3T<Pack> p0 = gather(points, links, 0);
      const Vec3T<Pack> a = gather(points, links, 2) - p0;
      const Vec3T<Pack> b = gather(points, links, 1) - p0;
      store(p0, faces_[k].p0);
      store(a, faces_[k].a);
      store(b, faces_[k].b);
      store(cross(a, b), faces_[k].n);
    }
    // The last pack is padded with copies of the last face, of weight 0.
    const Size used = count - Size{packs_ - 1} * kLanes;
    for (int l = 0; l < kLanes; ++l) last_weight_[l] = l < used ? 1 : 0;
  }

  RingModel model(const Vec3& x) {
    const Vec3T<Pack> xs = broadcast(x);
    ModelSum<Pack> total{};
    Pack w_min = zero() + 1.0;
    for (int k = 0; k < packs_; ++k) {
      const OppositeFace<Pack>& f = faces_[k];
      const Vec3T<Pack> y = xs - f.p0;
      const Pack w = dot(f.n, y);
      w_min = w < w_min ? w : w_min;
      inverse_volume_[k] = 1.0 / w;
      total.add(objective_, f, y, inverse_volume_[k], weight(k));
    }
    if (!exceeds_error_bound(min_lane(w_min), sum(total.length2))) return model_with_error_bounds(x);
    const Sym3T<Pack>& h = total.h;
    return to_model(objective_,
                    {sum(total.e),
                     sum(total.length2),
                     {sum(total.g.x), sum(total.g.y), sum(total.g.z)},
                     {sum(h.xx), sum(h.yy), sum(h.zz), sum(h.xy), sum(h.xz), sum(h.yz)}},
                    count_);
  }

  /// Requires a call of model() at the same position before.
  double step_bound(const Vec3&, const Vec3& p) {
    const Vec3T<Pack> ps = broadcast(p);
    Pack rate = zero();
    for (int k = 0; k < packs_; ++k) {
      const Pack r = -(dot(faces_[k].n, ps) * inverse_volume_[k]);
      rate = r > rate ? r : rate;
    }
    return 1 / max_lane(rate);
  }

  RingValue value(const Vec3& x) {
    const Vec3T<Pack> xs = broadcast(x);
    Pack e = zero();
    Pack margin = zero() + 1.0;
    Pack worst = zero();
    for (int k = 0; k < packs_; ++k) {
      const OppositeFace<Pack>& f = faces_[k];
      const Vec3T<Pack> y = xs - f.p0;
      const Pack w = dot(f.n, y);
      const Pack m = volume_margin(f, y, w > 0.0 ? w : zero());
      margin = m < margin ? m : margin;
      Pack shape;
      e += weight(k) * objective_.term(area_term(f, y), 1.0 / w, shape);
      worst = shape > worst ? shape : worst;
    }
    return {objective_.factor * sum(e),
            min_lane(margin) > 0 && (max_lane(worst) <= floor_.safe_shape / kShapeFactor || respects_floor(x))};
  }

  class Ray {
   public:
    Ray(const SimdRing& ring, const Vec3& x, const Vec3& p) : objective_(ring.objective_), count_(ring.count_) {
      for (Size i = 0; i < count_; ++i) {
        const OppositeFace<double> f = ring.face(i);
        terms_[i] = ray_term(f, x - f.p0, p);
      }
    }
    double operator()(double t) const {
      double sum = 0;
      for (Size i = 0; i < count_; ++i) sum += terms_[i].value(objective_, t);
      return sum;
    }

   private:
    Objective objective_;
    Size count_;
    RayTerm terms_[kCapacity];
  };
  Ray ray(const Vec3& x, const Vec3& p) const { return {*this, x, p}; }

 private:
  Pack weight(int pack) const { return pack + 1 < packs_ ? zero() + 1.0 : last_weight_; }
  static Pack zero() { return Pack{}; }
  static Vec3T<Pack> broadcast(const Vec3& x) { return {zero() + x.x, zero() + x.y, zero() + x.z}; }
  template <class F>
  static double fold(const Pack& v, const F& f) {
    double s = v[0];
    for (int l = 1; l < kLanes; ++l) s = f(s, v[l]);
    return s;
  }
  static double sum(const Pack& v) { return fold(v, std::plus<>()); }
  static double max_lane(const Pack& v) {
    return fold(v, [](double a, double b) { return b > a ? b : a; });
  }
  static double min_lane(const Pack& v) {
    return fold(v, [](double a, double b) { return b < a ? b : a; });
  }

  /// Copies one coordinate at a time: g++ copies the whole struct through the stack, with loads that each wait for
  /// several stores.
  TETUNE_INLINE static void store(const Vec3T<Pack>& from, Vec3T<Pack>& to) {
    to.x = from.x;
    to.y = from.y;
    to.z = from.z;
  }

  /// Vertex k of kLanes faces.
  TETUNE_INLINE static Vec3T<Pack> gather(Span<const Point> points, const LinkFace* const f[], int k) {
    return tetune::gather<Pack>(points, {f[0]->v[k], f[1]->v[k], f[2]->v[k], f[3]->v[k]});
  }

  OppositeFace<double> face(Size i) const {
    const OppositeFace<Pack>& f = faces_[i / kLanes];
    const Size l = i % kLanes;
    return {{f.p0.x[l], f.p0.y[l], f.p0.z[l]},
            {f.a.x[l], f.a.y[l], f.a.z[l]},
            {f.b.x[l], f.b.y[l], f.b.z[l]},
            {f.n.x[l], f.n.y[l], f.n.z[l]}};
  }

  /// As allowed() for each face.
  bool respects_floor(const Vec3& x) const {
    const Vec3T<Pack> xs = broadcast(x);
    for (int k = 0; k < packs_; ++k) {
      const OppositeFace<Pack>& f = faces_[k];
      const Vec3T<Pack> y = xs - f.p0;
      const Pack w = dot(f.n, y);
      const Pack term = Objective::shape_term(area_term(f, y), 1.0 / w);
      if (max_lane(term) <= floor_.safe_shape / kShapeFactor) continue;
      const Vec3T<Pack> p[4] = {xs, f.p0, f.p0 + f.b, f.p0 + f.a};
      const Pack shape = kShapeFactor * term;
      const auto is_safe = (term <= floor_.safe_shape / kShapeFactor) | (shape <= floor_.safe_shape);
      const auto is_allowed = floor_.allows_shape(shape, p, w) & floor_.allows(QualityFloor::dihedral_cots(p, w));
      const Pack violation = is_safe | is_allowed ? zero() : zero() + 1.0;
      if (max_lane(violation) > 0) return false;
    }
    return true;
  }

  /// model() for a ring in which the sign of a volume is uncertain: the bound on its rounding error replaces it.
  RingModel model_with_error_bounds(const Vec3& x) {
    ModelSum<double> total{};
    for (Size i = 0; i < Size{packs_} * kLanes; ++i) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      const double r = 1 / safe_volume(f, y);
      inverse_volume_[i / kLanes][i % kLanes] = r;
      if (i < count_) total.add(objective_, f, y, r, 1.0);
    }
    return to_model(objective_, total, count_);
  }

  Objective objective_;
  QualityFloor floor_;
  Size count_;
  int packs_;
  Pack last_weight_;
  OppositeFace<Pack> faces_[kCapacity / kLanes];
  Pack inverse_volume_[kCapacity / kLanes];
};

}  // namespace tetune
