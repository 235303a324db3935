// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <type_traits>

#include "backend/buffer.hpp"
#include "backend/span.hpp"
#include "backend/team.hpp"

/// Results of loops: kernels that store the results of another one, and that load them to be merged.
namespace tetune::backend {

template <class R, class Kernel>
struct StoreResult {
  static constexpr Size kGrain = Kernel::kGrain;
  using Shared = SharedOf<Kernel>;
  static constexpr int kTeamSize = kTeamSizeOf<Kernel>;
  static constexpr bool kScalesToWarp = backend::kScalesToWarp<Kernel>;
  Kernel kernel;
  Span<R> results;
  TETUNE_HD void operator()(Size i) const { results[i] = kernel(i); }
  template <class Team, class Memory>
  TETUNE_HD void operator()(const Team& team, Memory& shared, Size i) const {
    const R result = kernel(team, shared, i);
    if (team.rank() == 0) results[i] = result;
  }
};

/// The result of reduce_async() of a backend that runs kernels at once.
template <class R>
struct Available {
  R value{};
  R get() const { return value; }
};

template <class R>
struct LoadResult {
  Span<const R> results;
  TETUNE_HD R operator()(Size i) const { return results[i]; }
};

/// The result of compact_and_sum().
template <class T>
struct CountAndSum {
  std::uint32_t count = 0;
  T sum{};
  TETUNE_HD friend CountAndSum operator+(const CountAndSum& x, const CountAndSum& y) {
    return {x.count + y.count, x.sum + y.sum};
  }
};

/// One step of a kernel of several.
template <class Kernel>
struct Step {
  Kernel kernel;
  Size step;
  TETUNE_INLINE void prefetch(Size i, Size end) const {
    if constexpr (requires { kernel.prefetch(i, end); }) kernel.prefetch(i, end);
  }
  TETUNE_HD void operator()(Size i) const { kernel(step, i); }
};
template <class Backend, class F>
void for_each_step(const Backend& backend, Size steps, Size n, const F& f) {
  for (Size step = 0; step < steps; ++step) backend.for_each(n, Step<F>{f, step});
}

/// Evaluates a kernel for listed items.
template <class T, class Kernel>
struct EvaluateListed {
  Kernel kernel;
  Span<const Index32> items;
  Span<T> results;
  TETUNE_HD void operator()(Size i) const { results[i] = kernel(items[i]); }
};
/// Calls a kernel for listed items, with their rank and the sum of the values before.
template <class T, class Kernel>
struct PlaceListed {
  static constexpr Size kGrain = Kernel::kGrain;
  Kernel kernel;
  Span<const Index32> items;
  Span<const T> before;
  TETUNE_HD void operator()(Size rank) const { kernel(items[rank], rank, before[rank]); }
};

template <class Backend, class F, class G, class P>
auto compact_and_sum(const Backend& backend, Size n, const F& keep, const G& evaluate, const P& place) {
  using T = std::invoke_result_t<const G&, Size>;
  Buffer<Index32, Backend> kept(backend, n);
  kept.resize(backend, backend.compact(n, keep, kept.span()));
  Buffer<T, Backend> sums(backend, kept.size());
  backend.for_each(kept.size(), EvaluateListed<T, G>{evaluate, kept.span(), sums.span()});
  const T total = backend.exclusive_scan(Span<const T>(sums.span()), sums.span());
  backend.for_each(kept.size(), PlaceListed<T, P>{place, kept.span(), sums.span()});
  return CountAndSum<T>{std::uint32_t(kept.size()), total};
}

}  // namespace tetune::backend
