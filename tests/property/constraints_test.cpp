// SPDX-License-Identifier: Apache-2.0
// Entities that the lists and tags of a mesh constrain stay, with any boundary and effort.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "backend/span.hpp"
#include "support/constrained.hpp"
#include "support/energy_watch.hpp"
#include "support/meshes.hpp"
#include "support/sanitized.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

struct ConstrainedCase {
  std::uint32_t seed;
  Boundary boundary;
  Relocation relocation;
  Termination termination;
};

class OptimizeProperties : public testing::TestWithParam<ConstrainedCase> {};

TEST_P(OptimizeProperties, KeepWhatMustBeKept) {
  const ConstrainedCase c = GetParam();
  const TetMesh before = test::varied(c.seed);
  ASSERT_TRUE(validate(before).ok());
  TetMesh after = before;
  Options options;
  options.boundary = c.boundary;
  options.relocation = c.relocation;
  options.termination = c.termination;
  options.max_ring = 3 + static_cast<int>(c.seed % 5);
  options.max_iterations = 12;
  options.energy = c.seed % 2 == 0 ? Energy::shape : Energy::harmonic;
  const auto energy = [&options](const TetMesh& m) {
    const Quality q = quality(m);
    return options.energy == Energy::shape ? q.shape_sum : q.eta_sum;
  };
  const Report report = optimize(after, options, test::energy_watch());

  const ValidationReport valid = validate(after);
  EXPECT_TRUE(valid.ok()) << valid.message(false);
  EXPECT_LT(report.energy_after, report.energy_before);
  if (options.energy == Energy::shape) {
    EXPECT_GE(quality(after).dihedral_min, quality(before).dihedral_min - 1e-9);
  }
  EXPECT_NEAR(report.energy_after, energy(after), 1e-9 * report.energy_after);
  EXPECT_NEAR(report.energy_before, energy(before), 1e-9 * report.energy_before);
  EXPECT_EQ(static_cast<std::int64_t>(after.tets.size()), report.tets_after);
  const std::int64_t without_removals = report.tets_before + report.flips23 - report.flips32;
  // A compound flip has at most 48 tetrahedra before and 64 afterwards.
  EXPECT_GE(report.tets_after, without_removals - 3 * report.face_removals - 48 * report.compound_flips);
  EXPECT_LE(report.tets_after,
            without_removals + 3 * report.edge_removals + 8 * report.boundary_flips + 64 * report.compound_flips);

  const Comparison change = compare(before, after);
  EXPECT_LT(change.new_to_old, 1e-12);
  EXPECT_LT(change.old_to_new, 1e-12);
  EXPECT_LT(std::abs(change.area_change), 1e-12);
  EXPECT_LT(change.region_volume_change, 1e-12);
  EXPECT_EQ(change.required_moved, 0);
  EXPECT_TRUE(change.vertex_tags_kept && change.tet_tags_kept && change.triangle_tags_kept && change.edge_tags_kept);

  EXPECT_EQ(test::tets_with(before, before.required_tets), test::tets_with(after, after.required_tets));
  for (const auto& t : test::tets_with(before, before.required_tets)) {
    for (const Index v : t)
      EXPECT_EQ(before.points[static_cast<std::size_t>(v)], after.points[static_cast<std::size_t>(v)]);
  }
  EXPECT_EQ(test::tagged(before.triangles, before.triangle_tags), test::tagged(after.triangles, after.triangle_tags));
  EXPECT_EQ(test::tagged(before.edges, before.edge_tags), test::tagged(after.edges, after.edge_tags));
  test::expect_present(after);
}

/// For messages of the test framework.
void PrintTo(const ConstrainedCase& c, std::ostream* out) { *out << "seed " << c.seed; }

