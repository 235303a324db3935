// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "par/macros.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// A vector of R^3 over a scalar type: double, or a pack of doubles (SIMD lanes).
template <class T>
struct Vec3T {
  T x, y, z;
};
using Vec3 = Vec3T<double>;

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

/// A vertex position as stored: padded to 32 bytes, so that one lies in one cache line and loads in one go.
struct alignas(32) Point {
  double x, y, z, pad;
};
TETUNE_HD TETUNE_INLINE Vec3 vec(const Point& p) { return {p.x, p.y, p.z}; }
inline Vec3 vec(const Point3& p) { return {p[0], p[1], p[2]}; }
TETUNE_HD TETUNE_INLINE Point point(const Vec3& v) { return {v.x, v.y, v.z, 0}; }

/// The four vertices of a tetrahedron.
struct alignas(16) Tet {
  Index v[4];
  TETUNE_HD Index operator[](int i) const { return v[i]; }
  TETUNE_HD Index& operator[](int i) { return v[i]; }
};

/// Face i of a tetrahedron lies opposite vertex i; with the vertex in front, (i, kFace[i]) is an even permutation,
/// so the face is seen counter-clockwise from outside turned to the inside.
TETUNE_HD TETUNE_INLINE int face_vertex(int face, int k) {
  // One nibble a vertex: {1,2,3}, {0,3,2}, {0,1,3}, {0,2,1}.
  return static_cast<int>((0x120310230321ULL >> (12 * face + 4 * k)) & 3);
}

/// Local index of a vertex in a tetrahedron that has it.
TETUNE_HD TETUNE_INLINE int local_index(const Tet& tet, Index vertex) {
  return tet.v[1] == vertex ? 1 : tet.v[2] == vertex ? 2 : tet.v[3] == vertex ? 3 : 0;
}

}  // namespace tetune
