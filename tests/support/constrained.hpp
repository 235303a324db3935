// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <vector>

#include "support/meshes.hpp"

/// Meshes with something of each constraint, and what is left of it.
namespace tetune::test {

/// Materials, tagged patches, lines, frozen parts: a bit of everything, at random.
inline TetMesh varied(std::uint32_t seed) {
  std::mt19937 random(seed);
  const int n = 3 + static_cast<int>(random() % 4);
  TetMesh m = scrambled(seed % 2 == 0 ? two_materials(n + n % 2, 0.15) : cube(n, 0.2, seed), 2, seed);
  // Stretch and shear: affine maps keep all volumes positive.
  const double s = 0.3 + static_cast<double>(random() % 100) / 50;
  for (Point3& p : m.points) p = {p[0] + 0.2 * p[1], s * p[1], p[2] - 0.3 * p[0]};
  for (int& tag : m.point_tags) tag = static_cast<int>(random() % 3);
  for (int i = 0; i < 5; ++i) m.required_vertices.push_back(static_cast<Index>(random() % m.points.size()));
  for (int i = 0; i < 3; ++i) m.required_tets.push_back(static_cast<Index>(random() % m.tets.size()));
  for (int i = 0; i < 10; ++i) {
    const auto& t = m.tets[random() % m.tets.size()];
    m.triangles.push_back({t[0], t[1], t[2]});
    m.triangle_tags.push_back(static_cast<int>(random() % 3));
    m.edges.push_back({t[1], t[3]});
    m.edge_tags.push_back(static_cast<int>(random() % 3));
  }
  return m;
}

inline std::set<std::array<Index, 4>> as_set(const TetMesh& m, const std::vector<Index>& ids) {
  std::set<std::array<Index, 4>> set;
  for (const Index id : ids) {
    auto t = m.tets[static_cast<std::size_t>(id)];
    std::sort(t.begin(), t.end());
    set.insert(t);
  }
  return set;
}

template <std::size_t N>
std::set<std::array<Index, N>> tagged(const std::vector<std::array<Index, N>>& items, const std::vector<int>& tags) {
  std::set<std::array<Index, N>> set;
  for (std::size_t i = 0; i < items.size(); ++i) {
    auto v = items[i];
    std::sort(v.begin(), v.end());
    if (tags[i] != 0) set.insert(v);
  }
  return set;
}

/// Each tagged face and edge is one of the mesh.
inline void expect_present(const TetMesh& m) {
  std::set<std::array<Index, 3>> faces;
  std::set<std::array<Index, 2>> edges;
  for (auto t : m.tets) {
    std::sort(t.begin(), t.end());
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::array<Index, 3> f{};
      for (std::size_t k = 0, at = 0; k < 4; ++k) {
        if (k != skip) f[at++] = t[k];
      }
      faces.insert(f);
      for (std::size_t k = skip + 1; k < 4; ++k) edges.insert({t[skip], t[k]});
    }
  }
  for (const auto& f : tagged(m.triangles, m.triangle_tags)) EXPECT_TRUE(faces.count(f) == 1);
  for (const auto& e : tagged(m.edges, m.edge_tags)) EXPECT_TRUE(edges.count(e) == 1);
}

}  // namespace tetune::test
