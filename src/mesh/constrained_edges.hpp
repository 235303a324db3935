// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "backend/buffer.hpp"
#include "backend/span.hpp"
#include "tetune/types.hpp"

namespace tetune {

/// The constrained edges inside regions as a sorted list of keys, and per vertex a flag whether one ends there.
struct ConstrainedEdges {
  Span<const std::uint64_t> keys;
  Span<const std::uint8_t> on_vertex;

  TETUNE_HD bool contains(Index a, Index b) const {
    if (keys.size() == 0 || on_vertex[a] == 0 || on_vertex[b] == 0) return false;
    return tetune::contains(keys, edge_key(a, b));
  }
  /// Whether a constrained edge ends at v.
  TETUNE_HD bool has_end(Index v) const { return keys.size() > 0 && on_vertex[v] != 0; }
  TETUNE_HD static std::uint64_t edge_key(Index a, Index b) {
    const Index low = a < b ? a : b;
    const Index high = a < b ? b : a;
    return (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint32_t>(high);
  }
};

/// A set of edges in a backend's memory: as pairs of work vertices, and as sorted keys for lookup.
template <class Backend>
struct EdgeSet {
  BufferOf<Backend, Index> ends;
  BufferOf<Backend, std::uint64_t> keys;
  BufferOf<Backend, std::uint8_t> on_vertex;

  EdgeSet(const Backend& backend, const std::vector<Index>& pairs, Size vertices) {
    std::vector<std::uint64_t> sorted;
    std::vector<std::uint8_t> flags(to_size_t(vertices), 0);
    for (auto v = pairs.begin(); v != pairs.end(); v += 2) {
      sorted.push_back(ConstrainedEdges::edge_key(v[0], v[1]));
      for (const Index end : {v[0], v[1]}) span_of(flags)[end] = 1;
    }
    std::sort(sorted.begin(), sorted.end());
    ends.upload(backend, pairs);
    keys.upload(backend, sorted);
    on_vertex.upload(backend, flags);
  }
  ConstrainedEdges view() const { return {keys.span(), on_vertex.span()}; }
};

}  // namespace tetune
