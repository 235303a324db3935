// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "backend/macros.hpp"
#include "tetune/types.hpp"

namespace tetune {

/// A vector of R^3 over a scalar type: double, or a pack of doubles (one per SIMD lane).
template <class T>
struct Vec3T {
  T x, y, z;
};
using Vec3 = Vec3T<double>;

inline Vec3 vec(const Point3& p) { return {p[0], p[1], p[2]}; }
inline Point3 to_point(const Vec3& p) { return {p.x, p.y, p.z}; }
inline Point3 midpoint(const Point3& p, const Point3& q) {
  return {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2};
}

template <class T>
TETUNE_HD TETUNE_INLINE Vec3T<T> operator+(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
TETUNE_HD TETUNE_INLINE Vec3T<T> operator-(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class S, class T>
TETUNE_HD TETUNE_INLINE Vec3T<T> operator*(S s, const Vec3T<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
TETUNE_HD TETUNE_INLINE T dot(const Vec3T<T>& a, const Vec3T<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
TETUNE_HD TETUNE_INLINE Vec3T<T> cross(const Vec3T<T>& a, const Vec3T<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
TETUNE_HD inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline double distance(const Point3& p, const Point3& q) { return norm(vec(p) - vec(q)); }
inline Vec3 centroid(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return 0.25 * (a + b + c + d); }

/// A symmetric 3x3 matrix.
template <class T>
struct Sym3T {
  T xx, yy, zz, xy, xz, yz;
};
using Sym3 = Sym3T<double>;

template <class T>
TETUNE_HD TETUNE_INLINE Vec3T<T> operator*(const Sym3T<T>& m, const Vec3T<T>& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}

}  // namespace tetune
