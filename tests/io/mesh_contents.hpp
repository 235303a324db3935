// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mesh/tet.hpp"
#include "support/meshes.hpp"

/// Meshes with all that a format may keep, and comparisons of what came back.
namespace tetune::test {

/// Something of all that any format keeps, all tags different.
inline TetMesh rich() {
  TetMesh m = two_materials(4);
  m.triangles.clear();
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    std::array<Index, 3> on{};
    std::size_t n = 0;
    for (const Index v : m.tets[t]) {
      if (m.points[static_cast<std::size_t>(v)][0] == 0.5 && n < 3) on[n++] = v;
    }
    if (n == 3 && m.tet_tags[t] == 1) m.triangles.push_back(on);
  }
  m.triangle_tags.assign(m.triangles.size(), 11);
  m.triangle_tags[0] = 12;
  m.edges = {{0, 1}, {1, 2}};
  m.edge_tags = {21, 22};
  // An island of other elements.
  const auto first = static_cast<Index>(m.points.size());
  const std::array<Point3, 10> corners{{{5 + 1.0 / 3, 0, 0},
                                        {6, 0, 0},
                                        {6, 1, 0},
                                        {5, 1, 0},
                                        {5, 0, 1},
                                        {6, 0, 1},
                                        {6, 1, 1},
                                        {5, 1, 1},
                                        {5, 0, -1},
                                        {6, 0, -1}}};
  m.points.insert(m.points.end(), corners.begin(), corners.end());
  const auto island = [first](std::vector<Index> v) {
    for (Index& i : v) i += first;
    return v;
  };
  m.others = {{kPoints, 1, {0}, {31}, {}},
              {"Quadrilaterals", 4, island({0, 1, 2, 3}), {13}, {}},
              {"Pyramids", 5, island({0, 3, 2, 1, 8}), {3}, {}},
              {"Prisms", 6, island({0, 3, 8, 1, 2, 9}), {4}, {}},
              {"Hexahedra", 8, island({0, 1, 2, 3, 4, 5, 6, 7}), {5}, {}}};
  m.point_tags.assign(m.points.size(), 0);
  std::vector<double> heat;
  for (std::size_t v = 0; v < m.points.size(); ++v) heat.push_back(0.1 * static_cast<double>(v));
  m.point_data = {{"heat", 1, heat}, {"wind", 3, std::vector<float>(3 * m.points.size(), 0.25F)}};
  std::vector<double> load;
  for (std::size_t t = 0; t < m.tets.size(); ++t) load.push_back(1.0 / static_cast<double>(t + 1));
  m.tet_data = {{"load", 1, load}};
  m.groups = {{3, 1, "steel", {1}}, {3, 2, "air gap", {2}}, {2, 11, "interface", {11}}, {1, 21, "rim", {21}}};
  return m;
}

/// rich(), for formats without pyramids.
inline TetMesh rich_without_pyramids() {
  TetMesh m = rich();
  std::erase_if(m.others, [](const ElementBlock& block) { return block.kind == "Pyramids"; });
  return m;
}

/// The numbers of a list of elements with their tags and order left out of account.
template <std::size_t N>
std::multiset<std::pair<std::vector<Index>, int>> tagged(const std::vector<std::array<Index, N>>& elements,
                                                         const std::vector<int>& tags) {
  std::multiset<std::pair<std::vector<Index>, int>> result;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const std::array<Index, N> v = ascending(elements[i]);
    result.emplace(std::vector<Index>(v.begin(), v.end()), tags[i]);
  }
  return result;
}

inline const DataArray* find(const std::vector<DataArray>& data, const std::string& name) {
  const auto at = std::find_if(data.begin(), data.end(), [&name](const DataArray& a) { return a.name == name; });
  return at == data.end() ? nullptr : &*at;
}

inline std::vector<double> doubles(const DataArray& array) {
  return std::visit([](const auto& v) { return std::vector<double>(v.begin(), v.end()); }, array.values);
}

inline bool same_point_data(const TetMesh& a, const TetMesh& b) {
  return std::all_of(a.point_data.begin(), a.point_data.end(), [&b](const DataArray& array) {
    const DataArray* same = find(b.point_data, array.name);
    return same != nullptr && same->components == array.components && doubles(*same) == doubles(array);
  });
}

/// The value of each tetrahedron, whatever its place in the list.
inline std::map<std::array<Index, 4>, double> by_tet(const TetMesh& m, const std::string& name) {
  std::map<std::array<Index, 4>, double> result;
  const DataArray* array = find(m.tet_data, name);
  if (array == nullptr) return result;
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    result[ascending(m.tets[t])] = doubles(*array)[t];
  }
  return result;
}

inline bool same_groups(const TetMesh& a, const TetMesh& b) {
  return std::all_of(a.groups.begin(), a.groups.end(), [&b](const Group& g) {
    return std::any_of(b.groups.begin(), b.groups.end(), [&g](const Group& h) {
      return g.dimension == h.dimension && g.number == h.number && g.name == h.name && g.tags == h.tags;
    });
  });
}

inline bool same_others(const TetMesh& a, const TetMesh& b) {
  return std::all_of(a.others.begin(), a.others.end(), [&b](const ElementBlock& block) {
    const auto at = std::find_if(b.others.begin(), b.others.end(),
                                 [&block](const ElementBlock& o) { return o.kind == block.kind; });
    return block.kind == kPoints ||
           (at != b.others.end() && at->element2vertex == block.element2vertex && at->tags == block.tags);
  });
}

inline double farthest(const TetMesh& a, const TetMesh& b) {
  if (a.points.size() != b.points.size()) return 1e300;
  double most = 0;
  for (std::size_t v = 0; v < a.points.size(); ++v) {
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::fabs(a.points[v][k] - b.points[v][k]));
  }
  return most;
}

/// A mesh whose tetrahedra in slices along x have the tags, in turn; the first triangles those of `of_triangles`.
inline TetMesh with_tags(const std::vector<int>& tags, const std::vector<int>& of_triangles = {}) {
  TetMesh m = cube(4);
  m.tet_tags.clear();
  for (const auto& tet : m.tets) {
    double x = 0;
    for (const Index v : tet) x += m.points[static_cast<std::size_t>(v)][0] / 4;
    const auto slice = static_cast<std::size_t>(x * static_cast<double>(tags.size()));
    m.tet_tags.push_back(tags[std::min(slice, tags.size() - 1)]);
  }
  m.triangles.clear();
  for (std::size_t i = 0; i < of_triangles.size(); ++i) {
    m.triangles.push_back({m.tets[i][0], m.tets[i][1], m.tets[i][2]});
  }
  m.triangle_tags = of_triangles;
  return m;
}

inline bool same_tags(const TetMesh& a, const TetMesh& b) {
  return tagged(a.tets, a.tet_tags) == tagged(b.tets, b.tet_tags) &&
         tagged(a.triangles, a.triangle_tags) == tagged(b.triangles, b.triangle_tags);
}

inline std::set<int> distinct(const std::vector<int>& tags) { return {tags.begin(), tags.end()}; }

}  // namespace tetune::test
