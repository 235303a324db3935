// SPDX-License-Identifier: Apache-2.0
// Named data of vertices and elements through optimize().
#include "tetune/data.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "support/meshes.hpp"
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
    const auto inner = [](double x) { return x > 0.1 && x < 0.6; };  // some are neighbors of each other
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

TEST(Data, InsertedVerticesTakeValuesInAnyUnit) {
  TetMesh m = cube(4, 0.25);
  std::vector<Index> vertex2original = counted<Index>(m.points.size());
  vertex2original[62] = -1;
  const std::vector<double> field(m.points.size(), 3);
  for (const double unit : {1e-200, 1e160}) {
    const TetMesh in_unit = scaled(m, unit);
    const auto data = carry_point_data({{"three", 1, field}}, vertex2original, in_unit.points, in_unit.tets);
    EXPECT_NEAR(std::get<std::vector<double>>(data[0].values)[62], 3, 1e-12);
  }
}

TEST(Data, MissingEntriesAreRefused) {
  EXPECT_THROW(take_entries({{"short", 2, std::vector<float>(5)}}, {0, 1, 2}), MeshError);
  EXPECT_THROW(take_entries({{"x", 1, std::vector<float>(5)}}, {0, -2}), MeshError);
  EXPECT_EQ(std::get<std::vector<float>>(take_entries({{"x", 1, std::vector<float>{3}}}, {0, -1})[0].values),
            (std::vector<float>{3, 0}));
  EXPECT_THROW(take_entries({{"none", 0, std::vector<float>(5)}}, {0}), MeshError);
  EXPECT_THROW(take_entries({{"fewer", -1, std::vector<float>(5)}}, {0}), MeshError);
  const TetMesh m = one_tet();
  EXPECT_THROW(carry_point_data({{"x", 1, std::vector<float>(4)}}, {0, 1, 2, 3, -1}, m.points, m.tets), MeshError);
  EXPECT_THROW(carry_point_data({{"x", 1, std::vector<float>(4)}}, {0, 1, -2, -1}, m.points, m.tets), MeshError);
  EXPECT_THROW(carry_point_data({{"x", 1, std::vector<float>(4)}}, {0, 1, 2, -1}, m.points, {{0, 1, 2, 4}}), MeshError);
}

TEST(Data, LengthsAreValidated) {
  TetMesh m = cube(2);
  m.tet_data = {{"heat", 3, std::vector<float>(3 * m.tets.size())}};
  EXPECT_TRUE(validate(m).ok());
  std::get<std::vector<float>>(m.tet_data[0].values).pop_back();
  EXPECT_NE(validate(m).message(false).find("\"heat\" on tetrahedra"), std::string::npos);
  EXPECT_THROW(optimize(m), MeshError);
  m = cube(2);
  m.others.push_back({"Prisms", 0, {}, {}, {}});
  EXPECT_NE(validate(m).message(false).find("vertices of Prisms"), std::string::npos);
}

TEST(Data, FollowsVerticesAndElements) {
  TetMesh m = two_materials(6, 0.3);
  // Triangles of the interface have their position as their tag; the untagged one is inside a region and is dropped.
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

/// Two tetrahedra and one of their triangles, with a field and region numbers.
TetMesh with_regions() {
  TetMesh m = two_tets(0.5);
  m.triangles = {{m.tets[0][0], m.tets[0][1], m.tets[0][2]}};
  m.triangle_tags = {4};
  m.tet_tags = {1, 2};
  m.tet_data = {{"heat", 1, std::vector<double>{0.5, 1.5}}, {"material", 1, std::vector<float>{7, 9}}};
  return m;
}

TEST(DataAsTags, NewAndPreviousTagsAreKeptAsData) {
  TetMesh m = with_regions();
  m.cell_tags_name = "refs";
  use_as_tags(m, "material");
  EXPECT_EQ(m.tet_tags, (std::vector<int>{7, 9}));
  EXPECT_EQ(m.triangle_tags, (std::vector<int>{0}));
  EXPECT_EQ(m.cell_tags_name, "refs");
  ASSERT_EQ(m.tet_data.size(), 3U);
  EXPECT_EQ(m.tet_data[1].name, "material");
  EXPECT_EQ(m.tet_data[2].name, "refs:before");
  EXPECT_EQ(ints(m.tet_data[2]), (std::vector<std::int32_t>{1, 2}));
  ASSERT_EQ(m.triangle_data.size(), 1U);
  EXPECT_EQ(ints(m.triangle_data[0]), (std::vector<std::int32_t>{4}));
  // The reverse, with a new name for the previous tags.
  use_as_tags(m, "refs:before");
  EXPECT_EQ(m.tet_tags, (std::vector<int>{1, 2}));
  EXPECT_EQ(m.triangle_tags, (std::vector<int>{4}));
  ASSERT_EQ(m.tet_data.size(), 4U);
  EXPECT_EQ(m.tet_data[3].name, "refs:before:before");
}

TEST(DataAsTags, WithoutPreviousTagsThereIsNoNewData) {
  TetMesh m = with_regions();
  m.tet_tags = {0, 0};
  m.triangle_tags = {0};
  m.tet_data[1].values = std::vector<double>{std::numeric_limits<double>::quiet_NaN(), -3};
  use_as_tags(m, "material");
  EXPECT_EQ(m.tet_tags, (std::vector<int>{0, -3}));
  EXPECT_EQ(m.tet_data.size(), 2U);
  EXPECT_TRUE(m.triangle_data.empty());
}

TEST(DataAsTags, InvalidDataAreRefusedWithoutChange) {
  const TetMesh sound = with_regions();
  const auto refused = [&](TetMesh m, const char* name, const char* expected) {
    const TetMesh before = m;
    try {
      use_as_tags(m, name);
      ADD_FAILURE() << name;
    } catch (const OptionError& e) {
      EXPECT_NE(std::string(e.what()).find(expected), std::string::npos) << e.what();
    }
    EXPECT_EQ(m.tet_tags, before.tet_tags);
    EXPECT_EQ(m.tet_data.size(), before.tet_data.size());
  };
  refused(sound, "Material", "heat, material");
  refused(sound, "heat", "it contains 0.5");
  TetMesh m = sound;
  m.tet_data[1] = {"material", 1, std::vector<double>{7, 1e-9}};
  refused(m, "material", "it contains 1e-09");
  m.tet_data[1] = {"material", 1, std::vector<std::int64_t>{7, std::int64_t{1} << 40}};
  refused(m, "material", "32-bit integer");
  m.tet_data[1] = {"material", 3, std::vector<std::int32_t>{1, 1, 1, 2, 2, 2}};
  refused(m, "material", "3 numbers per cell");
  m = sound;
  m.groups = {{3, 1, "steel", {1}}};
  refused(m, "material", "named groups");
}

}  // namespace
}  // namespace tetune::test
