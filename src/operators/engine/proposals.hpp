// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "operators/engine/bid.hpp"
#include "operators/engine/candidate.hpp"

/// A generator is a kernel that evaluates one proposal, say the flips around one tetrahedron, and adds its candidates:
///   using Candidate = ...;               the type that it adds
///   static constexpr int kParts = 1;     cavities per proposal that are selected together or not at all
///   static constexpr Size kGrain = ...;  the number of proposals that is enough work for one thread
///   static constexpr Size kBatch = ...;  the number that takes a core about 0.1 s
///   Size operator()(Size i, const Proposals<Candidate>&) const;   returns the number of cavities evaluated
///   using Shared = ...;                  optional: a team evaluates a proposal (backend/team.hpp), by
///                                        operator()(team, shared, i, proposals)
///   void prefetch(Size i) const;         optional
///   static constexpr Kinds kKinds = ...; optional: on a device a team evaluates the candidates of several proposals
///                                        (group_evaluation.hpp)
///   Size edge_slots() const;             optional: the number of slots that stand for edges which candidates make
///   int choices;                         optional: proposal i is choice i % choices; threads of a device that run
///                                        together get proposals of one choice
/// All candidates bid; of each proposal the best one alone is stored: the tetrahedra of a proposal's candidates
/// overlap, so that no other can be selected.
namespace tetune {

/// Where a batch of proposals puts its candidates and bids.
template <Candidate C>
struct Proposals {
  Bids highest;
  Span<C> candidates;        ///< the best one of each proposal and part
  Span<std::uint64_t> bids;  ///< its bid; 0: none
  Size first = 0;            ///< the first proposal of the batch
  int parts = 1;

  TETUNE_HD Size entry(Size proposal, int part) const { return (proposal - first) * parts + part; }
  /// Adds a candidate of a positive gain. `id` breaks ties; it belongs to this proposal alone.
  TETUNE_HD void add(Size proposal, const C& candidate, double gain, std::uint32_t id, int part = 0) const {
    const std::uint64_t bid = make_bid(gain, id);
    place_bid(candidate, bid, highest);
    const Size i = entry(proposal, part);
    if (bid <= bids[i]) return;
    bids[i] = bid;
    store(candidate, candidates[i]);
  }
};

}  // namespace tetune
