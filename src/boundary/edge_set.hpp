// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "mesh/constrained_edges.hpp"

namespace tetune {

/// A set of edges in a backend's memory: as pairs of work vertices, and as sorted keys for lookup.
template <class Backend>
struct EdgeSet {
  typename Backend::template Buffer<Index> ends;
  typename Backend::template Buffer<std::uint64_t> keys;
  typename Backend::template Buffer<std::uint8_t> on_vertex;

  EdgeSet(const Backend& backend, const std::vector<Index>& pairs, Size vertices) {
    std::vector<std::uint64_t> sorted;
    std::vector<std::uint8_t> flags(backend::to_size_t(vertices), 0);
    for (auto v = pairs.begin(); v != pairs.end(); v += 2) {
      sorted.push_back(ConstrainedEdges::edge_key(v[0], v[1]));
      for (const Index end : {v[0], v[1]}) backend::span_of(flags)[end] = 1;
    }
    std::sort(sorted.begin(), sorted.end());
    ends.upload(backend, pairs);
    keys.upload(backend, sorted);
    on_vertex.upload(backend, flags);
  }
  ConstrainedEdges view() const { return {keys.span(), on_vertex.span()}; }
};

}  // namespace tetune
