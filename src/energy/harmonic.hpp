// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/objective.hpp"
#include "math/orient.hpp"

/// The harmonic index eta = (sum of squared face areas) / volume (Stroeter et al. 2022, Eq. 5; tr(L) = eta / 9, Eq. 3)
/// of one tetrahedron as a function of one of its vertices. Derivation: docs/method.md, "One tetrahedron as a function
/// of a vertex".
namespace tetune {

/// Tetrahedron (x, p0, p1, p2), positively oriented: a = p2 - p0, b = p1 - p0, n = a x b, and y = x - p0 is the
/// variable. T is double, or a pack of doubles on the CPU.
template <class T>
struct OppositeFace {
  Vec3T<T> p0, a, b, n;
};

/// For positive (x, p0, p1, p2), n . (x - p0) is negative with n = (p1 - p0) x (p2 - p0); the last two vertices are
/// exchanged so that w = n . y = 6 * volume is positive.
template <class T>
TETUNE_HD TETUNE_INLINE OppositeFace<T> opposite_face(const Vec3T<T>& p0, const Vec3T<T>& p1, const Vec3T<T>& p2) {
  const Vec3T<T> a = p2 - p0;
  const Vec3T<T> b = p1 - p0;
  return {p0, a, b, cross(a, b)};
}

/// q(y) = 4 * sum of squared areas, a sum of squares in which nothing cancels, however flat the tetrahedron, and
/// h = grad q / 2.
template <class T>
struct AreaTerm {
  T q;
  Vec3T<T> h;
};

template <class T>
TETUNE_HD TETUNE_INLINE T area_term(const OppositeFace<T>& f, const Vec3T<T>& y) {
  const Vec3T<T> u = cross(y, f.a);
  const Vec3T<T> v = cross(y, f.b);
  const Vec3T<T> s = v - u - f.n;  // y x (b - a) - n
  return dot(u, u) + dot(v, v) + dot(s, s) + dot(f.n, f.n);
}

template <class T>
TETUNE_HD TETUNE_INLINE AreaTerm<T> area_term_gradient(const OppositeFace<T>& f, const Vec3T<T>& y) {
  const Vec3T<T> u = cross(y, f.a);
  const Vec3T<T> v = cross(y, f.b);
  const Vec3T<T> s = v - u - f.n;
  return {dot(u, u) + dot(v, v) + dot(s, s) + dot(f.n, f.n), cross(f.a, u) + cross(f.b, v) + cross(f.b - f.a, s)};
}

/// Hessian of q / 2: sum over the three edges e of (|e|^2 I - e e^T).
template <class T>
TETUNE_HD TETUNE_INLINE Sym3T<T> area_term_hessian(const OppositeFace<T>& f) {
  const Vec3T<T> c = f.b - f.a;
  const T xx = f.a.x * f.a.x + f.b.x * f.b.x + c.x * c.x;
  const T yy = f.a.y * f.a.y + f.b.y * f.b.y + c.y * c.y;
  const T zz = f.a.z * f.a.z + f.b.z * f.b.z + c.z * c.z;
  return {yy + zz,
          xx + zz,
          xx + yy,
          -(f.a.x * f.a.y + f.b.x * f.b.y + c.x * c.y),
          -(f.a.x * f.a.z + f.b.x * f.b.z + c.x * c.z),
          -(f.a.y * f.a.z + f.b.y * f.b.z + c.y * c.z)};
}

/// Square of kOrientBound times the 2 in permanent^2 <= 2 |a|^2 |b|^2 |y|^2 (Cauchy-Schwarz), rounded up.
inline constexpr double kVolumeMargin = 2.01 * kOrientBound * kOrientBound;

/// Positive only if w = n . y is certified positive, that is, above the bound on its rounding error.
template <class T>
TETUNE_HD TETUNE_INLINE T volume_margin(const OppositeFace<T>& f, const Vec3T<T>& y, const T& w_positive) {
  return w_positive * w_positive - kVolumeMargin * (dot(f.a, f.a) * dot(f.b, f.b) * dot(y, y));
}

/// The energy of a positively oriented tetrahedron, and whether its volume is certified positive. If it is not, the
/// energy is computed with the bound on the rounding error in place of the volume: large, but finite.
template <class T>
struct TetEnergyT {
  T energy;
  decltype(T{} > T{}) certified;
  T shape;  ///< the shape energy, whatever the objective
  T q, w;   ///< 4 * sum of squared areas, 6 * volume
};
using TetEnergy = TetEnergyT<double>;

template <class T = double>
TETUNE_HD TETUNE_INLINE TetEnergyT<T> tet_energy(const Objective& objective, const Vec3T<T>& x, const Vec3T<T>& p0,
                                                 const Vec3T<T>& p1, const Vec3T<T>& p2) {
  const OppositeFace<T> f = opposite_face(p0, p1, p2);
  const Vec3T<T> y = x - p0;
  const T volume = dot(f.n, y);
  const T bound = kOrientBound * permanent(f.a, f.b, y);
  const auto certified = is_certified(volume, bound);
  const T w = certified ? volume : bound;
  const T q = area_term(f, y);
  T shape{};
  const T energy = objective.factor * objective.term(q, 1.0 / w, shape);
  return {energy, certified, kShapeFactor * shape, q, w};
}

/// The energy along the ray y + t p: q = A t^2 + 2 B t + C, w = D + E t.
struct RayTerm {
  double a, b, c, d, e;
  TETUNE_HD double value(const Objective& objective, double t) const {
    return objective.factor * objective.term((a * t + 2 * b) * t + c, 1 / (d + e * t));
  }
};

TETUNE_HD TETUNE_INLINE RayTerm ray_term(const OppositeFace<double>& f, const Vec3& y, const Vec3& p) {
  const AreaTerm<double> term = area_term_gradient(f, y);
  const Vec3 u = cross(p, f.a);
  const Vec3 v = cross(p, f.b);
  const Vec3 s = v - u;
  return {dot(u, u) + dot(v, v) + dot(s, s), dot(p, term.h), term.q, dot(f.n, y), dot(f.n, p)};
}

}  // namespace tetune
