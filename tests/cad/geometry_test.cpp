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

}  // namespace
}  // namespace tetune
