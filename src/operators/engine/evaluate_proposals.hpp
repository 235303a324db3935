// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "backend/team.hpp"
#include "operators/engine/group_evaluation.hpp"
#include "operators/engine/proposals.hpp"

/// The evaluation of a batch of proposals: by a thread or a team per proposal, or by a team for several.
namespace tetune {
namespace evaluate_proposals_detail {

template <class Generator>
struct Propose {
  static constexpr Size kGrain = Generator::kGrain;
  using Shared = backend::SharedOf<Generator>;
  Generator generator;
  Proposals<typename Generator::Candidate> proposals;
  Size choices;     ///< the proposals of each choice are evaluated side by side
  Size per_choice;  ///< their number in the batch

  TETUNE_INLINE void prefetch(Size i, Size) const {
    if constexpr (requires { generator.prefetch(i); }) generator.prefetch(proposals.first + i);
  }
  TETUNE_HD Sum<Size> operator()(Size i) const {
    const Size proposal = proposal_of(i);
    clear_bids(proposal);
    return {generator(proposal, proposals)};
  }
  template <class Team, class Memory>
  TETUNE_HD Sum<Size> operator()(const Team& team, Memory& shared, Size i) const {
    const Size proposal = proposal_of(i);
    if (team.rank() == 0) clear_bids(proposal);
    return {generator(team, shared, proposal, proposals)};
  }

 private:
  TETUNE_HD Size proposal_of(Size i) const {
    return proposals.first + (choices == 1 ? i : i % per_choice * choices + i / per_choice);
  }
  TETUNE_HD void clear_bids(Size proposal) const {
    for (int part = 0; part < Generator::kParts; ++part) proposals.bids[proposals.entry(proposal, part)] = 0;
  }
};

template <class Generator>
concept EvaluatesInGroups = requires {
  Generator::kKinds;
};

/// Proposals of which a team evaluates several.
template <EvaluatesInGroups Generator>
struct ProposeInGroups {
  static constexpr Size kGrain = 1;
  using Shared = GroupMemory<Generator>;
  Generator generator;
  Proposals<typename Generator::Candidate> proposals;
  Size count;  ///< of the batch
  Size each;   ///< proposals per team

  Size teams() const { return (count + each - 1) / each; }
  TETUNE_HD Sum<Size> operator()(Size i) const {
    Shared memory;
    return (*this)(backend::SingleThread(), memory, i);
  }
  template <class Team>
  TETUNE_HD Sum<Size> operator()(const Team& team, Shared& memory, Size i) const {
    const Size begin = i * each;
    const int size = to_index(count - begin < each ? count - begin : each);
    GroupEvaluation<Generator, Team> evaluation(generator, team, memory, proposals.first + begin, size, proposals);
    return team.merge(Sum<Size>{evaluation()});
  }
};

/// Proposals per team: few where there are few proposals, so that all of the device has work.
template <class Generator>
Size proposals_per_team(Size count) {
  constexpr Size kTeams = 2048;
  constexpr Size kMin = 3;
  return std::clamp<Size>((count + kTeams - 1) / kTeams, kMin, GroupMemory<Generator>::kMaxProposals);
}

}  // namespace evaluate_proposals_detail

/// The number of choices whose proposals are evaluated apart from each other.
template <class Backend, class Generator>
Size choices_apart(const Generator& generator) {
  if constexpr (Backend::kIsAsynchronous && requires { generator.choices; }) {
    return generator.choices;
  } else {
    return 1;
  }
}

/// Evaluates `count` proposals, a multiple of `choices`. Returns the pending number of cavities evaluated.
template <class Backend, class Generator>
auto evaluate_proposals(const Backend& backend, const Generator& generator,
                        const Proposals<typename Generator::Candidate>& proposals, Size count, Size choices) {
  using namespace evaluate_proposals_detail;
  using Evaluated = Sum<Size>;
  if constexpr (Backend::kIsAsynchronous && EvaluatesInGroups<Generator>) {
    const ProposeInGroups<Generator> kernel{generator, proposals, count, proposals_per_team<Generator>(count)};
    return backend.template reduce_async<Evaluated>(kernel.teams(), kernel);
  } else {
    return backend.template reduce_async<Evaluated>(count,
                                                    Propose<Generator>{generator, proposals, choices, count / choices});
  }
}

}  // namespace tetune
