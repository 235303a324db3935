// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "backend/atomic.hpp"
#include "backend/team.hpp"
#include "operators/engine/proposals.hpp"

/// How a team evaluates the candidates of several tetrahedra. Few candidates pass the tests, and one that does takes
/// far longer than the tests of all: with a thread per tetrahedron most of a warp would wait for a few threads. Here
/// all threads test candidates, those that pass are listed, and each thread evaluates a listed one. The result does not
/// depend on the order.
///
/// A generator whose proposals are evaluated in groups has, beside the members in proposals.hpp,
///   static constexpr Kinds kKinds = {n, m};   each tetrahedron has n candidates of one kind, m of another
///   static constexpr int kLists = ...;        candidates are listed apart whose evaluations take different paths
///   struct PerTet { ... };                    data common to all candidates of a tetrahedron
///   Index tet(Size proposal) const;
///   void start(Index t, PerTet&) const;
///   int test(Index t, int candidate, PerTet&) const;   the list of a candidate that passes; otherwise kFails
///   double evaluate(Index t, int candidate, PerTet&, Candidate&, Size& evaluated) const;   its gain; 0: none
///   void finish(Index t, const PerTet&) const;
/// Several threads call test() and evaluate() with the same PerTet at the same time; start() and finish() have it for
/// themselves. The id of a candidate is candidate_id(tet, candidate).
namespace tetune {

inline constexpr int kFails = -1;

/// The numbers of candidates of a tetrahedron.
struct Kinds {
  int first, second;
  TETUNE_HD constexpr int count() const { return first + second; }
};

/// The memory of a team.
template <class Generator>
struct GroupMemory {
  static constexpr int kMaxProposals = 64;
  /// A list is evaluated as soon as it has a candidate per thread, of which there are at most 32.
  static constexpr int kMaxListed = 2 * 32;
  Index tets[kMaxProposals];
  typename Generator::PerTet per_tet[kMaxProposals];
  std::uint64_t best_bid[kMaxProposals];
  std::uint16_t listed[Generator::kLists][kMaxListed];
};

template <class Generator, class Team>
class GroupEvaluation {
 public:
  using Candidate = typename Generator::Candidate;

  /// For proposals `first` to `first` + `count` - 1.
  TETUNE_HD GroupEvaluation(const Generator& generator, const Team& team, GroupMemory<Generator>& memory, Size first,
                            int count, const Proposals<Candidate>& proposals)
      : generator_(generator), team_(team), memory_(memory), first_(first), count_(count), proposals_(proposals) {}

  /// Returns the number of cavities that this thread evaluated.
  TETUNE_HD Size operator()() {
    for (int p = team_.rank(); p < count_; p += Team::kSize) start(p);
    team_.sync();
    const int candidates = kKinds.count() * count_;
    int listed[kLists] = {};
    for (int begin = 0; begin < candidates; begin += Team::kSize) {
      const int own = begin + team_.rank();
      const int list_of_own = own < candidates ? test(own) : kFails;
      for (int list = 0; list < kLists; ++list) listed[list] += append(list, listed[list], own, list_of_own == list);
      team_.sync();
      for (int list = 0; list < kLists; ++list) {
        if (listed[list] < Team::kSize) continue;
        listed[list] -= Team::kSize;
        evaluate(memory_.listed[list][listed[list] + team_.rank()]);
      }
    }
    for (int list = 0; list < kLists; ++list) {
      if (listed[list] > 0) evaluate(team_.rank() < listed[list] ? memory_.listed[list][team_.rank()] : kNone);
    }
    for (int p = team_.rank(); p < count_; p += Team::kSize) finish(p);
    return evaluated_;
  }

 private:
  static constexpr Kinds kKinds = Generator::kKinds;
  static constexpr int kLists = Generator::kLists;
  static constexpr int kNone = -1;
  static_assert(Generator::kParts == 1 && kKinds.first > 0 && kKinds.count() <= kCandidates);
  static_assert(2 * Team::kSize <= GroupMemory<Generator>::kMaxListed);

  /// Candidate `local` of a tetrahedron.
  struct CandidateRef {
    int proposal, local;
  };
  /// The candidates of the first kind of all proposals come first, so that threads that test together test one kind.
  TETUNE_HD CandidateRef ref_of(int candidate) const {
    const int second = candidate - kKinds.first * count_;
    if constexpr (kKinds.second > 0) {
      if (second >= 0) return {second / kKinds.second, kKinds.first + second % kKinds.second};
    }
    return {candidate / kKinds.first, candidate % kKinds.first};
  }

  TETUNE_HD void start(int p) {
    memory_.tets[p] = generator_.tet(first_ + p);
    memory_.best_bid[p] = 0;
    generator_.start(memory_.tets[p], memory_.per_tet[p]);
  }
  TETUNE_HD void finish(int p) const {
    generator_.finish(memory_.tets[p], memory_.per_tet[p]);
    proposals_.bids[proposals_.entry(first_ + p, 0)] = memory_.best_bid[p];
  }
  TETUNE_HD int test(int candidate) {
    const CandidateRef at = ref_of(candidate);
    return generator_.test(memory_.tets[at.proposal], at.local, memory_.per_tet[at.proposal]);
  }

  /// Appends the candidate of a thread to a list of `size` if `condition` holds; returns the number of those appended.
  TETUNE_HD int append(int list, int size, int candidate, bool condition) {
    const backend::Placement rank = team_.rank_among(condition);
    if (condition) memory_.listed[list][size + rank.before] = std::uint16_t(candidate);
    return rank.count;
  }

  /// Evaluates a candidate per thread. Of those of a proposal the best is stored, by the thread whose bid is the
  /// highest so far.
  TETUNE_HD void evaluate(int candidate) {
    Candidate c;
    CandidateRef at{};
    std::uint64_t bid = 0;
    if (candidate != kNone) {
      at = ref_of(candidate);
      const Index t = memory_.tets[at.proposal];
      const double gain = generator_.evaluate(t, at.local, memory_.per_tet[at.proposal], c, evaluated_);
      if (gain > 0) {
        bid = make_bid(gain, candidate_id(t, at.local));
        place_bid(c, bid, proposals_.highest);
        backend::atomic_max(memory_.best_bid[at.proposal], bid);
      }
    }
    team_.sync();
    if (bid != 0 && memory_.best_bid[at.proposal] == bid) {
      store(c, proposals_.candidates[proposals_.entry(first_ + at.proposal, 0)]);
    }
    team_.sync();
  }

  const Generator& generator_;
  const Team& team_;
  GroupMemory<Generator>& memory_;
  Size first_;
  int count_;
  const Proposals<Candidate>& proposals_;
  Size evaluated_ = 0;
};

}  // namespace tetune
