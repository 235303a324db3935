// SPDX-License-Identifier: Apache-2.0
// Warnings of what a run does to the data of a mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <set>

#include "support/meshes.hpp"
#include "tetune/optimize.hpp"

namespace tetune {
namespace {

/// The numbers from 1 on.
std::vector<std::int64_t> numbers(std::size_t count) {
  std::vector<std::int64_t> values(count);
  std::iota(values.begin(), values.end(), 1);
  return values;
}

/// A mesh with numbers of its vertices and tetrahedra, and with data that are none.
TetMesh numbered(TetMesh mesh) {
  mesh.point_data.push_back({"node", 1, numbers(mesh.points.size())});
  mesh.point_data.push_back({"zero", 1, std::vector<std::int64_t>(mesh.points.size(), 0)});
  mesh.tet_data.push_back({"element", 1, numbers(mesh.tets.size())});
  mesh.tet_data.push_back({"vector", 2, numbers(2 * mesh.tets.size())});
  mesh.tet_data.push_back({"field", 1, std::vector<double>(mesh.tets.size(), 1)});
  return mesh;
}

bool mentions(const Report& report, const std::string& text) {
  return std::any_of(report.repeated_numbers.begin(), report.repeated_numbers.end(),
                     [&](const std::string& warning) { return warning.find(text) != std::string::npos; });
}

TEST(RunWarnings, NameNumbersThatMayOccurMoreThanOnce) {
  TetMesh mesh = numbered(test::scrambled(test::cube(6, 0.25), 3, 2));
  Options options;
  options.threads = 1;
  const Report report = optimize(mesh, options);
  const auto& left = std::get<std::vector<std::int64_t>>(mesh.tet_data[0].values);
  ASSERT_LT(std::set<std::int64_t>(left.begin(), left.end()).size(), left.size());
  ASSERT_EQ(report.repeated_numbers.size(), 1U);
  EXPECT_TRUE(mentions(report, "the values of element number the tetrahedra"));
  EXPECT_NE(std::find(report.warnings.begin(), report.warnings.end(), report.repeated_numbers[0]),
            report.warnings.end());
}

TEST(RunWarnings, NameNumbersOfVerticesWhereSomeAreInserted) {
  TetMesh mesh = numbered(test::cube(4, 0.2));
  Options options;
  options.threads = 1;
  options.effort = Effort::best;
  const Report report = optimize(mesh, options);
  ASSERT_GT(report.vertices_inserted, 0);
  EXPECT_TRUE(mentions(report, "the values of node number the vertices"));
}

TEST(RunWarnings, NameNoNumbersWhereTetrahedraStay) {
  TetMesh mesh = numbered(test::cube(4, 0.2));
  Options options;
  options.threads = 1;
  options.flips = false;
  EXPECT_TRUE(optimize(mesh, options).repeated_numbers.empty());
}

}  // namespace
}  // namespace tetune
