// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>

#include "backend/macros.hpp"

/// Teams: threads that evaluate one item of a kernel together. All of them call the kernel with the same item, and make
/// the same calls of the team's functions; their common memory is a Kernel::Shared. A team has
///   kSize, rank()          the number of its threads, and which of them this is
///   any(condition)         whether the condition holds for one of them
///   rank_among(condition)  the rank of this thread among those for which the condition holds, and their number
///   merge(value)           the values of all of them merged by merge(), whose result must not depend on the order
///   broadcast(value, r)    the value of thread r
///   sync()                 stores to shared memory before are visible to all of them afterwards
/// The team of the CPU is a single thread; that of a GPU is a warp, or a part of one (backend/cuda.cuh).
namespace tetune::backend {

/// The rank of a thread among those of its team for which a condition holds.
struct Placement {
  int before;  ///< the number of those of lower rank
  int count;   ///< the number of all
};

struct SingleThread {
  static constexpr int kSize = 1;
  TETUNE_HD static constexpr int rank() { return 0; }
  TETUNE_HD static constexpr bool any(bool condition) { return condition; }
  TETUNE_HD static constexpr Placement rank_among(bool condition) { return {0, condition ? 1 : 0}; }
  template <class T>
  TETUNE_HD static constexpr T merge(const T& value) {
    return value;
  }
  template <class T>
  TETUNE_HD static constexpr T broadcast(const T& value, int) {
    return value;
  }
  TETUNE_HD static constexpr void sync() {}
};

/// A single thread that evaluates independent terms in packs of doubles, as those of the CPU.
template <class Pack>
struct PackThread : SingleThread {};

namespace team_detail {

template <class Team>
struct TermsOf {
  using type = double;
};
template <class Pack>
struct TermsOf<PackThread<Pack>> {
  using type = Pack;
};

}  // namespace team_detail

/// The terms that each thread of a team evaluates at a time: a double, or a pack of them.
template <class Team>
using TermsOf = typename team_detail::TermsOf<Team>::type;

/// Reads a value that a thread of the team will write: one thread reads it for all.
template <class Team, class T>
TETUNE_HD T read_once(const Team& team, const T& from) {
  T value{};
  if (team.rank() == 0) value = from;
  return team.broadcast(value, 0);
}

namespace team_detail {

template <class Kernel>
struct Shared {
  using type = void;
};
template <class Kernel>
requires requires { typename Kernel::Shared; }
struct Shared<Kernel> {
  using type = typename Kernel::Shared;
};

}  // namespace team_detail

/// Kernel::Shared; void where items are evaluated by single threads.
template <class Kernel>
using SharedOf = typename team_detail::Shared<Kernel>::type;
/// A kernel whose items teams evaluate: it has operator()(team, shared, i), beside operator()(i) for single threads.
template <class Kernel>
concept TeamKernel = !std::is_void_v<SharedOf<Kernel>>;
/// Kernel::kTeamSize, a power of two: the threads of its teams on a GPU; those of a warp where it has none.
template <class Kernel>
inline constexpr int kTeamSizeOf = 32;
template <class Kernel>
requires requires { Kernel::kTeamSize; }
inline constexpr int kTeamSizeOf<Kernel> = Kernel::kTeamSize;
/// Kernel::kScalesToWarp: whether teams of any size up to that of a warp may evaluate the items, to the same bits. On
/// a GPU a warp evaluates each item where there are few.
template <class Kernel>
inline constexpr bool kScalesToWarp = false;
template <TeamKernel Kernel>
requires requires { Kernel::kScalesToWarp; }
inline constexpr bool kScalesToWarp<Kernel> = Kernel::kScalesToWarp;

/// The largest of several values.
struct Max {
  double value;
  TETUNE_HD void merge(const Max& other) { value = other.value > value ? other.value : value; }
};
/// The largest of several values with its index, the lowest of equals.
struct IndexedMax {
  double value;
  int index;
  /// Requires increasing indices.
  TETUNE_HD void add(double other, int at) {
    if (other > value) *this = {other, at};
  }
  TETUNE_HD void merge(const IndexedMax& other) {
    if (other.value > value || (other.value == value && other.index < index)) *this = other;
  }
};

}  // namespace tetune::backend
