// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "backend/team.hpp"
#include "operators/group_evaluation.hpp"
#include "operators/proposals.hpp"

/// The evaluation of a batch of proposals: by a thread or a team per proposal, or by a team for several.
namespace tetune {
namespace evaluate_proposals_detail {

template <class Generator>
struct Propose {
  static constexpr Size kGrain = Generator::kGrain;
  using Shared = backend::SharedOf<Generator>;
  Generator generator;
  Proposals<typename Generator::Candidate> proposals;
  Size group;   ///< of proposals that are evaluated apart from each other; 1: in order
  Size groups;  ///< of the batch

  TETUNE_INLINE void prefetch(Size i, Size) const {
    if constexpr (requires { generator.prefetch(i); }) generator.prefetch(proposals.first + i);
  }
  TETUNE_HD backend::Sum<Size> operator()(Size i) const {
    const Size proposal = begin(i, true);
    return {generator(proposal, proposals)};
  }
  template <class Team, class Memory>
  TETUNE_HD backend::Sum<Size> operator()(const Team& team, Memory& shared, Size i) const {
    const Size proposal = begin(i, team.rank() == 0);
    return {generator(team, shared, proposal, proposals)};
  }

 private:
  /// The proposal of item i, without candidates yet.
  TETUNE_HD Size begin(Size i, bool clears) const {
    const Size proposal = proposals.first + (group == 1 ? i : i % groups * group + i / groups);
    for (int part = 0; clears && part < Generator::kParts; ++part) proposals.bids[proposals.entry(proposal, part)] = 0;
    return proposal;
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
  TETUNE_HD backend::Sum<Size> operator()(Size i) const {
    Shared memory;
    return (*this)(backend::SingleThread(), memory, i);
  }
  template <class Team>
  TETUNE_HD backend::Sum<Size> operator()(const Team& team, Shared& memory, Size i) const {
    const Size begin = i * each;
    const int size = to_index(count - begin < each ? count - begin : each);
    GroupEvaluation<Generator, Team> evaluation(generator, team, memory, proposals.first + begin, size, proposals);
    return team.merge(backend::Sum<Size>{evaluation()});
  }
};

/// Few proposals occupy a device only if its teams get few each.
template <class Generator>
Size proposals_per_team(Size count) {
  constexpr Size kTeams = 2048;
  constexpr Size kMin = 3;
  return std::clamp<Size>((count + kTeams - 1) / kTeams, kMin, GroupMemory<Generator>::kMaxProposals);
}

}  // namespace evaluate_proposals_detail

/// The length of the groups of proposals that are evaluated apart from each other.
template <class Backend, class Generator>
Size group_size(const Generator& generator) {
  if constexpr (Backend::kIsAsynchronous && requires { generator.group(); }) {
    return generator.group();
  } else {
    return 1;
  }
}

/// Evaluates `count` proposals, whole groups of `group`. Returns the pending number of cavities evaluated.
template <class Backend, class Generator>
auto evaluate_proposals(const Backend& backend, const Generator& generator,
                        const Proposals<typename Generator::Candidate>& proposals, Size count, Size group) {
  using namespace evaluate_proposals_detail;
  using Evaluated = backend::Sum<Size>;
  if constexpr (Backend::kIsAsynchronous && EvaluatesInGroups<Generator>) {
    const ProposeInGroups<Generator> kernel{generator, proposals, count, proposals_per_team<Generator>(count)};
    return backend.template reduce_async<Evaluated>(kernel.teams(), kernel);
  } else {
    return backend.template reduce_async<Evaluated>(count,
                                                    Propose<Generator>{generator, proposals, group, count / group});
  }
}

}  // namespace tetune
