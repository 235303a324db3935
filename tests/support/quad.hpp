// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "math/vec3.hpp"
#include "mesh/tet.hpp"

/// Definitions in arithmetic of 113 bits.
namespace tetune::test {

/// A real of 113 bits: a type of its own on x86-64, long double on AArch64 and in WebAssembly.
#ifdef __SIZEOF_FLOAT128__
using Quad = __float128;
#else
using Quad = long double;
static_assert(std::numeric_limits<Quad>::digits == 113);
#endif

struct QuadVec {
  std::array<Quad, 3> x;
};

inline QuadVec operator-(const QuadVec& a, const QuadVec& b) {
  return {{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]}};
}
inline QuadVec cross(const QuadVec& a, const QuadVec& b) {
  return {{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2], a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}
inline Quad dot(const QuadVec& a, const QuadVec& b) { return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2]; }

using QuadTet = std::array<QuadVec, 4>;

inline QuadTet quad_tet(const Vec3 p[4]) {
  QuadTet tet{};
  for (std::size_t k = 0; k < 4; ++k) tet[k] = {{p[k].x, p[k].y, p[k].z}};
  return tet;
}

inline Quad plain_volume(const QuadTet& p) { return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) / 6; }

/// eta by its definition (Eq. 5): the sum of the squared areas of the faces, by the volume.
inline Quad plain_eta(const QuadTet& p) {
  Quad area2 = 0;
  for (int f = 0; f < 4; ++f) {
    const auto v = [&](int k) { return p[static_cast<std::size_t>(face_vertex(f, k))]; };
    const QuadVec n = cross(v(1) - v(0), v(2) - v(0));
    area2 += dot(n, n) / 4;
  }
  return area2 / plain_volume(p);
}

}  // namespace tetune::test
