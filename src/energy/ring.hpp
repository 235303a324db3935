// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "core/quality_floor.hpp"
#include "core/rows.hpp"
#include "core/work_mesh.hpp"
#include "energy/harmonic.hpp"
#include "par/prefetch.hpp"

namespace tetune {

/// The face opposite a vertex in one of its tetrahedra: (vertex, v[0], v[1], v[2]) is positive.
struct LinkFace {
  Index v[3];
};

/// The one-rings of all vertices: the faces around vertex i are faces[offsets[i]] .. faces[offsets[i + 1] - 1].
struct RingsView {
  Span<const std::uint32_t> offsets;
  Span<const LinkFace> faces;

  /// The first faces of the ring of v, most rings whole.
  TETUNE_INLINE void prefetch(Index v) const {
    const Size row = offsets[v];
    const char* const first = reinterpret_cast<const char*>(faces.data() + row);
    const Size bytes = std::min<Size>(5 * 64, (faces.size() - row) * static_cast<Size>(sizeof(LinkFace)));
    for (Size at = 0; at < bytes; at += 64) par::prefetch(first + at);
  }
};

/// f = sum of the energies over the ring, to second order around a position.
struct RingModel {
  double value;
  Vec3 gradient;
  Sym3 hessian;
  double length2;  ///< mean squared distance of the ring's faces: the square of the local length
};

/// The sum that makes a RingModel, over doubles or packs of them.
template <class T>
struct ModelSum {
  T e, length2;
  Vec3T<T> g;
  Sym3T<T> h;

  /// r = 1 / w of this tetrahedron; weight 1 counts it, 0 leaves it out. `slope`: of w in n . y, 1 unless w is soft.
  TETUNE_HD TETUNE_INLINE void add(const EnergyLaw& law, const OppositeFace<T>& f, const Vec3T<T>& y, const T& r,
                                   const T& weight, double slope = 1) {
    const AreaTerm<T> term = area_term_gradient(f, y);
    const Sym3T<T> q = area_term_hessian(f);
    const T energy = weight * law.term(term.q, r);
    const T inverse_q = 1.0 / term.q;
    const Vec3T<T> u = inverse_q * term.h;
    const Vec3T<T> v = (slope * r) * f.n;
    e += energy;
    length2 += weight * dot(y, y);
    g = g + energy * (law.gu * u + law.gv * v);
    const T eq = law.gu * (energy * inverse_q);
    const Vec3T<T> eu = energy * (law.uu * u + law.uv * v);
    const Vec3T<T> ev = energy * (law.uv * u + law.vv * v);
    h.xx += eq * q.xx + eu.x * u.x + ev.x * v.x;
    h.yy += eq * q.yy + eu.y * u.y + ev.y * v.y;
    h.zz += eq * q.zz + eu.z * u.z + ev.z * v.z;
    h.xy += eq * q.xy + eu.x * u.y + ev.x * v.y;
    h.xz += eq * q.xz + eu.x * u.z + ev.x * v.z;
    h.yz += eq * q.yz + eu.y * u.z + ev.y * v.z;
  }
};

TETUNE_HD inline RingModel to_model(const EnergyLaw& law, const ModelSum<double>& s, Size count) {
  const double k = law.factor;
  return {k * s.e,
          k * s.g,
          {k * s.h.xx, k * s.h.yy, k * s.h.zz, k * s.h.xy, k * s.h.xz, k * s.h.yz},
          s.length2 / static_cast<double>(count)};
}

/// w = 6 v; where rounding may have made it, the bound on the error stands for it, as in tet_energy() but where
/// products underflow.
TETUNE_HD TETUNE_INLINE double safe_volume(const OppositeFace<double>& f, const Vec3& y) {
  const double w = dot(f.n, y);
  const double bound = kOrientBound * permanent(f.a, f.b, y);
  return w > bound ? w : bound;
}

/// f at a position, and whether a vertex may be there: each volume is certified positive, and no tetrahedron worse than
/// the floor.
struct RingValue {
  double value;
  bool certified;
};

/// Whether the tetrahedron over a face is no worse than the floor.
TETUNE_HD inline bool allowed(const QualityFloor& floor, const OppositeFace<double>& f, const Vec3& x, double shape) {
  const Vec3 p[4] = {x, f.p0, f.p0 + f.b, f.p0 + f.a};
  return floor.allows(shape, p, dot(f.n, x - f.p0));
}

/// One vertex's ring, read from memory each time: for the GPU, one thread a vertex, and for rings of any size.
/// The interface that relocation is written against; SimdRing is the same for the CPU.
class PlainRing {
 public:
  static constexpr Size kCapacity = Size{1} << 31;

  TETUNE_HD PlainRing(const EnergyLaw& law, Span<const Point> points, const LinkFace* faces, Size count,
                      const QualityFloor& floor = QualityFloor::none())
      : law_(law), floor_(floor), points_(points), faces_(faces), count_(count) {}

  TETUNE_HD RingModel model(const Vec3& x) {
    ModelSum<double> sum{};
    for (Size i = 0; i < count_; ++i) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      sum.add(law_, f, y, 1 / safe_volume(f, y), 1.0);
    }
    return to_model(law_, sum, count_);
  }

  /// First t > 0 at which x + t p leaves the kernel of the ring; infinity if none.
  TETUNE_HD double step_bound(const Vec3& x, const Vec3& p) {
    double rate = 0;
    for (Size i = 0; i < count_; ++i) {
      const OppositeFace<double> f = face(i);
      const double r = -dot(f.n, p) / safe_volume(f, x - f.p0);
      rate = r > rate ? r : rate;
    }
    return 1 / rate;
  }

  TETUNE_HD RingValue value(const Vec3& x) {
    double e = 0;
    bool certified = true;
    for (Size i = 0; i < count_ && certified; ++i) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      const double w = dot(f.n, y);
      double shape = 0;
      certified = w > 0 && volume_margin(f, y, w) > 0;
      e += law_.term(area_term(f, y), 1 / w, shape);
      certified =
          certified && (kShapeFactor * shape <= floor_.safe_shape || allowed(floor_, f, x, kShapeFactor * shape));
    }
    return {law_.factor * e, certified};
  }

  /// f along x + t p, in closed form.
  class Ray {
   public:
    TETUNE_HD Ray(const PlainRing& ring, const Vec3& x, const Vec3& p) : ring_(ring), x_(x), p_(p) {}
    TETUNE_HD double value(double t) const {
      double sum = 0;
      for (Size i = 0; i < ring_.count_; ++i) {
        const OppositeFace<double> f = ring_.face(i);
        sum += ray_term(f, x_ - f.p0, p_).value(ring_.law_, t);
      }
      return sum;
    }

   private:
    const PlainRing& ring_;
    Vec3 x_, p_;
  };
  TETUNE_HD Ray ray(const Vec3& x, const Vec3& p) const { return {*this, x, p}; }

 private:
  TETUNE_HD OppositeFace<double> face(Size i) const {
    const LinkFace f = faces_[i];
    return opposite_face(vec(points_[f.v[0]]), vec(points_[f.v[1]]), vec(points_[f.v[2]]));
  }

  EnergyLaw law_;
  QualityFloor floor_;
  Span<const Point> points_;
  const LinkFace* faces_;
  Size count_;
};

}  // namespace tetune