std::vector<ConstrainedCase> constrained_cases() {
  std::vector<ConstrainedCase> all;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    all.push_back({seed, Boundary::preserve, Relocation::newton, Termination::relative});
    all.push_back({seed, Boundary::preserve, Relocation::gradient, Termination::paper});
    all.push_back({seed, Boundary::fixed, Relocation::newton, Termination::paper});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Seeds, OptimizeProperties, testing::ValuesIn(constrained_cases()), [](const auto& test) {
  const ConstrainedCase& c = test.param;
  return "Seed" + std::to_string(c.seed) + (c.boundary == Boundary::fixed ? "Fixed" : "Preserve") +
         (c.relocation == Relocation::newton ? "Newton" : "Gradient") +
         (c.termination == Termination::paper ? "Paper" : "Relative");
});

/// With the ids of the input in the place of those of the result.
TetMesh under_old_ids(TetMesh m, const Report& report) {
  if (report.vertex2original.empty()) return m;
  EXPECT_EQ(report.vertex2original.size(), m.points.size());
  const auto old = [&report](Index& v) { v = report.vertex2original[static_cast<std::size_t>(v)]; };
  for (auto& t : m.tets) std::for_each(t.begin(), t.end(), old);
  for (auto& t : m.triangles) std::for_each(t.begin(), t.end(), old);
  for (auto& e : m.edges) std::for_each(e.begin(), e.end(), old);
  std::for_each(m.required_vertices.begin(), m.required_vertices.end(), old);
  return m;
}

TEST(Optimize, BestKeepsWhatMustBeKept) {
  std::int64_t inserted = 0;
  std::int64_t removed = 0;
  for (std::uint32_t seed = 1; seed <= 17; ++seed) {
    SCOPED_TRACE(seed);
    // Where there are many vertices some are best removed.
    const TetMesh before =
        seed <= 16 ? test::varied(seed) : test::scrambled(test::cube(test::kSanitized ? 12 : 18, 0.22), 3);
    TetMesh after = before;
    Options options;
    options.effort = Effort::best;
    options.surface_vertices = SurfaceVertices::keep;  // the triangles below are known by their ids
    options.boundary = seed % 4 == 0 ? Boundary::fixed : seed % 4 == 1 ? Boundary::slide : Boundary::preserve;
    options.boundary_flips = seed % 3 == 0;  // they leave less to do
    const Report report = optimize(after, options);
    inserted += report.vertices_inserted;
    removed += report.vertices_removed;

    const ValidationReport valid = validate(after);
    EXPECT_TRUE(valid.ok()) << valid.message(false);
    const Quality now = quality(after);
    EXPECT_GE(now.dihedral_min, quality(before).dihedral_min - 1e-9);
    EXPECT_NEAR(report.energy_after, now.shape_sum, 1e-9 * now.shape_sum);
    EXPECT_LE(static_cast<double>(after.tets.size()), 1.1 * static_cast<double>(before.tets.size()));
    EXPECT_EQ(static_cast<std::int64_t>(after.points.size()),
              static_cast<std::int64_t>(before.points.size()) + report.vertices_inserted - report.vertices_removed);
    EXPECT_EQ(after.point_tags.size(), after.points.size());

    // Those of the input come first and in their order, and keep their tags; all others are new, with a tag that
    // several vertices of the input have, or none.
    Index last = -1;
    for (std::size_t v = 0; v < report.vertex2original.size(); ++v) {
      const Index original = report.vertex2original[v];
      const bool is_new = v >= after.points.size() - static_cast<std::size_t>(report.vertices_inserted);
      if (original < 0) {
        const int tag = after.point_tags[v];
        EXPECT_TRUE(tag == 0 || std::count(before.point_tags.begin(), before.point_tags.end(), tag) > 1) << tag;
        continue;
      }
      EXPECT_FALSE(is_new && report.vertices_removed == 0);
      EXPECT_GT(original, last);
      last = original;
      EXPECT_EQ(after.point_tags[v], before.point_tags[static_cast<std::size_t>(original)]);
    }

    if (options.boundary != Boundary::slide) {
      const Comparison change = compare(before, after);
      EXPECT_LT(change.new_to_old, 1e-12);
      EXPECT_LT(change.old_to_new, 1e-12);
      EXPECT_LT(change.region_volume_change, 1e-12);
      EXPECT_EQ(change.required_moved, 0);
      EXPECT_TRUE(change.tet_tags_kept && change.triangle_tags_kept && change.edge_tags_kept);
    }
    test::expect_present(after);
    const TetMesh old = under_old_ids(after, report);
    EXPECT_EQ(old.required_vertices, before.required_vertices);
    EXPECT_EQ(test::tets_with(before, before.required_tets), test::tets_with(old, old.required_tets));
    EXPECT_EQ(test::tagged(before.triangles, before.triangle_tags), test::tagged(old.triangles, old.triangle_tags));
    EXPECT_EQ(test::tagged(before.edges, before.edge_tags), test::tagged(old.edges, old.edge_tags));
  }
  EXPECT_GT(inserted, 10);
  EXPECT_GT(removed, 0);
}

