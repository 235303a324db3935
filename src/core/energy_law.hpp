// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/types.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// Above any energy.
inline constexpr double kNever = 1e300;

template <class T>
TETUNE_HD TETUNE_INLINE T square_root(const T& x) {
  if constexpr (requires { x[0]; }) {
    T root;
    for (std::size_t l = 0; l < sizeof(T) / sizeof(x[0]); ++l) root[l] = std::sqrt(x[l]);
    return root;
  } else {
    return std::sqrt(x);
  }
}

/// An energy of one tetrahedron as c q^(gu / 2) w^gv of q = 4 * sum of squared areas and w = 6 * volume, and its
/// derivatives: with u = grad q / (2 q), v = grad w / w and Q = Hess q / 2,
///   grad E = E (gu u + gv v),   Hess E = E (gu Q / q + uu u u^T + uv (u v^T + v u^T) + vv v v^T).
/// All are convex where w > 0 (docs/method.md).
struct EnergyLaw {
  bool shape;
  int squarings;  ///< of the shape energy
  double factor;
  double gu, gv, uu, uv, vv;
  /// Of volumes while a mesh is untangled, relative to the cube of the local length: see SoftRing.
  double softness = 0;

  /// E / c. Written so that nothing overflows that is of the size of a mesh's own lengths.
  template <class T>
  TETUNE_HD TETUNE_INLINE T term(const T& q, const T& inverse_w) const {
    const T harmonic = q * inverse_w;
    return shape ? power(shape_term(q, inverse_w)) : harmonic;
  }
  /// The same, and q^(3/2) / w^2.
  template <class T>
  TETUNE_HD TETUNE_INLINE T term(const T& q, const T& inverse_w, T& shape_only) const {
    shape_only = shape_term(q, inverse_w);
    return shape ? power(shape_only) : q * inverse_w;
  }

  template <class T>
  TETUNE_HD TETUNE_INLINE static T shape_term(const T& q, const T& inverse_w) {
    return (q * inverse_w) * (square_root(q) * inverse_w);
  }

 private:
  template <class T>
  TETUNE_HD TETUNE_INLINE T power(T e) const {
    for (int i = 0; i < squarings; ++i) e = e * e;
    return e;
  }
};

/// eta = 1.5 q / w: the paper's (Eq. 5).
inline constexpr EnergyLaw kHarmonicLaw{false, 0, 1.5, 2, -1, 0, -2, 2};

/// Makes the shape energy of a regular tetrahedron 1: 1 / (6 sqrt(3)).
inline constexpr double kShapeFactor = 0.096225044864937627;

/// (eta / eta_r)^(3/2) = q^(3/2) / (6 sqrt(3) w^2), where eta_r is that of the regular tetrahedron of the same volume,
/// squared some times: 1 for a regular tetrahedron of any size. The higher the power, the more the worst count.
constexpr EnergyLaw shape_law(int squarings) {
  double factor = kShapeFactor;
  double power = 1;
  for (int i = 0; i < squarings; ++i) {
    factor *= factor;
    power *= 2;
  }
  const double a = 1.5 * power;
  const double b = 2 * power;
  return {true, squarings, factor, 2 * a, -b, 4 * a * a - 4 * a, -2 * a * b, b * b + b};
}
inline constexpr EnergyLaw kShapeLaw = shape_law(0);

inline EnergyLaw law_of(Energy energy) { return energy == Energy::shape ? kShapeLaw : kHarmonicLaw; }

}  // namespace tetune
