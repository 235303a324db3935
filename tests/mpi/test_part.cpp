// SPDX-License-Identifier: Apache-2.0
// Parts of a mesh on a rank: taken out and put back.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "../../mpi/src/one_part.hpp"
#include "../../mpi/src/part.hpp"
#include "mesh/vertex_layers.hpp"
#include "support/entities.hpp"
#include "support/meshes.hpp"

namespace tetune::mpi {
namespace {

/// The number of tetrahedra of each region at each face.
std::map<std::array<Index, 3>, std::map<int, int>> faces(const TetMesh& mesh) {
  std::map<std::array<Index, 3>, std::map<int, int>> result;
  for (const auto& [face, tags] : test::face2tags(mesh)) {
    for (const int tag : tags) ++result[face][tag];
  }
  return result;
}

/// A cube of two materials that lists each face and some edges, with required ones and ridges of each kind.
Part make() {
  Part part;
  TetMesh& mesh = part.mesh;
  mesh = test::two_materials(4);
  for (const auto& [face, tets] : faces(mesh)) {
    mesh.triangles.push_back(face);
    mesh.triangle_tags.push_back(static_cast<int>(mesh.triangles.size() % 7));
  }
  for (std::size_t t = 0; t < mesh.tets.size(); t += 3) {
    mesh.edges.push_back({mesh.tets[t][0], mesh.tets[t][1]});
    mesh.edge_tags.push_back(static_cast<int>(t % 5));
  }
  const auto every = [](std::size_t count, std::size_t step) {
    std::vector<Index> list;
    for (std::size_t i = 0; i < count; i += step) list.push_back(static_cast<Index>(i));
    return list;
  };
  mesh.corners = every(mesh.points.size(), 11);
  mesh.required_vertices = every(mesh.points.size(), 13);
  mesh.required_tets = every(mesh.tets.size(), 17);
  mesh.required_triangles = every(mesh.triangles.size(), 19);
  mesh.required_edges = every(mesh.edges.size(), 5);
  mesh.ridges = every(mesh.edges.size(), 3);
  const auto ids = [](std::size_t count, Id first, Id step) {
    std::vector<Id> list;
    for (std::size_t i = 0; i < count; ++i) list.push_back(first + step * static_cast<Id>(i));
    return list;
  };
  part.vertex_id = ids(mesh.points.size(), 1000, 3);
  part.tet_id = ids(mesh.tets.size(), 5, 2);
  part.triangle_id = ids(mesh.triangles.size(), 7, 1);
  part.edge_id = ids(mesh.edges.size(), 9, 4);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    part.vertex_flags.push_back(v % 3 == 0 ? kPending : v % 5 == 0 ? kFirstCut : 0);
  }
  return part;
}

/// All that a part has, in ids, whatever its order.
std::multiset<std::vector<Id>> contents(const Part& part) {
  const TetMesh& mesh = part.mesh;
  std::multiset<std::vector<Id>> all;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    all.insert({0, part.vertex_id[v], mesh.point_tags[v], part.vertex_flags[v],
                static_cast<Id>(1e6 * mesh.points[v][0]), static_cast<Id>(1e6 * mesh.points[v][1]),
                static_cast<Id>(1e6 * mesh.points[v][2])});
  }
  const auto add = [&](Id kind, const auto& list, const auto& tags, const auto& ids) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      std::vector<Id> entry{kind, ids[i], tags[i]};
      for (const Index v : list[i]) entry.push_back(part.vertex_id[static_cast<std::size_t>(v)]);
      all.insert(entry);
    }
  };
  add(1, mesh.tets, mesh.tet_tags, part.tet_id);
  add(2, mesh.triangles, mesh.triangle_tags, part.triangle_id);
  add(3, mesh.edges, mesh.edge_tags, part.edge_id);
  const auto add_listed = [&all](Id kind, const std::vector<Index>& list, const std::vector<Id>& ids) {
    for (const Index i : list) all.insert({kind, ids[static_cast<std::size_t>(i)]});
  };
  add_listed(4, mesh.corners, part.vertex_id);
  add_listed(5, mesh.required_vertices, part.vertex_id);
  add_listed(6, mesh.required_tets, part.tet_id);
  add_listed(7, mesh.required_triangles, part.triangle_id);
  add_listed(8, mesh.required_edges, part.edge_id);
  add_listed(9, mesh.ridges, part.edge_id);
  return all;
}

