// SPDX-License-Identifier: Apache-2.0
// Periodic links of Gmsh's files.
#include <array>

#include "mesh_contents.hpp"
#include "msh_fixture.hpp"
#include "support/entities.hpp"
#include "tetune/optimize.hpp"

namespace tetune::test {
namespace {

TEST_F(Msh, PeriodicLinksAreKeptAndMatch) {
  TetMesh m = cube(4, 0.2);
  m.tet_tags.assign(m.tets.size(), 1);
  m.cell_tags_name = "gmsh:geometrical";
  PeriodicLink link{2, 4, 3, {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, {}};
  const TetMesh regular = cube(4);
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    if (regular.points[v][0] != 1) continue;
    for (std::size_t w = 0; w < m.points.size(); ++w) {
      if (regular.points[w] != Point3{0, regular.points[v][1], regular.points[v][2]}) continue;
      m.points[v] = {1, m.points[w][1], m.points[w][2]};
      link.pairs.push_back({static_cast<Index>(v), static_cast<Index>(w)});
    }
  }
  ASSERT_EQ(link.pairs.size(), 25U);
  m.periodic = {link};
  for (const std::string& dialect : kDialects) {
    SCOPED_TRACE(dialect);
    m.dialect = dialect;
    write_mesh(path("a.msh"), m, 1);
    TetMesh back = read_mesh(path("a.msh"), nullptr, 1);
    ASSERT_EQ(back.periodic.size(), 1U);
    EXPECT_EQ(back.periodic[0].dimension, 2);
    EXPECT_EQ(back.periodic[0].entity, 4);
    EXPECT_EQ(back.periodic[0].master, 3);
    EXPECT_EQ(back.periodic[0].affine, link.affine);
    EXPECT_EQ(back.periodic[0].pairs, link.pairs);
    Options options;
    options.effort = Effort::best;
    options.threads = 1;
    optimize(back, options);
    for (const auto& [vertex, master] : back.periodic[0].pairs) {
      const Point3& p = back.points[static_cast<std::size_t>(vertex)];
      const Point3& q = back.points[static_cast<std::size_t>(master)];
      EXPECT_EQ(p, (Point3{1, q[1], q[2]}));
      EXPECT_EQ(q[0], 0);
    }
  }
  EXPECT_FALSE(contains(get("a.msh"), "$Comments"));  // only the link names its entities
  std::vector<std::string> warnings;
  write_mesh(path("a.mesh"), m, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "periodic links"));
  // Entities that other tags divide are no longer those of the link.
  TetMesh divided = read_mesh(path("a.msh"), nullptr, 1);
  divided.triangles = {{0, 1, 6}, {0, 6, 5}};
  divided.triangle_tags = {1, 2};
  divided.triangle_data = {{"gmsh:geometrical", 1, std::vector<std::int32_t>{4, 4}}};
  warnings.clear();
  write_mesh(path("a.msh"), divided, 1, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "1 periodic links of dimension 2 are not written"));
  EXPECT_TRUE(read_mesh(path("a.msh"), nullptr, 1).periodic.empty());
  // The middles of paired edges are pairs.
  m.second_order = true;
  m.dialect = "msh 4.1 text";
  write_mesh(path("a.msh"), m, 1);
  const std::string text = get("a.msh");
  EXPECT_TRUE(contains(text, "\n81\n"));  // 25 vertices and 56 edges on the face
  EXPECT_EQ(read_mesh(path("a.msh"), nullptr, 1).periodic[0].pairs, link.pairs);
}

TEST_F(Msh, TrianglesOfLinksThatAreNoTranslationsAreNotFlipped) {
  TetMesh m = cube(3);
  m.triangle_tags.clear();
  m.triangles.clear();
  PeriodicLink link{2, 4, 3, {}, {}};
  const auto x = [&m](Index v) { return m.points[static_cast<std::size_t>(v)][0]; };
  for (const auto& face : outer_faces(m)) {
    if (x(face[0]) == 0 && x(face[1]) == 0 && x(face[2]) == 0) m.triangles.push_back(face);
  }
  ASSERT_EQ(m.triangles.size(), 18U);
  m.triangle_tags.assign(m.triangles.size(), 3);
  // The long diagonals of the face would be flipped.
  for (Point3& p : m.points) {
    p[1] += 0.9 * p[2];
    if (p[0] == 0) link.pairs.push_back({static_cast<Index>(&p - m.points.data()), 0});
  }
  TetMesh free = m;
  const auto before = tagged(m.triangles, m.triangle_tags);
  Options options;
  options.threads = 1;
  optimize(free, options);
  EXPECT_NE(tagged(free.triangles, free.triangle_tags), before);
  m.periodic = {link};
  optimize(m, options);
  EXPECT_EQ(tagged(m.triangles, m.triangle_tags), before);
}

}  // namespace
}  // namespace tetune::test
