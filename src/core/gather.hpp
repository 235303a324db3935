// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/types.hpp"
#include "par/pack.hpp"
#include "par/span.hpp"

/// Packs of doubles: what is the same of each lane. A pack may be one double.
namespace tetune {

template <class Pack>
inline constexpr int kLanesOf = sizeof(Pack) / sizeof(double);

template <class Pack>
TETUNE_HD TETUNE_INLINE double lane(const Pack& pack, int l) {
  if constexpr (requires { pack[0]; }) {
    return pack[l];
  } else {
    return pack;
  }
}

/// A point for each lane: they come in whole and are transposed.
template <class Pack>
TETUNE_HD TETUNE_INLINE Vec3T<Pack> gather(par::Span<const Point> points, const Index (&ids)[kLanesOf<Pack>]) {
  if constexpr (kLanesOf<Pack> == 1) {
    return vec(points[ids[0]]);
  } else {
    typedef double Row __attribute__((vector_size(sizeof(Point)), may_alias));
    static_assert(sizeof(Pack) == sizeof(Row));
    Pack r[4];
    for (int l = 0; l < 4; ++l) r[l] = *reinterpret_cast<const Row*>(&points[ids[l]]);
    const Pack xy01 = __builtin_shufflevector(r[0], r[1], 0, 4, 1, 5);
    const Pack xy23 = __builtin_shufflevector(r[2], r[3], 0, 4, 1, 5);
    const Pack z01 = __builtin_shufflevector(r[0], r[1], 2, 6, 2, 6);
    const Pack z23 = __builtin_shufflevector(r[2], r[3], 2, 6, 2, 6);
    return {__builtin_shufflevector(xy01, xy23, 0, 1, 4, 5), __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7),
            __builtin_shufflevector(z01, z23, 0, 1, 4, 5)};
  }
}

}  // namespace tetune
