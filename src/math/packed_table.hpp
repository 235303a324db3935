// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "backend/macros.hpp"

namespace tetune {

/// A constant table of small numbers packed into one word, kBits bits per entry. Reading an entry is a shift and a mask
/// without a memory access, in host and device code alike. Declare it constexpr inside a function.
template <int kBits>
struct PackedTable {
  std::uint64_t bits = 0;

  template <std::size_t N>
  TETUNE_HD explicit constexpr PackedTable(const int (&entries)[N]) {
    static_assert(N * kBits <= 64);
    for (std::size_t i = 0; i < N; ++i) bits |= static_cast<std::uint64_t>(entries[i]) << kBits * i;
  }
  TETUNE_HD constexpr int operator[](int i) const { return static_cast<int>(bits >> kBits * i & ((1U << kBits) - 1)); }
};

}  // namespace tetune