/// Lines of different tags along one straight edge of a cube keep their lengths.
void expect_lines_keep_extents(const std::vector<Group>& groups) {
  constexpr int n = 6;
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    for (const Effort effort : {Effort::standard, Effort::best}) {
      TetMesh mesh = test::cube(n, 0.2);
      std::vector<std::pair<double, Index>> along;
      for (Index v = 0; v < std::ssize(mesh.points); ++v) {
        const Point3& p = mesh.points[to_size_t(v)];
        if (p[1] == 0 && p[2] == 0) along.emplace_back(p[0], v);
      }
      ASSERT_EQ(along.size(), std::size_t{n} + 1);
      std::sort(along.begin(), along.end());
      for (std::size_t i = 0; i < n; ++i) {
        mesh.edges.push_back({along[i].second, along[i + 1].second});
        mesh.edge_tags.push_back(i < 2 ? 1 : i < 4 ? 2 : 0);
      }
      mesh.groups = groups;
      Options options;
      options.boundary = boundary;
      options.effort = effort;
      const auto length = [&](int tag) {
        double sum = 0;
        for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
          if (mesh.edge_tags[e] != tag) continue;
          const auto& [a, b] = mesh.edges[e];
          sum += std::fabs(mesh.points[to_size_t(a)][0] - mesh.points[to_size_t(b)][0]);
        }
        return sum;
      };
      const double first = length(1), second = length(2);
      const Report report = optimize(mesh, options);
      EXPECT_EQ(report.corners_not_held, 0);
      EXPECT_EQ(report.line_ends_not_held, 0);
      EXPECT_NEAR(length(1), first, 1e-12);
      EXPECT_NEAR(length(2), second, 1e-12);
    }
  }
}

TEST(Optimize, NamedLinesKeepTheirExtents) {
  expect_lines_keep_extents({{1, 1, "inlet", {1}}, {1, 2, "support", {2}}});
}
TEST(Optimize, TaggedLinesKeepTheirExtents) { expect_lines_keep_extents({}); }

TEST(Optimize, BestKeepsTheEndsOfTaggedEdgesHoweverManyThereAre) {
  // Too many to be feature lines, so that their vertices may move; the edges stay all the same.
  TetMesh mesh = test::scrambled(test::cube(18, 0.22), 3);
  std::set<std::array<Index, 2>> edges;
  for (std::size_t t = 0; t < mesh.tets.size(); t += 8) {
    edges.insert(ascending(mesh.tets[t][0], mesh.tets[t][1]));
  }
  mesh.edges.assign(edges.begin(), edges.end());
  mesh.edge_tags.assign(edges.size(), 1);
  Options options;
  options.effort = Effort::best;
  const Report report = optimize(mesh, options);
  EXPECT_EQ(report.edges_not_held, static_cast<std::int64_t>(edges.size()));
  EXPECT_GT(report.vertices_removed, 0);
  const ValidationReport valid = validate(mesh);
  EXPECT_TRUE(valid.ok()) << valid.message(false);
  EXPECT_EQ(mesh.edges.size(), edges.size());
  test::expect_present(mesh);
}

}  // namespace
}  // namespace tetune
