// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "par/macros.hpp"

namespace tetune::par {

/// As many doubles as kernels take at a time: a vector register of the CPU; one on the GPU, which has its lanes
/// elsewhere.
#if defined(__CUDACC__)
using Pack = double;
#else
typedef double Pack __attribute__((vector_size(4 * sizeof(double))));

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

}  // namespace tetune::par
