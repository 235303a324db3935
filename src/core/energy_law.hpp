// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/types.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

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
/// Both are convex where w > 0 (docs/method.md).
struct EnergyLaw {
  bool shape;
  double factor;
  double gu, gv, uu, uv, vv;

  /// E / c. Written so that nothing overflows that is of the size of a mesh's own lengths.
  template <class T>
  TETUNE_HD TETUNE_INLINE T term(const T& q, const T& inverse_w) const {
    const T harmonic = q * inverse_w;
    return shape ? harmonic * (square_root(q) * inverse_w) : harmonic;
  }
};

/// eta = 1.5 q / w: the paper's (Eq. 5).
inline constexpr EnergyLaw kHarmonicLaw{false, 1.5, 2, -1, 0, -2, 2};
/// (eta / eta_r)^(3/2) = q^(3/2) / (6 sqrt(3) w^2), where eta_r is that of the regular tetrahedron of the same volume:
/// 1 for a regular tetrahedron of any size.
inline constexpr EnergyLaw kShapeLaw{true, 0.096225044864937627, 3, -2, 3, -6, 6};

TETUNE_HD inline EnergyLaw law_of(Energy energy) { return energy == Energy::shape ? kShapeLaw : kHarmonicLaw; }

}  // namespace tetune
