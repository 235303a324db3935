// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>
#include <vector>

#include "mesh/tet.hpp"
#include "support/meshes.hpp"
#include "tetune/mesh.hpp"

/// The edges and faces of a mesh, by their vertices in increasing order, and the volumes of its regions.
namespace tetune::test {

inline std::set<std::array<Index, 2>> edges_of(const TetMesh& mesh) {
  std::set<std::array<Index, 2>> edges;
  for (const auto& tet : mesh.tets) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) edges.insert(ascending(tet[i], tet[j]));
    }
  }
  return edges;
}

/// The tags of the tetrahedra on each face.
inline std::map<std::array<Index, 3>, std::vector<int>> face2tags(const TetMesh& mesh) {
  std::map<std::array<Index, 3>, std::vector<int>> faces;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t k = 0; k < 4; ++k) faces[ascending_face(mesh.tets[t], k)].push_back(mesh.tet_tags[t]);
  }
  return faces;
}

inline std::set<std::array<Index, 3>> faces_of(const TetMesh& mesh) {
  std::set<std::array<Index, 3>> faces;
  for (const auto& [face, tags] : face2tags(mesh)) faces.insert(face);
  return faces;
}

/// The faces on one tetrahedron alone.
inline std::set<std::array<Index, 3>> outer_faces(const TetMesh& mesh) {
  std::set<std::array<Index, 3>> faces;
  for (const auto& [face, tags] : face2tags(mesh)) {
    if (tags.size() == 1) faces.insert(face);
  }
  return faces;
}

/// The volume of each region, by its tag.
inline std::map<int, double> region_volumes(const TetMesh& mesh) {
  std::map<int, double> volumes;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& v = mesh.tets[t];
    const Vec3 first = at(mesh, v[0]);
    volumes[mesh.tet_tags[t]] += dot(cross(at(mesh, v[1]) - first, at(mesh, v[2]) - first), at(mesh, v[3]) - first) / 6;
  }
  return volumes;
}

/// Values by tag are those expected, and there are no others.
inline void expect_near_by_tag(const std::map<int, double>& values, const std::map<int, double>& expected,
                               double tolerance) {
  ASSERT_EQ(values.size(), expected.size());
  for (const auto& [tag, value] : expected) {
    ASSERT_EQ(values.count(tag), 1U) << tag;
    EXPECT_NEAR(values.at(tag), value, tolerance) << tag;
  }
}

}  // namespace tetune::test
