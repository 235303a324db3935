// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/pack.hpp"
#include "backend/span.hpp"
#include "mesh/tet.hpp"

namespace tetune {

/// Loads one point per lane.
template <class Pack>
TETUNE_HD TETUNE_INLINE Vec3T<Pack> gather(Span<const Point> points, const Index (&ids)[kLanesOf<Pack>]) {
  static_assert(sizeof(Point) == 4 * sizeof(double));
  const double* row[kLanesOf<Pack>];
  for (int l = 0; l < kLanesOf<Pack>; ++l) row[l] = &points[ids[l]].x;
  Pack column[3];
  backend::load_columns(row, column);
  return {column[0], column[1], column[2]};
}

}  // namespace tetune
