// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "par/beside_host.hpp"
#include "relocate/coloring.hpp"

namespace tetune {
namespace reduce_colors_detail {

template <class R, class Kernel>
struct Keep {
  Kernel kernel;
  Span<R> results;
  TETUNE_HD void operator()(Size i) const { results[i] = kernel(i); }
};
template <class R>
struct Kept {
  Span<const R> results;
  TETUNE_HD R operator()(Size i) const { return results[i]; }
};

}  // namespace reduce_colors_detail

/// Merges what a kernel returns for the vertices of one colour after the other: `kernel_of(vertices)` makes that of a
/// colour. Ends between two colours when a stop is requested.
template <class R, class Backend, class KernelOf>
R reduce_colors(const Backend& par, const Coloring<Backend>& coloring, const KernelOf& kernel_of) {
  using namespace reduce_colors_detail;
  using Kernel = decltype(kernel_of(Span<const Index>()));
  R total{};
  typename Backend::template Buffer<R> results;  // where the host would have to wait for each colour
  if constexpr (par::kBesideHost<Backend>) results.resize(coloring.vertices.size());
  Size done = 0;
  for (int c = 0; c < coloring.colors() && !par.stop_requested(); ++c) {
    const Size count = coloring.first[static_cast<std::size_t>(c) + 1] - done;
    const Kernel kernel = kernel_of({coloring.vertices.span().data() + done, count});
    if constexpr (par::kBesideHost<Backend>) {
      par.for_each(count, Keep<R, Kernel>{kernel, {results.span().data() + done, count}});
    } else {
      total.merge(par.template reduce<R>(count, kernel));
    }
    done += count;
  }
  if constexpr (par::kBesideHost<Backend>) total = par.template reduce<R>(done, Kept<R>{results.span()});
  return total;
}

}  // namespace tetune
