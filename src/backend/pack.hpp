// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

#include "backend/macros.hpp"

/// Packs: the doubles that a kernel processes at a time. The pack of a backend is `Backend::Pack`: Pack4 on the CPU,
/// one double on a GPU, which vectorizes over threads. Kernels that use packs are templates over Pack.
namespace tetune::backend {

/// The integer type with one 64-bit word per double of a pack.
template <class Pack>
struct PackBitsOf;
template <>
struct PackBitsOf<double> {
  using type = std::uint64_t;
};
template <class Pack>
using BitsOf = typename PackBitsOf<Pack>::type;

/// `bits` where the condition holds, 0 elsewhere.
TETUNE_HD TETUNE_INLINE std::uint64_t where(bool condition, std::uint64_t bits) { return condition ? bits : 0; }
/// The bitwise or of all words.
TETUNE_HD TETUNE_INLINE std::uint64_t merged(std::uint64_t bits) { return bits; }
/// Whether the condition holds in any lane.
TETUNE_HD TETUNE_INLINE bool any(bool condition) { return condition; }

/// Loads the first three components of the point of each lane: one pack per component.
TETUNE_HD TETUNE_INLINE void load_columns(const double* const (&row)[1], double (&column)[3]) {
  for (int k = 0; k < 3; ++k) column[k] = row[0][k];
}

#if !defined(__CUDACC__)
/// Four doubles in one vector register.
typedef double Pack4 __attribute__((vector_size(4 * sizeof(double))));
typedef std::uint64_t Bits4 __attribute__((vector_size(4 * sizeof(std::uint64_t))));
template <>
struct PackBitsOf<Pack4> {
  using type = Bits4;
};

TETUNE_INLINE Bits4 where(const decltype(Pack4{} < Pack4{}) & condition, const Bits4& bits) {
  return reinterpret_cast<const Bits4&>(condition) & bits;
}
TETUNE_INLINE std::uint64_t merged(const Bits4& bits) { return (bits[0] | bits[1]) | (bits[2] | bits[3]); }
TETUNE_INLINE bool any(const decltype(Pack4{} < Pack4{}) & condition) {
  return merged(reinterpret_cast<const Bits4&>(condition)) != 0;
}

/// Each point is loaded whole, as four doubles; the four vectors are then transposed.
TETUNE_INLINE void load_columns(const double* const (&row)[4], Pack4 (&column)[3]) {
  typedef double Row __attribute__((vector_size(4 * sizeof(double)), may_alias));
  Pack4 r[4];
  for (int l = 0; l < 4; ++l) r[l] = *reinterpret_cast<const Row*>(row[l]);
  const Pack4 xy01 = __builtin_shufflevector(r[0], r[1], 0, 4, 1, 5);
  const Pack4 xy23 = __builtin_shufflevector(r[2], r[3], 0, 4, 1, 5);
  const Pack4 z01 = __builtin_shufflevector(r[0], r[1], 2, 6, 2, 6);
  const Pack4 z23 = __builtin_shufflevector(r[2], r[3], 2, 6, 2, 6);
  column[0] = __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5);
  column[1] = __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7);
  column[2] = __builtin_shufflevector(z01, z23, 0, 1, 4, 5);
}
#endif

/// Loads a pack of consecutive words. Requires the alignment of a word and no more.
template <class T>
TETUNE_HD TETUNE_INLINE T load(const void* from) {
  T pack;
  std::memcpy(&pack, from, sizeof(T));
  return pack;
}
/// A pack of one word: nvcc does not know its alignment in a copy of bytes, and would load it byte by byte.
template <>
TETUNE_HD TETUNE_INLINE double load<double>(const void* from) {
  return *static_cast<const double*>(from);
}
template <>
TETUNE_HD TETUNE_INLINE std::uint64_t load<std::uint64_t>(const void* from) {
  return *static_cast<const std::uint64_t*>(from);
}

}  // namespace tetune::backend

/// Access to the lanes of a pack. A pack may be a single double.
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

}  // namespace tetune
