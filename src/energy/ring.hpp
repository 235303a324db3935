// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "backend/prefetch.hpp"
#include "backend/team.hpp"
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
  TETUNE_HD ModelSum& operator+=(const ModelSum& other) {
    e += other.e;
    length2 += other.length2;
    g = g + other.g;
    h.xx += other.h.xx;
    h.yy += other.h.yy;
    h.zz += other.h.zz;
    h.xy += other.h.xy;
    h.xz += other.h.xz;
    h.yz += other.h.yz;
    return *this;
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

/// Sums over a ring are made of this many partial sums, one per lane of a vector or thread of a team (larger teams have
/// several threads per partial sum): that of lane l over the faces l, l + kRingLanes, ..., all of which are then added
/// in the order of the lanes. All rings give the same bits.
inline constexpr int kRingLanes = 4;

/// Each volume of a ring exceeds the bound on its rounding error if the smallest, `w_min`, exceeds the bound for the
/// largest faces, where `length2` is the sum of the squared distances |y|^2: permanent <= sqrt(2) |a| |b| |y|, and |a|,
/// |b| are at most twice the longest distance from a vertex of the ring. That is about the longest y, which are the
/// distances from one vertex of each face: in a very uneven ring the test may hold where a volume is not certified, and
/// a step from such a position is longer or shorter than it should be. The end of each step is certified.
TETUNE_HD TETUNE_INLINE bool exceeds_error_bound(double w_min, double length2) {
  return w_min > 6 * kOrientBound * length2 * std::sqrt(length2);
}

/// The ring of one vertex, read from memory on each evaluation: for a GPU, where a team evaluates it (every thread
/// calls each function with the same arguments and gets the same result), and for rings of any size. Relocation is
/// written against this interface; SimdRing implements it for the CPU.
template <class Team = backend::SingleThread>
class PlainRing {
 public:
  static constexpr Size kCapacity = Size{1} << 31;
  static_assert(kRingLanes % Team::kSize == 0 || Team::kSize % kRingLanes == 0);

  TETUNE_HD PlainRing(const Objective& objective, Span<const Point> points, const LinkFace* faces, Size count,
                      const QualityFloor& floor = QualityFloor::none())
      : objective_(objective), floor_(floor), points_(points), faces_(faces), count_(count) {}

  TETUNE_HD RingModel model(const Vec3& x) {
    double w_min = 1;
    const auto sum = sum_over_faces<ModelSum<double>>([&](const OppositeFace<double>& f, ModelSum<double>& partial) {
      const Vec3 y = x - f.p0;
      const double w = dot(f.n, y);
      w_min = w < w_min ? w : w_min;
      partial.add(objective_, f, y, 1 / w, 1.0);
    });
    is_uncertain_ = !exceeds_error_bound(-team_.merge(backend::Max{-w_min}).value, sum.length2);
    // A copy for the rare case, so that the compiler may keep the ring in registers.
    return is_uncertain_ ? PlainRing(*this).model_with_error_bounds(x) : to_model(objective_, sum, count_);
  }

  /// The smallest t > 0 at which x + t p leaves the kernel of the ring, or infinity. Requires a call of model() at the
  /// same position before.
  TETUNE_HD double step_bound(const Vec3& x, const Vec3& p) {
    backend::Max rate{0};
    for (Size i = team_.rank(); i < count_; i += Team::kSize) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      rate.merge({-(dot(f.n, p) * (1 / (is_uncertain_ ? safe_volume(f, y) : dot(f.n, y))))});
    }
    return 1 / team_.merge(rate).value;
  }

  TETUNE_HD RingValue value(const Vec3& x) {
    bool certified = true;
    const auto sum = sum_over_faces<double>([&](const OppositeFace<double>& f, double& partial) {
      const Vec3 y = x - f.p0;
      const double w = dot(f.n, y);
      double shape = 0;
      partial += objective_.term(area_term(f, y), 1 / w, shape);
      certified = certified && w > 0 && volume_margin(f, y, w) > 0 &&
                  (shape <= floor_.safe_shape / kShapeFactor || allowed(floor_, f, x, kShapeFactor * shape));
    });
    return {objective_.factor * sum, !team_.any(!certified)};
  }

  /// f along the ray x + t p, in closed form, as a function of t. Summed in the order of the faces.
  TETUNE_HD auto ray(const Vec3& x, const Vec3& p) const {
    return [this, x, p](double t) {
      double sum = 0;
      TETUNE_ROLLED
      for (Size begin = 0; begin < count_; begin += Team::kSize) {
        const Size i = begin + team_.rank();
        double own = 0;
        if (i < count_) {
          const OppositeFace<double> f = face(i);
          own = ray_term(f, x - f.p0, p).value(objective_, t);
        }
        TETUNE_ROLLED
        for (int k = 0; k < Team::kSize && begin + k < count_; ++k) sum += team_.broadcast(own, k);
      }
      return sum;
    };
  }

 protected:
  TETUNE_HD OppositeFace<double> face(Size i) const {
    const LinkFace f = faces_[i];
    return opposite_face(vec(points_[f.v[0]]), vec(points_[f.v[1]]), vec(points_[f.v[2]]));
  }

 private:
  static constexpr int kLanesOfThread = Team::kSize < kRingLanes ? kRingLanes / Team::kSize : 1;

  /// The sum over the lanes of their partial sums, to which f(face, partial) adds the term of a face.
  template <class T, class F>
  TETUNE_HD T sum_over_faces(const F& f) const {
    if constexpr (Team::kSize > kRingLanes) {
      return total({partial_of_terms<T>(f)});
    } else {
      T partial[kLanesOfThread]{};
      for (Size i = team_.rank(); i < count_; i += Team::kSize) f(face(i), partial[i % kRingLanes / Team::kSize]);
      return total(partial);
    }
  }
  /// The partial sum of lane rank() % kRingLanes. Each thread has the term of one face at a time.
  template <class T, class F>
  TETUNE_HD T partial_of_terms(const F& f) const {
    const int lane = team_.rank() % kRingLanes;
    T partial{};
    TETUNE_ROLLED
    for (Size begin = 0; begin < count_; begin += Team::kSize) {
      T own{};
      if (begin + team_.rank() < count_) f(face(begin + team_.rank()), own);
      TETUNE_ROLLED
      for (int first = 0; first < Team::kSize && begin + first < count_; first += kRingLanes) {
        const T term = team_.broadcast(own, first + lane);
        if (begin + first + lane < count_) partial += term;
      }
    }
    return partial;
  }
  /// The sum over all lanes, in their order.
  template <class T>
  TETUNE_HD T total(const T (&partial)[kLanesOfThread]) const {
    T sum = team_.broadcast(partial[0], 0);
    for (int lane = 1; lane < kRingLanes; ++lane) {
      sum += team_.broadcast(partial[lane / Team::kSize], lane % Team::kSize);
    }
    return sum;
  }
  /// model() for a ring in which the sign of a volume is uncertain: the bound on its rounding error replaces it. Each
  /// thread computes it all, in the order of the faces.
  TETUNE_HD __attribute__((noinline)) RingModel model_with_error_bounds(const Vec3& x) const {
    ModelSum<double> sum{};
    TETUNE_ROLLED
    for (Size i = 0; i < count_; ++i) {
      const OppositeFace<double> f = face(i);
      const Vec3 y = x - f.p0;
      sum.add(objective_, f, y, 1 / safe_volume(f, y), 1.0);
    }
    return to_model(objective_, sum, count_);
  }

 protected:
  Objective objective_;
  QualityFloor floor_;
  Span<const Point> points_;
  const LinkFace* faces_;
  Size count_;

 private:
  Team team_;
  bool is_uncertain_ = false;
};

}  // namespace tetune
