// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/span.hpp"
#include "tetune/types.hpp"

namespace tetune {

using backend::Size;
using backend::Span;

/// The constrained edges inside regions as a sorted list of keys, and per vertex a flag whether one ends there.
struct ConstrainedEdges {
  Span<const std::uint64_t> keys;
  Span<const std::uint8_t> on_vertex;

  TETUNE_HD bool contains(Index a, Index b) const {
    if (keys.size() == 0 || on_vertex[a] == 0 || on_vertex[b] == 0) return false;
    const std::uint64_t key = edge_key(a, b);
    Size lo = 0;
    Size hi = keys.size();
    while (lo < hi) {
      const Size mid = (lo + hi) / 2;
      if (keys[mid] < key) {
        lo = mid + 1;
      } else {
        hi = mid;
      }
    }
    return lo < keys.size() && keys[lo] == key;
  }
  /// Whether a constrained edge ends at v.
  TETUNE_HD bool has_end(Index v) const { return keys.size() > 0 && on_vertex[v] != 0; }
  TETUNE_HD static std::uint64_t edge_key(Index a, Index b) {
    const Index low = a < b ? a : b;
    const Index high = a < b ? b : a;
    return (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint32_t>(high);
  }
};

}  // namespace tetune
