// SPDX-License-Identifier: Apache-2.0
// Sets of nodes and tags of vertices, where vertices are inserted on the surface and inside.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/meshes.hpp"
#include "tetune/optimize.hpp"

namespace tetune {
namespace {

using Members = std::vector<std::uint8_t>;

bool is_on_face(const Point3& p) { return p[0] == 0; }
bool is_on_line(const Point3& p) { return p[1] == 1 && p[2] == 0; }
bool is_on_surface(const Point3& p) {
  return std::any_of(p.begin(), p.end(), [](double x) { return x == 0 || x == 1; });
}
int tag_at(const Point3& p) { return is_on_surface(p) ? 0 : 7; }

struct NamedSet {
  const char* name;
  bool (*has)(const Point3&);
};
constexpr std::array kSets{NamedSet{"node_set:1:face", is_on_face}, NamedSet{"node_set:2:line", is_on_line},
                           NamedSet{"node_set:3:surface", is_on_surface},
                           NamedSet{"node_set:4:all", [](const Point3&) { return true; }}};

/// A unit cube with slivers, and sets of its vertices.
TetMesh with_sets(std::uint32_t seed) {
  TetMesh mesh = test::cube(6, 0.25, seed);
  for (const NamedSet& set : kSets) {
    Members members;
    for (const Point3& p : mesh.points) members.push_back(set.has(p) ? 1 : 0);
    mesh.point_data.push_back({set.name, 1, members});
  }
  std::transform(mesh.points.begin(), mesh.points.end(), mesh.point_tags.begin(), tag_at);
  return mesh;
}

class InsertedInSets : public testing::TestWithParam<std::tuple<DataTransfer, Boundary, bool>> {};

TEST_P(InsertedInSets, JoinTheSetsAndHaveTheTagsOfWhereTheyAre) {
  Options options;
  options.effort = Effort::best;
  options.surface_vertices = SurfaceVertices::edit;
  options.max_growth = 1.3;
  options.restarts = 0;
  bool in_parts = false;
  std::tie(options.data, options.boundary, in_parts) = GetParam();
  if (in_parts) options.only_below = {{Measure::mean_ratio, 0.4}};
  int on_face = 0, inside = 0;
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
    TetMesh mesh = with_sets(seed);
    const Report report = optimize(mesh, options);
    ASSERT_EQ(mesh.point_data.size(), kSets.size());
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      const Point3& p = mesh.points[v];
      for (std::size_t s = 0; s < kSets.size(); ++s) {
        EXPECT_EQ(mesh.point_data[s].name, kSets[s].name);
        EXPECT_EQ(std::get<Members>(mesh.point_data[s].values).at(v), kSets[s].has(p) ? 1 : 0)
            << kSets[s].name << ", vertex " << v << " at " << p[0] << " " << p[1] << " " << p[2];
      }
      const bool is_inserted = !report.vertex2original.empty() && report.vertex2original[v] < 0;
      if (!is_inserted) {
        EXPECT_EQ(mesh.point_tags[v], tag_at(p));
        continue;
      }
      // Inside there may be vertices of the surface in its part of the input.
      EXPECT_TRUE(!is_on_surface(p) || mesh.point_tags[v] == 0);
      on_face += is_on_face(p) ? 1 : 0;
      inside += is_on_surface(p) ? 0 : 1;
    }
  }
  EXPECT_GT(on_face, 0);
  EXPECT_GT(inside, 0);
}

INSTANTIATE_TEST_SUITE_P(All, InsertedInSets,
                         testing::Combine(testing::Values(DataTransfer::carry, DataTransfer::interpolate,
                                                          DataTransfer::conserve),
                                          testing::Values(Boundary::preserve, Boundary::slide), testing::Bool()));

}  // namespace
}  // namespace tetune