std::vector<std::uint8_t> left_half(const TetMesh& mesh) {
  std::vector<std::uint8_t> marked;
  for (const auto& tet : mesh.tets) {
    double x = 0;
    for (const Index v : tet) x += mesh.points[static_cast<std::size_t>(v)][0];
    marked.push_back(x < 2 ? 1 : 0);
  }
  return marked;
}

TEST(Part, TakenOutAndPutBackIsTheSame) {
  Part part = make();
  const auto before = contents(part);
  const auto marked = left_half(part.mesh);
  const Part out = extract(part, marked);
  const auto taken = static_cast<std::size_t>(std::accumulate(marked.begin(), marked.end(), 0));
  EXPECT_EQ(out.mesh.tets.size(), taken);
  EXPECT_EQ(part.mesh.tets.size(), marked.size() - taken);
  merge(part, out);
  EXPECT_EQ(contents(part), before);
}

TEST(Part, CopiedIsWhatWouldBeTakenOut) {
  Part part = make();
  const auto before = contents(part);
  const auto marked = left_half(part.mesh);
  const auto copy = contents(copied(part, marked));
  EXPECT_EQ(contents(part), before);
  EXPECT_EQ(copy, contents(extract(part, marked)));
}

TEST(Part, HeldAreTheSurfaceListsAndFrozenRegions) {
  Part part = make();
  TetMesh& mesh = part.mesh;
  mesh.triangles.clear();
  mesh.edges.resize(1);
  mesh.corners = {60};
  mesh.required_vertices.clear();
  mesh.required_tets.clear();
  std::vector<std::uint8_t> expected = on_surface(mesh);
  for (const Index v : {mesh.edges[0][0], mesh.edges[0][1], Index{60}}) expected[static_cast<std::size_t>(v)] = 1;
  EXPECT_EQ(held_vertices(mesh, {}), expected);
  const int region = mesh.tet_tags.front();
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (mesh.tet_tags[t] != region) continue;
    for (const Index v : mesh.tets[t]) expected[static_cast<std::size_t>(v)] = 1;
  }
  EXPECT_EQ(held_vertices(mesh, {region}), expected);
  std::vector<std::uint8_t> one(mesh.points.size(), 0);
  one[static_cast<std::size_t>(mesh.tets[5][2])] = 1;
  const auto around = tets_at(mesh.tets, one);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& tet = mesh.tets[t];
    EXPECT_EQ(around[t] != 0, std::find(tet.begin(), tet.end(), mesh.tets[5][2]) != tet.end());
  }
}

TEST(Part, ListedEntitiesGoWithTheirTetrahedra) {
  Part part = make();
  const Part out = extract(part, left_half(part.mesh));
  for (const Part* p : {&std::as_const(part), &out}) {
    const auto own = faces(p->mesh);
    EXPECT_EQ(p->mesh.triangles.size(), own.size());  // all faces were listed
    for (const auto& face : p->mesh.triangles) EXPECT_EQ(own.count(ascending(face)), 1U);
    for (const std::uint8_t is_in : are_in(p->mesh.edges, p->mesh.tets, p->mesh.points.size())) EXPECT_EQ(is_in, 1);
  }
}

TEST(Part, WhatIsOfNoTetrahedronStays) {
  Part part = make();
  const std::size_t triangles = part.mesh.triangles.size();
  const Part out = extract(part, std::vector<std::uint8_t>(part.mesh.tets.size(), 1));
  EXPECT_EQ(out.mesh.triangles.size(), triangles);
  EXPECT_TRUE(part.mesh.points.empty());
  Part lone = make();
  lone.mesh.tets = {lone.mesh.tets[0]};
  lone.mesh.tet_tags.resize(1);
  lone.mesh.required_tets.clear();
  lone.tet_id.resize(1);
  const std::size_t vertices = lone.mesh.points.size();
  EXPECT_EQ(extract(lone, {1}).mesh.points.size(), 4U);
  EXPECT_EQ(lone.mesh.points.size(), vertices - 4);
}

