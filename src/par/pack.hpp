// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

#include "par/macros.hpp"

namespace tetune::par {

/// As many doubles as kernels take at a time: a vector register of the CPU; one on the GPU, which has its lanes
/// elsewhere.
#if defined(__CUDACC__)
using Pack = double;
using PackBits = std::uint64_t;
TETUNE_HD TETUNE_INLINE PackBits where(bool condition, PackBits bits) { return condition ? bits : 0; }
TETUNE_HD TETUNE_INLINE std::uint64_t merged(PackBits bits) { return bits; }
#else
typedef double Pack __attribute__((vector_size(4 * sizeof(double))));
/// A word beside each double of a pack.
typedef std::uint64_t PackBits __attribute__((vector_size(4 * sizeof(std::uint64_t))));
/// The words beside which a comparison holds; 0 elsewhere.
TETUNE_INLINE PackBits where(const decltype(Pack{} < Pack{}) & condition, const PackBits& bits) {
  return reinterpret_cast<const PackBits&>(condition) & bits;
}
TETUNE_INLINE std::uint64_t merged(const PackBits& bits) { return (bits[0] | bits[1]) | (bits[2] | bits[3]); }

/// The first three of the four doubles at each place: a pack of the first ones, of the second ones, of the third ones.
/// They come in whole and are transposed.
TETUNE_INLINE void load_columns(const double* const (&row)[4], Pack (&column)[3]) {
  typedef double Row __attribute__((vector_size(4 * sizeof(double)), may_alias));
  Pack r[4];
  for (int l = 0; l < 4; ++l) r[l] = *reinterpret_cast<const Row*>(row[l]);
  const Pack xy01 = __builtin_shufflevector(r[0], r[1], 0, 4, 1, 5);
  const Pack xy23 = __builtin_shufflevector(r[2], r[3], 0, 4, 1, 5);
  const Pack z01 = __builtin_shufflevector(r[0], r[1], 2, 6, 2, 6);
  const Pack z23 = __builtin_shufflevector(r[2], r[3], 2, 6, 2, 6);
  column[0] = __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5);
  column[1] = __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7);
  column[2] = __builtin_shufflevector(z01, z23, 0, 1, 4, 5);
}
#endif
TETUNE_HD TETUNE_INLINE void load_columns(const double* const (&row)[1], double (&column)[3]) {
  for (int k = 0; k < 3; ++k) column[k] = row[0][k];
}

template <class T>
TETUNE_HD TETUNE_INLINE T load(const void* from) {
  T pack;
  std::memcpy(&pack, from, sizeof(T));
  return pack;
}

}  // namespace tetune::par
