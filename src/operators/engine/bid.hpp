// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

#include "backend/atomic.hpp"
#include "mesh/work_mesh.hpp"

/// Bids for tetrahedra: each candidate bids on all tetrahedra of its cavity, and each tetrahedron keeps the highest
/// bid. Candidates that hold all of theirs are an independent set by local maxima (Luby, "A simple parallel algorithm
/// for the maximal independent set problem", 1986; Ströter et al. 2022, Alg. 5, lines 21 to 33).
namespace tetune {

/// In place of the highest bid on a tetrahedron: its cavity is selected, and the tetrahedron is about to be replaced.
inline constexpr std::uint64_t kReplaced = ~std::uint64_t{0};

/// Orders candidates by gain, then by id: the lower id wins. The gain is rounded to single precision, so that gains
/// that differ by round-off alone count as equal. No bid is 0.
TETUNE_HD inline std::uint64_t make_bid(double gain, std::uint32_t id) {
  const auto rounded = static_cast<float>(gain);
  std::uint32_t bits = 0;
  static_assert(sizeof bits == sizeof rounded);
  std::memcpy(&bits, &rounded, sizeof bits);
  return (std::uint64_t{bits} << 32) | ~id;
}

/// Bids on all tetrahedra of a cavity.
template <class Cavity>
TETUNE_HD void place_bid(const Cavity& cavity, std::uint64_t bid, Span<std::uint64_t> tet2bid) {
  for (int k = 0; k < cavity.old_count(); ++k) backend::atomic_max(tet2bid[cavity.tets[k]], bid);
}
/// Whether a bid is the highest on all tetrahedra of a cavity.
template <class Cavity>
TETUNE_HD bool holds_all(const Cavity& cavity, std::uint64_t bid, Span<const std::uint64_t> tet2bid) {
  for (int k = 0; k < cavity.old_count(); ++k) {
    if (tet2bid[cavity.tets[k]] != bid) return false;
  }
  return true;
}

}  // namespace tetune
