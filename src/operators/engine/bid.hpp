// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

#include "backend/atomic.hpp"
#include "math/mix_bits.hpp"
#include "mesh/constrained_edges.hpp"
#include "mesh/work_mesh.hpp"

/// Bids for tetrahedra: each candidate bids on all tetrahedra of its cavity, and each tetrahedron keeps the highest
/// bid. Candidates that hold all of theirs are an independent set by local maxima (Luby, "A simple parallel algorithm
/// for the maximal independent set problem", 1986; Ströter et al. 2022, Alg. 5, lines 21 to 33).
namespace tetune {

/// In place of the highest bid on a tetrahedron whose cavity is selected: which record replaces it. No bid has this
/// bit.
inline constexpr std::uint64_t kReplaced = std::uint64_t{1} << 63;
TETUNE_HD inline std::uint64_t replaced_by(Index record) { return kReplaced | std::uint64_t(record); }
TETUNE_HD inline bool is_replaced(std::uint64_t bid) { return (bid & kReplaced) != 0; }
/// Requires is_replaced().
TETUNE_HD inline Index replacing_record(std::uint64_t bid) { return Index(bid & ~kReplaced); }

/// Orders candidates by gain, then by id: the lower id wins. The gain is rounded to single precision, so that gains
/// that differ by round-off alone count as equal. Requires a positive gain; no bid is 0.
TETUNE_HD inline std::uint64_t make_bid(double gain, std::uint32_t id) {
  const auto rounded = static_cast<float>(gain);
  std::uint32_t bits = 0;
  static_assert(sizeof bits == sizeof rounded);
  std::memcpy(&bits, &rounded, sizeof bits);
  return (std::uint64_t{bits} << 32) | ~id;
}

/// The highest bid on each tetrahedron, and on each slot that stands for edges.
struct Bids {
  Span<std::uint64_t> tets, edges;
};

/// The slot of Bids::edges that stands for an edge: candidates that make this edge of the surface bid on it, so that at
/// most one of them is selected. It may stand for another edge as well: then one of both is left for another pass.
TETUNE_HD inline Index slot_of_edge(Index p, Index q, Size slots) {
  return Index(mix_bits(ConstrainedEdges::edge_key(p, q)) % std::uint64_t(slots));
}

/// The number of edges of the surface that a candidate makes.
template <class Cavity>
TETUNE_HD int edge_count(const Cavity& cavity) {
  if constexpr (requires { cavity.edge_count(); }) return cavity.edge_count();
  return 0;
}
/// Bids on all tetrahedra of a cavity, and on the edges that it makes.
template <class Cavity>
TETUNE_HD void place_bid(const Cavity& cavity, std::uint64_t bid, const Bids& bids) {
  const int tets = cavity.old_count();
  for (int k = 0; k < tets; ++k) backend::atomic_max(bids.tets[cavity.tets[k]], bid);
  for (int k = 0; k < edge_count(cavity); ++k) backend::atomic_max(bids.edges[cavity.tets[tets + k]], bid);
}
/// Whether a bid is the highest on all tetrahedra of a cavity and all edges that it makes. Other cavities may become
/// selected at the same time.
template <class Cavity>
TETUNE_HD bool holds_all(const Cavity& cavity, std::uint64_t bid, const Bids& bids) {
  const int tets = cavity.old_count();
  for (int k = 0; k < tets; ++k) {
    if (backend::load_shared(bids.tets[cavity.tets[k]]) != bid) return false;
  }
  for (int k = 0; k < edge_count(cavity); ++k) {
    if (bids.edges[cavity.tets[tets + k]] != bid) return false;
  }
  return true;
}

}  // namespace tetune
