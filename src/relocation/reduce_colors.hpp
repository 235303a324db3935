// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "backend/atomic.hpp"
#include "backend/buffer.hpp"
#include "backend/concept.hpp"
#include "backend/results.hpp"
#include "backend/team.hpp"
#include "energy/ring.hpp"
#include "relocation/coloring.hpp"

namespace tetune {
namespace reduce_colors_detail {

/// A kernel that reads only the positions of the ring and data of its own vertex: a vertex may be evaluated as soon as
/// its neighbors of lower colors have been. It has `rings`, and may_move(v): where that is false, v stays as it is.
template <class Kernel>
concept UsesRingAlone = backend::TeamKernel<Kernel> && requires {
  requires Kernel::kUsesRingAlone;
};

/// Lists the vertices that may move.
template <class Kernel>
struct FindMoving {
  Kernel kernel;
  Span<const Index> vertices;
  Span<const std::uint8_t> color;
  Span<std::uint8_t> pending;  ///< kUncolored before
  TETUNE_HD bool operator()(Size i) const {
    const Index v = vertices[i];
    if (!kernel.may_move(v)) return false;
    pending[v] = color[v];
    return true;
  }
};

/// Evaluates a kernel for listed vertices, in the order of their colors: an item of for_each_in_order().
template <class R, class Kernel>
struct EvaluateInOrder {
  using Shared = typename Kernel::Shared;
  Kernel kernel;
  Span<const Index> listed;    ///< places in the kernel's vertices
  Span<std::uint8_t> pending;  ///< the color of each vertex that has yet to be evaluated, otherwise kUncolored
  Span<R> results;

  template <class Team>
  TETUNE_HD bool is_ready(const Team& team, Size i) const {
    const RingsView& rings = kernel.rings;
    const Index v = kernel.vertices[listed[i]];
    const std::uint8_t color = backend::load_shared(pending[v]);
    for (Size f = rings.offsets[v] + team.rank(); f < rings.offsets[v + 1]; f += Team::kSize) {
      for (const Index other : rings.faces[f].v) {
        if (backend::load_shared(pending[other]) < color) return false;
      }
    }
    return true;
  }
  template <class Team>
  TETUNE_HD void operator()(const Team& team, Shared& shared, Size i) const {
    const R result = kernel(team, shared, listed[i]);
    if (team.rank() == 0) results[i] = result;
  }
  TETUNE_HD void finish(Size i) const {
    backend::store_shared(pending[kernel.vertices[listed[i]]], coloring_detail::kUncolored);
  }
};

/// Evaluates the kernel in one launch: one per color would take as long as the slowest vertex of each color. Waits for
/// the number of vertices that may move.
template <class R, class Backend, UsesRingAlone Kernel>
ResultOf<Backend, R> reduce_in_order(const Backend& backend, const Coloring<Backend>& coloring, Kernel kernel) {
  if (backend.stop_requested()) return {};
  kernel.vertices = coloring.vertices.span();
  const Size n = kernel.vertices.size();
  BufferOf<Backend, std::uint8_t> pending(backend, coloring.color.size());
  backend.fill(pending.span(), coloring_detail::kUncolored);
  BufferOf<Backend, Index> listed(backend, n);
  const FindMoving<Kernel> find{kernel, kernel.vertices, coloring.color.span(), pending.span()};
  listed.resize(backend, backend.compact(n, find, listed.span()));
  BufferOf<Backend, R> results(backend, listed.size());
  backend.for_each_in_order(listed.size(),
                            EvaluateInOrder<R, Kernel>{kernel, listed.span(), pending.span(), results.span()});
  return backend.template reduce_async<R>(results.size(), backend::LoadResult<R>{results});
}

}  // namespace reduce_colors_detail

/// Merges the results of a kernel for all colored vertices, one color after the other; `kernel.vertices` receives the
/// vertices. Ends between two colors, or before the first, when a stop is requested. Returns the pending result: see
/// reduce_async().
template <class R, class Backend, class Kernel>
ResultOf<Backend, R> reduce_colors(const Backend& backend, const Coloring<Backend>& coloring, Kernel kernel) {
  using namespace reduce_colors_detail;
  if constexpr (backend::RunsInOrder<Backend> && UsesRingAlone<Kernel>) {
    return reduce_in_order<R>(backend, coloring, kernel);
  } else if constexpr (Backend::kIsAsynchronous) {
    // The results are stored, as the host would otherwise wait for each color.
    BufferOf<Backend, R> results(backend, coloring.vertices.size());
    Size done = 0;
    for (int c = 0; c < coloring.colors() && !backend.stop_requested(); ++c) {
      kernel.vertices = coloring.vertices_of(c);
      const Size count = kernel.vertices.size();
      backend.for_each(count, backend::StoreResult<R, Kernel>{kernel, {results.span().data() + done, count}});
      done += count;
    }
    return backend.template reduce_async<R>(done, backend::LoadResult<R>{results});
  } else {
    R total{};
    for (int c = 0; c < coloring.colors() && !backend.stop_requested(); ++c) {
      kernel.vertices = coloring.vertices_of(c);
      total.merge(backend.template reduce<R>(kernel.vertices.size(), kernel));
    }
    return {total};
  }
}

}  // namespace tetune
