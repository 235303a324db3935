// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "mesh/tet.hpp"
#include "support/entities.hpp"
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

/// The vertices of listed tetrahedra.
inline std::set<std::array<Index, 4>> tets_with(const TetMesh& m, const std::vector<Index>& ids) {
  std::set<std::array<Index, 4>> set;
  for (const Index id : ids) set.insert(ascending(m.tets[static_cast<std::size_t>(id)]));
  return set;
}

/// The items whose tag is not 0.
template <std::size_t N>
std::set<std::array<Index, N>> tagged(const std::vector<std::array<Index, N>>& items, const std::vector<int>& tags) {
  std::set<std::array<Index, N>> set;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (tags[i] != 0) set.insert(ascending(items[i]));
  }
  return set;
}

/// Each tagged face and edge is one of the mesh.
inline void expect_present(const TetMesh& m) {
  const std::set<std::array<Index, 3>> faces = faces_of(m);
  const std::set<std::array<Index, 2>> edges = edges_of(m);
  for (const auto& f : tagged(m.triangles, m.triangle_tags)) EXPECT_TRUE(faces.count(f) == 1);
  for (const auto& e : tagged(m.edges, m.edge_tags)) EXPECT_TRUE(edges.count(e) == 1);
}

/// Lists the faces on the sides of the unit cube, as seen from outside, with the tags 1 to 6, and those between two
/// regions with the tag 7.
inline TetMesh with_listed_sides(TetMesh m) {
  std::map<std::array<Index, 3>, std::pair<std::array<Index, 3>, int>> once;  // by sorted vertices
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    const auto& v = m.tets[t];
    const std::array<std::array<Index, 3>, 4> faces{
        {{v[1], v[2], v[3]}, {v[0], v[3], v[2]}, {v[0], v[1], v[3]}, {v[0], v[2], v[1]}}};
    for (const auto& f : faces) {
      const auto [at, is_new] = once.emplace(ascending(f), std::pair(f, m.tet_tags[t]));
      if (is_new) continue;
      if (at->second.second != m.tet_tags[t]) {
        m.triangles.push_back(f);
        m.triangle_tags.push_back(7);
      }
      once.erase(at);
    }
  }
  for (const auto& [key, face] : once) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (const double side : {0.0, 1.0}) {
        const auto is_on = [&](Index v) { return m.points[static_cast<std::size_t>(v)][k] == side; };
        if (!std::all_of(key.begin(), key.end(), is_on)) continue;
        m.triangles.push_back(face.first);
        m.triangle_tags.push_back(static_cast<int>(1 + k) + (side == 1 ? 3 : 0));
      }
    }
  }
  return m;
}

}  // namespace tetune::test
