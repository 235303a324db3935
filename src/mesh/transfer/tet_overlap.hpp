// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "math/vec3.hpp"

namespace tetune {

using TetPoints = std::array<Vec3, 4>;

/// The intersection of two tetrahedra `a` and `b`.
struct TetOverlap {
  double part = 0;  ///< its volume divided by that of `a`
  /// Entry [i][j]: the integral of the barycentric coordinate i of `a` times the coordinate j of `b`, divided by the
  /// volume of `a`. Their sum is `part`.
  std::array<std::array<double, 4>, 4> moments{};
};

/// Six times the signed volume.
double six_volume(const TetPoints& x);
inline double volume(const TetPoints& x) { return std::fabs(six_volume(x)) / 6; }

/// A tetrahedron with the gradients of its barycentric coordinates 1 to 3, which are not finite where it is flat.
struct TetFrame {
  TetPoints points;
  std::array<Vec3, 3> gradient;
  double six;  ///< see six_volume()

  explicit TetFrame(const TetPoints& of);
};

/// Whether TetOverlap::moments are computed, or left 0.
enum class Moments : std::uint8_t { omitted, computed };

/// Intersects two tetrahedra of any orientation by clipping `a` by the planes of `b`. Intersections below 1e-14 of
/// either volume are rounding and count as empty.
TetOverlap overlap(const TetFrame& a, const TetFrame& b, Moments moments);

}  // namespace tetune
