// SPDX-License-Identifier: Apache-2.0
// Named data follow their vertices and elements.
#include "tetune/data.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

template <class T>
std::vector<T> counted(std::size_t n) {
  std::vector<T> values(n);
  std::iota(values.begin(), values.end(), T{});
  return values;
}

const std::vector<std::int32_t>& ints(const DataArray& array) {
  return std::get<std::vector<std::int32_t>>(array.values);
}

double linear(const Point3& p) { return 3 * p[0] - 2 * p[1] + 0.5 * p[2] + 7; }

TEST(Data, InsertedVerticesTakeLinearFieldsExactlyAndIntegersFromTheNearest) {
  TetMesh m = cube(4, 0.25);
  std::vector<Index> vertex2original = counted<Index>(m.points.size());
  std::vector<double> field(2 * m.points.size());
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    field[2 * v] = linear(m.points[v]);
    field[2 * v + 1] = -5;
  }
  const std::vector<double> expected = field;
  std::size_t inserted = 0;
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    const Point3& p = m.points[v];
    const auto inner = [](double x) { return x > 0.1 && x < 0.6; };  // neighbours of each other too
    if (!inner(p[0]) || !inner(p[1]) || !inner(p[2])) continue;
    vertex2original[v] = -1;
    ++inserted;
  }
  ASSERT_EQ(inserted, 8U);
  const auto data = carry_point_data({{"linear", 2, field}, {"id", 1, counted<std::int32_t>(m.points.size())}},
                                     vertex2original, m.points, m.tets);
  const auto& values = std::get<std::vector<double>>(data[0].values);
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], expected[i], 1e-12);
  for (std::size_t v = 0; v < vertex2original.size(); ++v) {
    const std::int32_t id = ints(data[1])[v];
    if (vertex2original[v] >= 0) {
      EXPECT_EQ(id, vertex2original[v]);
    } else {
      EXPECT_GE(vertex2original[static_cast<std::size_t>(id)], 0);
    }
  }
}

TEST(Data, EntriesThatAreNotThereAreRefused) {
  EXPECT_THROW(take_entries({{"short", 2, std::vector<float>(5)}}, {0, 1, 2}), MeshError);
}

TEST(Data, LengthsAreValidated) {
  TetMesh m = cube(2);
  m.tet_data = {{"heat", 3, std::vector<float>(3 * m.tets.size())}};
  EXPECT_TRUE(validate(m).ok());
  std::get<std::vector<float>>(m.tet_data[0].values).pop_back();
  EXPECT_NE(validate(m).message(false).find("\"heat\" on tetrahedra"), std::string::npos);
  EXPECT_THROW(optimize(m), MeshError);
}

TEST(Data, FollowsVerticesAndElements) {
  TetMesh m = two_materials(6, 0.3);
  // Triangles of the interface carry their number as their tag; one without a tag lies inside a region and is dropped.
  m.triangles.clear();
  for (const auto& tet : m.tets) {
    std::vector<Index> on;
    for (const Index v : tet) {
      if (m.points[static_cast<std::size_t>(v)][0] == 0.5) on.push_back(v);
    }
    if (on.size() == 3) m.triangles.push_back({on[0], on[1], on[2]});
  }
  m.triangles.insert(m.triangles.begin(), {m.tets[0][0], m.tets[0][1], m.tets[0][3]});
  const auto triangles = m.triangles;
  m.triangle_tags = counted<int>(m.triangles.size());
  m.triangle_data = {{"id", 1, counted<std::int32_t>(m.triangles.size())}};
  m.edges = {{0, 1}, {5, 300}, {1, 2}};
  m.edge_tags = {5, 0, 6};
  m.edge_data = {{"id", 1, counted<std::int32_t>(3)}};
  m.point_data = {{"id", 1, counted<std::int32_t>(m.points.size())},
                  {"u", 3, std::vector<float>(3 * m.points.size(), 2)}};
  m.tet_data = {{"region", 1, std::vector<std::int32_t>(m.tet_tags.begin(), m.tet_tags.end())},
                {"id", 1, counted<std::int32_t>(m.tets.size())}};
  Options options;
  options.effort = Effort::best;
  const Report report = optimize(m, options);
  ASSERT_TRUE(validate(m).ok());
  ASSERT_GT(report.vertices_inserted + report.vertices_removed, 0);
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    if (report.vertex2original[v] < 0) continue;
    EXPECT_EQ(ints(m.point_data[0])[v], report.vertex2original[v]);
  }
  for (const float u : std::get<std::vector<float>>(m.point_data[1].values)) EXPECT_FLOAT_EQ(u, 2);
  EXPECT_EQ(ints(m.tet_data[0]), m.tet_tags);
  EXPECT_EQ(ints(m.tet_data[1]), report.tet2original);
  EXPECT_EQ(ints(m.triangle_data[0]), m.triangle_tags);
  EXPECT_EQ(ints(m.edge_data[0]), (std::vector<std::int32_t>{0, 2}));
}

}  // namespace
}  // namespace tetune::test
