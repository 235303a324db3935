// SPDX-License-Identifier: Apache-2.0
// read_mesh() reads files of write_mesh() back to the last bit: text and binary.
#include <random>

#include "io_fixture.hpp"
#include "support/bits.hpp"

namespace tetune::test {
namespace {

class RoundTrip : public IoTest, public ::testing::WithParamInterface<const char*> {
 protected:
  std::string file(const std::string& stem) const { return path(stem + GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(Formats, RoundTrip, ::testing::Values(".mesh", ".meshb"),
                         [](const auto& test) { return std::string(test.param).substr(1); });

TEST_P(RoundTrip, AllSections) {
  const TetMesh mesh = all_sections();
  write_mesh(file("a"), mesh);
  std::vector<std::string> warnings;
  expect_same(read_mesh(file("a"), &warnings), mesh);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

TEST_P(RoundTrip, DoublesOfAnyKind) {
  std::mt19937_64 random(7);
  TetMesh mesh = one_tet();
  while (mesh.points.size() < 20000) {
    Point3 p{};
    for (double& x : p) {
      do {
        x = double_of(random());
      } while (!std::isfinite(x));
    }
    mesh.points.push_back(p);
  }
  mesh.point_tags.resize(mesh.points.size());
  write_mesh(file("a"), mesh);
  expect_same(read_mesh(file("a")), mesh);
}

TEST_P(RoundTrip, EmptyMesh) {
  write_mesh(file("a"), TetMesh{});
  expect_same(read_mesh(file("a")), TetMesh{});
}

/// More elements than a writer's thread takes at once: the parts must come out in order.
TEST_P(RoundTrip, SameBytesForAnyNumberOfThreads) {
  const TetMesh mesh = two_materials(24, 0.2);
  ASSERT_GT(mesh.tets.size(), 80000U);
  write_mesh(file("one"), mesh, 1);
  write_mesh(file("two"), mesh, 2);
  write_mesh(file("three"), mesh, 3);
  const std::string bytes = get(std::string("one") + GetParam());
  EXPECT_EQ(get(std::string("two") + GetParam()), bytes);
  EXPECT_EQ(get(std::string("three") + GetParam()), bytes);
  expect_same(read_mesh(file("three"), nullptr, 2), mesh);
}

TEST_P(RoundTrip, InsideOutIsTurnedAndTurnedBack) {
  const TetMesh mesh = all_sections();
  write_mesh(file("out"), turned(mesh));
  const TetMesh read = read_mesh(file("out"));
  EXPECT_TRUE(read.listed_inside_out);
  EXPECT_EQ(read.tets, mesh.tets);
  write_mesh(file("again"), read);
  EXPECT_EQ(get(std::string("again") + GetParam()), get(std::string("out") + GetParam()));
}

TEST_P(RoundTrip, MixedOrientationIsMadeOne) {
  TetMesh mesh = cube(1);
  std::swap(mesh.tets[3][0], mesh.tets[3][1]);
  write_mesh(file("a"), mesh);
  std::swap(mesh.tets[3][2], mesh.tets[3][3]);
  std::vector<std::string> warnings;
  expect_same(read_mesh(file("a"), &warnings), mesh);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("1 of 6 tetrahedra are listed inside out"), std::string::npos) << warnings[0];
}

TEST_F(IoTest, TextCarriesTheShortestDigits) {
  TetMesh mesh;
  mesh.points = {{0.1, -0.0, 5e-324}, {1e22, 3, 1.0 / 3}};
  mesh.point_tags = {4, 0};
  write_mesh(path("a.mesh"), mesh);
  EXPECT_EQ(get("a.mesh"),
            "MeshVersionFormatted 2\n\nDimension 3\n\nVertices\n2\n"
            "0.1 -0 5e-324 4\n1e+22 3 0.3333333333333333 0\n\nEnd\n");
}

}  // namespace
}  // namespace tetune::test
