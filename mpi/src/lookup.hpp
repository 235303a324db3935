// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "ids.hpp"

namespace tetune::mpi {

/// A hash table of listed triangles or edges by their vertices.
template <std::size_t N>
class Lookup {
 public:
  Lookup(const std::vector<std::array<Index, N>>& list, Marks& listed)
      : keys_(list), next_(list.size(), -1), first_(std::bit_ceil(2 * list.size() + 2), -1) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      for (const Index v : list[i]) item(listed, v) = 1;
      std::sort(keys_[i].begin(), keys_[i].end());
      Index& first = first_[bucket(keys_[i])];
      next_[i] = first;
      first = to_index(i);
    }
  }
  /// Calls found(i) for each entry with these vertices, which are in increasing order.
  template <class F>
  void find(const std::array<Index, N>& key, F found) const {
    for (Index i = first_[bucket(key)]; i >= 0; i = item(next_, i)) {
      if (item(keys_, i) == key) found(i);
    }
  }

 private:
  std::size_t bucket(const std::array<Index, N>& key) const {
    std::uint64_t hash = 0;
    for (const Index v : key) hash = (hash ^ std::uint64_t(v)) * 0x9E3779B97F4A7C15U;
    return hash >> 20U & (first_.size() - 1);
  }
  std::vector<std::array<Index, N>> keys_;
  std::vector<Index> next_, first_;
};

/// Calls found(i, t) for each listed triangle or edge i that tetrahedron t has. `vertices`: the number of vertices.
template <std::size_t N, class F>
void find_in(const std::vector<std::array<Index, N>>& list, const std::vector<std::array<Index, 4>>& tets,
             std::size_t vertices, F found) {
  if (list.empty()) return;
  Marks listed(vertices, 0);
  const Lookup<N> lookup(list, listed);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    std::array<Index, 4> on{};
    std::size_t count = 0;
    for (const Index v : tets[t]) {
      if (item(listed, v) != 0) on[count++] = v;
    }
    if (count < N) continue;
    std::sort(on.begin(), on.begin() + count);
    for (unsigned choice = 0; choice < 1U << count; ++choice) {
      if (std::popcount(choice) != int(N)) continue;
      std::array<Index, N> key;
      std::size_t k = 0;
      for (std::size_t i = 0; i < count; ++i) {
        if ((choice >> i & 1U) != 0) key[k++] = on[i];
      }
      lookup.find(key, [&](Index i) { found(i, t); });
    }
  }
}

}  // namespace tetune::mpi
