// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "backend/prefetch.hpp"
#include "energy/harmonic.hpp"
#include "energy/quality_floor.hpp"
#include "mesh/csr.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// The face opposite a vertex in one of its tetrahedra: (vertex, v[0], v[1], v[2]) is positive.
struct LinkFace {
  Index v[3];
};

/// The one-rings of all vertices: the faces around vertex i are faces[offsets[i]] .. faces[offsets[i + 1] - 1].
struct RingsView {
  Span<const std::uint32_t> offsets;
  Span<const LinkFace> faces;

  /// Prefetches the first five cache lines of the ring of v, which hold most rings.
  TETUNE_INLINE void prefetch(Index v) const {
    constexpr Size kCacheLine = 64;
    constexpr Size kFaceBytes = sizeof(LinkFace);
    const Size row = offsets[v];
    const char* const first = reinterpret_cast<const char*>(faces.data() + row);
    const Size bytes = std::min(5 * kCacheLine, (faces.size() - row) * kFaceBytes);
    for (Size at = 0; at < bytes; at += kCacheLine) backend::prefetch(first + at);
  }
};

/// The second-order model of f, the sum of the energies over the ring, at a position.
struct RingModel {
  double value;
  Vec3 gradient;
  Sym3 hessian;
  double length2;  ///< mean squared distance of the ring's faces: the square of the local length
};

/// Accumulates a RingModel; T is double or a pack of doubles.
template <class T>
struct ModelSum {
  T e, length2;
  Vec3T<T> g;
  Sym3T<T> h;

  /// Adds the tetrahedron over face f, with r = 1 / w. A weight of 0 leaves it out. `slope` is the derivative of w with
  /// respect to n . y: 1 unless the volume is regularized.
  TETUNE_HD TETUNE_INLINE void add(const Objective& objective, const OppositeFace<T>& f, const Vec3T<T>& y, const T& r,
                                   const T& weight, double slope = 1) {
    const AreaTerm<T> term = area_term_gradient(f, y);
    const Sym3T<T> q = area_term_hessian(f);
    const T energy = weight * objective.term(term.q, r);
    const T inverse_q = 1.0 / term.q;
    const Vec3T<T> u = inverse_q * term.h;
    const Vec3T<T> v = (slope * r) * f.n;
    e += energy;
    length2 += weight * dot(y, y);
    g = g + energy * (objective.gu * u + objective.gv * v);
    const T eq = objective.gu * (energy * inverse_q);
    const Vec3T<T> eu = energy * (objective.uu * u + objective.uv * v);
    const Vec3T<T> ev = energy * (objective.uv * u + objective.vv * v);
    h.xx += eq * q.xx + eu.x * u.x + ev.x * v.x;
    h.yy += eq * q.yy + eu.y * u.y + ev.y * v.y;
    h.zz += eq * q.zz + eu.z * u.z + ev.z * v.z;
    h.xy += eq * q.xy + eu.x * u.y + ev.x * v.y;
    h.xz += eq * q.xz + eu.x * u.z + ev.x * v.z;
    h.yz += eq * q.yz + eu.y * u.z + ev.y * v.z;
  }
};

TETUNE_HD inline RingModel to_model(const Objective& objective, const ModelSum<double>& s, Size count) {
  const double k = objective.factor;
  return {k * s.e,
          k * s.g,
          {k * s.h.xx, k * s.h.yy, k * s.h.zz, k * s.h.xy, k * s.h.xz, k * s.h.yz},
          s.length2 / static_cast<double>(count)};
}

/// w = 6 * volume, or the bound on its rounding error if that is larger; as in tet_energy(), except that underflow of
/// products is not considered.
TETUNE_HD TETUNE_INLINE double safe_volume(const OppositeFace<double>& f, const Vec3& y) {
  const double w = dot(f.n, y);
  const double bound = kOrientBound * permanent(f.a, f.b, y);
  return w > bound ? w : bound;
}

/// f at a position, and whether the position is feasible: each volume is certified positive, and no tetrahedron is
/// worse than the quality floor.
struct RingValue {
  double value;
  bool certified;
};

/// Whether the tetrahedron over a face, of this shape energy, is no worse than the floor.
TETUNE_HD inline bool allowed(const QualityFloor& floor, const OppositeFace<double>& f, const Vec3& x, double shape) {
  const Vec3 p[4] = {x, f.p0, f.p0 + f.b, f.p0 + f.a};
  return floor.allows(shape, p, dot(f.n, x - f.p0));
}

/// The ring of one vertex, read from memory on each evaluation: for the GPU, with one thread per vertex, and for rings
/// of any size. Relocation is written against this interface; SimdRing implements it for the CPU.
class PlainRing {
 public:
  static constexpr Size kCapacity = Size{1} << 31;

  TETUNE_HD PlainRing(const Objective& objective, Span<const Point> points, const LinkFace* faces, Size count,
                      const QualityFloor& floor = QualityFloor::none())
      : objective_(objective), floor_(floor), points_(points), faces_(faces), count_(count) {}

  TETUNE_HD RingModel model(const Vec3& x) {
    ModelSum<double> sum{};
    for (Size i = 0; i < count_; ++i) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      sum.add(objective_, f, y, 1 / safe_volume(f, y), 1.0);
    }
    return to_model(objective_, sum, count_);
  }

  /// The smallest t > 0 at which x + t p leaves the kernel of the ring, or infinity.
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
      e += objective_.term(area_term(f, y), 1 / w, shape);
      certified =
          certified && (kShapeFactor * shape <= floor_.safe_shape || allowed(floor_, f, x, kShapeFactor * shape));
    }
    return {objective_.factor * e, certified};
  }

  /// f along the ray x + t p, in closed form, as a function of t.
  TETUNE_HD auto ray(const Vec3& x, const Vec3& p) const {
    return [this, x, p](double t) {
      double sum = 0;
      for (Size i = 0; i < count_; ++i) {
        const OppositeFace<double> f = face(i);
        sum += ray_term(f, x - f.p0, p).value(objective_, t);
      }
      return sum;
    };
  }

 protected:
  TETUNE_HD OppositeFace<double> face(Size i) const {
    const LinkFace f = faces_[i];
    return opposite_face(vec(points_[f.v[0]]), vec(points_[f.v[1]]), vec(points_[f.v[2]]));
  }

  Objective objective_;
  QualityFloor floor_;
  Span<const Point> points_;
  const LinkFace* faces_;
  Size count_;
};

}  // namespace tetune