TEST(Part, SurfaceAndInterfaceAreFound) {
  const TetMesh mesh = make().mesh;
  std::vector<std::uint8_t> expected(mesh.points.size(), 0);
  for (const auto& [face, tets] : faces(mesh)) {
    if (tets.size() == 1 && tets.begin()->second == 2) continue;
    for (const Index v : face) expected[static_cast<std::size_t>(v)] = 1;
  }
  EXPECT_EQ(on_surface(mesh), expected);
  EXPECT_GT(std::count(expected.begin(), expected.end(), 0), 0);
}

/// Edges of the second mesh that the first lacks.
std::vector<std::array<Index, 2>> edges_only_in(const TetMesh& second, const TetMesh& first) {
  const auto had = test::edges_of(first);
  std::vector<std::array<Index, 2>> edges;
  for (const auto& edge : test::edges_of(second)) {
    if (!had.contains(edge)) edges.push_back(edge);
  }
  return edges;
}

TEST(Part, HasNoIdsOfListsThatAreLeftEmpty) {
  Part part;
  part.mesh = test::cube(5, 0.2);
  part.vertex_id.resize(part.mesh.points.size());
  part.tet_id.resize(part.mesh.tets.size());
  part.vertex_flags.resize(part.mesh.points.size());
  std::iota(part.vertex_id.begin(), part.vertex_id.end(), 0);
  std::iota(part.tet_id.begin(), part.tet_id.end(), 0);
  const Marks frozen(part.mesh.points.size(), 0);
  Part optimized = part;
  optimize_part(optimized, frozen, Options(), Context(), nullptr);
  part.mesh.edges = edges_only_in(part.mesh, optimized.mesh);
  ASSERT_FALSE(part.mesh.edges.empty());
  part.mesh.edge_tags.assign(part.mesh.edges.size(), 0);
  part.edge_id.resize(part.mesh.edges.size());
  std::iota(part.edge_id.begin(), part.edge_id.end(), 0);
  // A triangle inside: a face, with an edge that goes.
  const std::vector<std::uint8_t> is_outside = on_surface(part.mesh);
  for (const auto& [a, b] : part.mesh.edges) {
    for (const auto& tet : part.mesh.tets) {
      const std::set<Index> vertices(tet.begin(), tet.end());
      if (!vertices.contains(a) || !vertices.contains(b)) continue;
      for (const Index v : tet) {
        if (v != a && v != b && is_outside[static_cast<std::size_t>(v)] == 0) part.mesh.triangles = {{a, b, v}};
      }
    }
  }
  ASSERT_FALSE(part.mesh.triangles.empty());
  part.mesh.triangle_tags = {0};
  part.triangle_id = {0};
  optimize_part(part, frozen, Options(), Context(), nullptr);
  EXPECT_TRUE(part.mesh.edges.empty());
  EXPECT_TRUE(part.edge_id.empty());
  EXPECT_TRUE(part.mesh.triangles.empty());
  EXPECT_TRUE(part.triangle_id.empty());
}

TEST(Part, DefectsHaveTheIdsOfTheWholeMesh) {
  const MeshError other("another reason");
  const MessageForm form{true, "repair them"};
  Part part = make();
  EXPECT_EQ(defects_of(part, 1, form, other), "another reason");
  std::swap(part.mesh.tets[3][0], part.mesh.tets[3][1]);
  std::swap(part.mesh.tets[8][0], part.mesh.tets[8][1]);
  part.tet_id[8] = 71;
  EXPECT_NE(defects_of(part, 1, form, other).find("(first, counted from 1: 12, 72)"), std::string::npos);
  part.tet_id[3] = (Id{1} << 32) + 11;  // a message has no room for it
  EXPECT_NE(defects_of(part, 1, form, other).find("(first, counted from 1: 72)"), std::string::npos);
}

TEST(Part, IdsAreNumberedAsTheyCome) {
  IdMap map;
  for (Id i = 0; i < 1000; ++i) EXPECT_TRUE(map.add((i << 33) + 5));
  for (Id i = 0; i < 1000; ++i) {
    EXPECT_FALSE(map.add((i << 33) + 5));
    EXPECT_EQ(map[(i << 33) + 5], i);
  }
  EXPECT_EQ(map[6], -1);
}

}  // namespace
}  // namespace tetune::mpi
