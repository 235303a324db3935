// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mesh/tet.hpp"

namespace tetune {

/// Finds which of listed faces are faces of elements, by their vertices in any order: up to N, and -1 for those that a
/// face does not have.
template <std::size_t N>
class ListedFaces {
 public:
  /// `faces` with their ids, and the number of vertices of the mesh.
  ListedFaces(std::vector<std::pair<std::array<Index, N>, Index>> faces, std::size_t vertices)
      : faces_(std::move(faces)), is_listed_(vertices, 0) {
    for (auto& [face, id] : faces_) {
      for (const Index v : face) {
        if (v >= 0) is_listed_[std::size_t(v)] = 1;
      }
      face = ascending(face);
    }
    std::sort(faces_.begin(), faces_.end());
  }

  std::size_t size() const { return faces_.size(); }
  /// The number of vertices that are vertices of listed faces.
  std::ptrdiff_t count_listed(std::span<const Index> vertices) const {
    return std::count_if(vertices.begin(), vertices.end(), [this](Index v) { return is_listed(v); });
  }

  /// Calls take(id) for each listed face with these vertices, in the order of ids.
  template <class Take>
  void find(const std::array<Index, N>& face, const Take& take) const {
    if (!std::all_of(face.begin(), face.end(), [this](Index v) { return v < 0 || is_listed(v); })) return;
    const std::array<Index, N> key = ascending(face);
    auto at = std::lower_bound(faces_.begin(), faces_.end(), key,
                               [](const auto& entry, const auto& sought) { return entry.first < sought; });
    for (; at != faces_.end() && at->first == key; ++at) take(at->second);
  }
  /// Calls take(k, id) for each listed face that is the one opposite vertex k of a tetrahedron.
  template <class Take>
  void find_in_tet(const std::array<Index, 4>& tet, const Take& take) const {
    static_assert(N == 3);
    if (count_listed(tet) < 3) return;
    for (std::size_t k = 0; k < 4; ++k) {
      find(ascending_face(tet, k), [&](Index id) { take(k, id); });
    }
  }

 private:
  bool is_listed(Index v) const { return is_listed_[std::size_t(v)] != 0; }

  std::vector<std::pair<std::array<Index, N>, Index>> faces_;
  std::vector<std::uint8_t> is_listed_;
};

}  // namespace tetune
