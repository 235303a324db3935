// SPDX-License-Identifier: Apache-2.0
// optimize_on_geometry() from C++: what the command line cannot give it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "io/io_fixture.hpp"
#include "support/meshes.hpp"
#include "tetune/tetune.hpp"

namespace tetune {
namespace {

class OnGeometry : public test::IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    const std::string command = "\"" TETUNE_MAKE_PARTS "\" \"" + path("") + "\" > /dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  /// The box of edges 1, 1 and 0.02.
  Geometry plate() const { return Geometry(path("plate.step")); }
  static TetMesh mesh_of_plate() {
    TetMesh mesh = test::cube(4);
    for (Point3& p : mesh.points) p[2] *= 0.02;
    return mesh;
  }
  static Options sliding() {
    Options options;
    options.boundary = Boundary::slide;
    return options;
  }
};

TEST_F(OnGeometry, AMeshWithoutVerticesStaysEmpty) {
  TetMesh mesh;
  const GeometryReport report = optimize_on_geometry(mesh, plate(), sliding());
  EXPECT_TRUE(mesh.points.empty());
  EXPECT_EQ(report.vertices_snapped, 0);
}

TEST_F(OnGeometry, FrozenVerticesAreOnePerVertex) {
  TetMesh mesh = mesh_of_plate();
  const std::vector<Point3> before = mesh.points;
  const auto error = [&](std::size_t entries) -> std::string {
    Options options = sliding();
    options.frozen_vertices.assign(entries, 1);
    try {
      optimize_on_geometry(mesh, plate(), options);
    } catch (const OptionError& e) {
      return e.what();
    }
    return "";
  };
  const std::string count = std::to_string(before.size());
  for (const std::size_t entries : {std::size_t{1}, before.size() + 1}) {
    EXPECT_EQ(error(entries), "frozen_vertices has " + std::to_string(entries) + " entries for " + count +
                                  " vertices; it must have one per vertex, or none");
  }
  EXPECT_EQ(error(before.size()), "");
  EXPECT_EQ(mesh.points, before);
}

TEST_F(OnGeometry, VerticesOfPointElementsEndOnIt) {
  TetMesh mesh = mesh_of_plate();
  const auto is_bottom = [&mesh](std::size_t v) { return mesh.points[v][2] == 0; };
  ElementBlock points{kPoints, 1, {}, {}, {}};
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (!is_bottom(v)) continue;
    points.element2vertex.push_back(Index(v));
    points.tags.push_back(1);
  }
  const std::vector<Point3> on_it = mesh.points;
  for (const Index v : points.element2vertex) mesh.points[std::size_t(v)][2] = -0.0005;
  mesh.others = {points};
  const TetMesh input = mesh;
  const GeometryReport report = optimize_on_geometry(mesh, plate(), sliding());
  EXPECT_EQ(report.vertices_snapped, std::ssize(points.element2vertex));
  EXPECT_EQ(report.vertices_left_off, 0);
  EXPECT_EQ(report.optimization.warnings, std::vector<std::string>());
  EXPECT_EQ(mesh.others[0].element2vertex, points.element2vertex);
  for (const Index v : points.element2vertex) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(mesh.points[std::size_t(v)][k], on_it[std::size_t(v)][k], 1e-12);
    }
  }

  // Vertices that are held otherwise are not moved, and the report has their number.
  mesh = input;
  mesh.required_vertices = {points.element2vertex[0], points.element2vertex[1]};
  const GeometryReport held = optimize_on_geometry(mesh, plate(), sliding());
  EXPECT_EQ(held.vertices_left_off, 2);
  EXPECT_NEAR(held.largest_left_off, 0.0005, 1e-9);
  EXPECT_EQ(held.vertices_snapped, std::ssize(points.element2vertex) - 2);
  ASSERT_EQ(held.optimization.warnings.size(), 1U);
  EXPECT_EQ(held.optimization.warnings[0],
            "2 vertices stay off the geometry, by up to 0.0005: required entities, frozen parts or elements of other "
            "kinds hold them");
  for (const Index v : mesh.required_vertices) EXPECT_EQ(mesh.points[std::size_t(v)], input.points[std::size_t(v)]);
}

}  // namespace
}  // namespace tetune
