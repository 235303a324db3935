// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/vec3.hpp"

namespace tetune {

/// Bound on the rounding error of orient(), relative to the permanent of the determinant: 8 u with u = 2^-53, above
/// (7 + 56 u) u (Shewchuk, "Adaptive precision floating-point arithmetic", 1997, Sect. 4.3). Fused multiply-adds only
/// reduce the error.
inline constexpr double kOrientBound = 8 * 1.1102230246251565e-16;

/// If the error bound of a determinant of coordinates up to 1 in magnitude is below this, products may underflow and
/// the bound does not hold.
inline constexpr double kOrientUnderflow = 1e-250;

/// Whether a volume is certified positive: it exceeds the bound on its rounding error. T is double or a pack.
template <class T>
TETUNE_HD TETUNE_INLINE auto is_certified(const T& volume, const T& bound) {
  return static_cast<decltype(volume > bound)>((volume > bound) & (bound > kOrientUnderflow));
}

/// Six times the signed volume of a tetrahedron, and the bound on its rounding error. T is double or a pack.
template <class T>
struct OrientT {
  T det;
  T bound;
  TETUNE_HD TETUNE_INLINE auto certified() const { return is_certified(det, bound); }
};
using Orient = OrientT<double>;

/// The absolute value of a double, or of each lane of a pack.
template <class T>
TETUNE_HD TETUNE_INLINE T magnitude(const T& x) {
  if constexpr (requires { x[0]; }) {
    return x > 0.0 ? x : 0.0 - x;  // like std::fabs, never -0
  } else {
    return std::fabs(x);
  }
}

/// The permanent of the matrix (a, b, c) with the magnitudes of all products.
template <class T>
TETUNE_HD TETUNE_INLINE T permanent(const Vec3T<T>& a, const Vec3T<T>& b, const Vec3T<T>& c) {
  return (magnitude(a.y * b.z) + magnitude(a.z * b.y)) * magnitude(c.x) +
         (magnitude(a.z * b.x) + magnitude(a.x * b.z)) * magnitude(c.y) +
         (magnitude(a.x * b.y) + magnitude(a.y * b.x)) * magnitude(c.z);
}

/// Six times the signed volume, without the bound.
template <class T>
TETUNE_HD TETUNE_INLINE T orient_det(const Vec3T<T> p[4]) {
  return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]);
}

template <class T = double>
TETUNE_HD TETUNE_INLINE OrientT<T> orient(const Vec3T<T>& p0, const Vec3T<T>& p1, const Vec3T<T>& p2,
                                          const Vec3T<T>& p3) {
  const Vec3T<T> a = p1 - p0;
  const Vec3T<T> b = p2 - p0;
  const Vec3T<T> c = p3 - p0;
  return {dot(cross(a, b), c), kOrientBound * permanent(a, b, c)};
}

/// The exact sign of det(p1-p0, p2-p0, p3-p0) for any finite coordinates. Host only; called where orient() cannot
/// certify the sign.
int orient_sign(const Point3& p0, const Point3& p1, const Point3& p2, const Point3& p3);

}  // namespace tetune
