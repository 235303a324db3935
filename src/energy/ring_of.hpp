// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/pack.hpp"
#include "backend/team.hpp"
#include "energy/ring.hpp"
#if !defined(__CUDACC__)
#include "energy/simd_ring.hpp"
#endif

namespace tetune {

/// The ring that sweeps and cavities evaluate, chosen by the pack of the backend: SimdRing where a pack is a vector,
/// otherwise the ring of a team.
template <class Pack, class Team = backend::SingleThread>
struct RingOf;
template <class Team>
struct RingOf<double, Team> {
  using type = PlainRing<Team>;
};
#if !defined(__CUDACC__)
template <class Team>
struct RingOf<backend::Pack4, Team> {
  using type = SimdRing;
};
#endif

template <class Team>
using RingOfTeam = typename RingOf<backend::TermsOf<Team>, Team>::type;

}  // namespace tetune
