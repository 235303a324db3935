// SPDX-License-Identifier: Apache-2.0
// What must hold of every optimisation, over many meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>
#include <set>
#include <string>

#include "allocation_watch.hpp"
#include "core/types.hpp"
#include "curved.hpp"
#include "meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

struct Case {
  std::uint32_t seed;
  Boundary boundary;
  Relocation relocation;
  Termination termination;
};

/// Materials, tagged patches, lines, frozen parts: a bit of everything, at random.
TetMesh varied(std::uint32_t seed) {
  std::mt19937 random(seed);
  const int n = 3 + static_cast<int>(random() % 4);
  TetMesh m = test::scrambled(seed % 2 == 0 ? test::two_materials(n + n % 2, 0.15) : test::cube(n, 0.2, seed), 2, seed);
  // Stretch and shear: affine maps keep all volumes positive.
  const double s = 0.3 + static_cast<double>(random() % 100) / 50;
  for (Point3& p : m.points) p = {p[0] + 0.2 * p[1], s * p[1], p[2] - 0.3 * p[0]};
  for (int& tag : m.point_tags) tag = static_cast<int>(random() % 3);
  for (int i = 0; i < 5; ++i) m.required_vertices.push_back(static_cast<Index>(random() % m.points.size()));
  for (int i = 0; i < 3; ++i) m.required_tets.push_back(static_cast<Index>(random() % m.tets.size()));
  for (int i = 0; i < 10; ++i) {
    const auto& t = m.tets[random() % m.tets.size()];
    m.triangles.push_back({t[0], t[1], t[2]});
    m.triangle_tags.push_back(static_cast<int>(random() % 3));
    m.edges.push_back({t[1], t[3]});
    m.edge_tags.push_back(static_cast<int>(random() % 3));
  }
  return m;
}

std::set<std::array<Index, 4>> as_set(const TetMesh& m, const std::vector<Index>& ids) {
  std::set<std::array<Index, 4>> set;
  for (const Index id : ids) {
    auto t = m.tets[static_cast<std::size_t>(id)];
    std::sort(t.begin(), t.end());
    set.insert(t);
  }
  return set;
}

template <std::size_t N>
std::set<std::array<Index, N>> tagged(const std::vector<std::array<Index, N>>& items, const std::vector<int>& tags) {
  std::set<std::array<Index, N>> set;
  for (std::size_t i = 0; i < items.size(); ++i) {
    auto v = items[i];
    std::sort(v.begin(), v.end());
    if (tags[i] != 0) set.insert(v);
  }
  return set;
}

/// Each tagged face and edge is one of the mesh.
void expect_present(const TetMesh& m) {
  std::set<std::array<Index, 3>> faces;
  std::set<std::array<Index, 2>> edges;
  for (auto t : m.tets) {
    std::sort(t.begin(), t.end());
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::array<Index, 3> f{};
      for (std::size_t k = 0, at = 0; k < 4; ++k) {
        if (k != skip) f[at++] = t[k];
      }
      faces.insert(f);
      for (std::size_t k = skip + 1; k < 4; ++k) edges.insert({t[skip], t[k]});
    }
  }
  for (const auto& f : tagged(m.triangles, m.triangle_tags)) EXPECT_TRUE(faces.count(f) == 1);
  for (const auto& e : tagged(m.edges, m.edge_tags)) EXPECT_TRUE(edges.count(e) == 1);
}

class OptimizeProperties : public testing::TestWithParam<Case> {};

TEST_P(OptimizeProperties, KeepWhatMustBeKept) {
  const Case c = GetParam();
  const TetMesh before = varied(c.seed);
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
  double last = 1e300;
  Context context;
  context.progress = [&last](const Progress& p) {
    // Work on the few worst gives some of it back.
    const bool on_all = std::string(p.phase) == "sweep" || std::string(p.phase) == "flips";
    EXPECT_LE(p.energy, last * (on_all ? 1 + 1e-12 : 1.02));
    last = p.energy;
    return true;
  };
  const Report report = optimize(after, options, context);

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

  EXPECT_EQ(as_set(before, before.required_tets), as_set(after, after.required_tets));
  for (const auto& t : as_set(before, before.required_tets)) {
    for (const Index v : t)
      EXPECT_EQ(before.points[static_cast<std::size_t>(v)], after.points[static_cast<std::size_t>(v)]);
  }
  EXPECT_EQ(tagged(before.triangles, before.triangle_tags), tagged(after.triangles, after.triangle_tags));
  EXPECT_EQ(tagged(before.edges, before.edge_tags), tagged(after.edges, after.edge_tags));
  expect_present(after);
}

/// A cube whose sides are patches 1 to 6, all listed; every third triangle seen from inside.
TetMesh patched(const TetMesh& bare) {
  TetMesh m = bare;
  std::map<std::array<Index, 3>, std::array<Index, 3>> outside;  // by sorted vertices, as seen from outside
  for (const auto& t : m.tets) {
    const std::array<std::array<Index, 3>, 4> faces{
        {{t[1], t[2], t[3]}, {t[0], t[3], t[2]}, {t[0], t[1], t[3]}, {t[0], t[2], t[1]}}};
    for (const auto& f : faces) {
      auto key = f;
      std::sort(key.begin(), key.end());
      if (!outside.emplace(key, f).second) outside.erase(key);
    }
  }
  for (const auto& [key, face] : outside) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (const double side : {0.0, 1.0}) {
        const bool on = std::all_of(face.begin(), face.end(),
                                    [&](Index v) { return m.points[static_cast<std::size_t>(v)][k] == side; });
        if (!on) continue;
        m.triangles.push_back(face);
        if (m.triangles.size() % 3 == 0) std::swap(m.triangles.back()[0], m.triangles.back()[1]);
        m.triangle_tags.push_back(static_cast<int>(1 + k) + (side == 1 ? 3 : 0));
      }
    }
  }
  return m;
}

/// Area vector of a triangle, doubled.
Vec3 area2(const TetMesh& m, const std::array<Index, 3>& t) {
  const auto p = [&m](Index v) { return vec(m.points[static_cast<std::size_t>(v)]); };
  return cross(p(t[1]) - p(t[0]), p(t[2]) - p(t[0]));
}

TEST(Optimize, FlipsTheBoundaryWithinItsPatches) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide, Boundary::fixed}) {
    const TetMesh before = patched(test::scrambled(test::cube(8, 0.25), 3, 2));
    ASSERT_EQ(before.triangles.size(), 12U * 64);
    TetMesh after = before;
    Options options;
    options.boundary = boundary;
    const Report report = optimize(after, options);
    EXPECT_TRUE(validate(after).ok());
    expect_present(after);
    EXPECT_EQ(before.triangle_tags, after.triangle_tags);
    ASSERT_EQ(after.triangles.size(), before.triangles.size());
    EXPECT_EQ(patched(after).triangles.size() - after.triangles.size(), before.triangles.size());
    std::set<std::array<Index, 3>> different;
    std::size_t changed = 0;
    std::array<double, 7> area{};
    for (std::size_t i = 0; i < after.triangles.size(); ++i) {
      auto key = after.triangles[i];
      std::sort(key.begin(), key.end());
      different.insert(key);
      changed += after.triangles[i] != before.triangles[i] ? 1 : 0;
      const Vec3 now = area2(after, after.triangles[i]);
      EXPECT_GT(dot(now, area2(before, before.triangles[i])), 0) << i;  // the same side, and still turned as it was
      area[static_cast<std::size_t>(after.triangle_tags[i])] += 0.5 * norm(now);
    }
    EXPECT_EQ(different.size(), after.triangles.size());
    for (std::size_t side = 1; side <= 6; ++side) EXPECT_NEAR(area[side], 1, 1e-12);
    if (boundary == Boundary::fixed) {
      EXPECT_EQ(report.boundary_flips, 0);
      EXPECT_EQ(changed, 0U);
    } else {
      EXPECT_GT(report.boundary_flips, 20);
      EXPECT_GT(changed, 20U);
      std::int64_t flips = 0;
      for (const FlipReport& f : report.flip_passes) flips += f.boundary_flips;
      EXPECT_LE(flips, report.boundary_flips);
      EXPECT_GT(flips, 0);
    }
  }
}

TEST(Optimize, FlipsNoBoundaryWhereThatIsNotWanted) {
  const TetMesh before = patched(test::scrambled(test::cube(6, 0.25), 3, 2));
  const auto triangles_after = [&before](const Options& options) {
    TetMesh after = before;
    EXPECT_EQ(optimize(after, options).boundary_flips, 0);
    return after.triangles;
  };
  Options options;
  options.boundary_flips = false;
  EXPECT_EQ(triangles_after(options), before.triangles);
  options = {};
  options.max_ring = 3;
  EXPECT_EQ(triangles_after(options), before.triangles);
  options = {};
  options.boundary = Boundary::slide;
  options.max_deviation = 0.01;
  EXPECT_EQ(triangles_after(options), before.triangles);
}

TEST(Optimize, BoundaryFlipsAreTheSameForAnyNumberOfThreads) {
  const TetMesh before = patched(test::scrambled(test::cube(10, 0.25), 3, 2));
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    Options options;
    options.boundary = boundary;
    options.threads = 1;
    TetMesh one = before;
    EXPECT_GT(optimize(one, options).boundary_flips, 20);
    for (const int threads : {2, 3}) {
      options.threads = threads;
      TetMesh many = before;
      const Report other = optimize(many, options);
      EXPECT_EQ(one.points, many.points);
      EXPECT_EQ(one.tets, many.tets);
      EXPECT_EQ(one.triangles, many.triangles);
    }
  }
}

/// For messages of the test framework.
void PrintTo(const Case& c, std::ostream* out) { *out << "seed " << c.seed; }

std::vector<Case> cases() {
  std::vector<Case> all;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    all.push_back({seed, Boundary::preserve, Relocation::newton, Termination::relative});
    all.push_back({seed, Boundary::preserve, Relocation::gradient, Termination::paper});
    all.push_back({seed, Boundary::fixed, Relocation::newton, Termination::paper});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Seeds, OptimizeProperties, testing::ValuesIn(cases()), [](const auto& test) {
  const Case& c = test.param;
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
    const TetMesh before = seed <= 16 ? varied(seed) : test::scrambled(test::cube(18, 0.22), 3);
    TetMesh after = before;
    Options options;
    options.effort = Effort::best;
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

    // Those of the input come first and in their order, and keep their tags; all others are new.
    Index last = -1;
    for (std::size_t v = 0; v < report.vertex2original.size(); ++v) {
      const Index original = report.vertex2original[v];
      const bool is_new = v >= after.points.size() - static_cast<std::size_t>(report.vertices_inserted);
      if (original < 0) {
        EXPECT_EQ(after.point_tags[v], 0);
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
    expect_present(after);
    const TetMesh old = under_old_ids(after, report);
    EXPECT_EQ(old.required_vertices, before.required_vertices);
    EXPECT_EQ(as_set(before, before.required_tets), as_set(old, old.required_tets));
    EXPECT_EQ(tagged(before.triangles, before.triangle_tags), tagged(old.triangles, old.triangle_tags));
    EXPECT_EQ(tagged(before.edges, before.edge_tags), tagged(old.edges, old.edge_tags));
  }
  EXPECT_GT(inserted, 10);
  EXPECT_GT(removed, 0);
}

TEST(Optimize, BestKeepsTheEndsOfTaggedEdgesHoweverManyThereAre) {
  // Too many to be feature lines, so that their vertices may move; the edges stay all the same.
  TetMesh mesh = test::scrambled(test::cube(18, 0.22), 3);
  std::set<std::array<Index, 2>> edges;
  for (std::size_t t = 0; t < mesh.tets.size(); t += 8) {
    edges.insert({std::min(mesh.tets[t][0], mesh.tets[t][1]), std::max(mesh.tets[t][0], mesh.tets[t][1])});
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
  expect_present(mesh);
}

TEST(Optimize, BestOpensTheSmallestAngles) {
  const TetMesh before = test::scrambled(test::cube(8, 0.25), 3);
  TetMesh standard = before;
  optimize(standard);
  Options options;
  options.effort = Effort::best;
  TetMesh best = before;
  const Report report = optimize(best, options);
  EXPECT_GT(report.vertices_inserted, 0);
  EXPECT_GT(report.compound_flips, 0);
  options.keep_vertices = true;
  TetMesh kept = before;
  const Report kept_report = optimize(kept, options);
  EXPECT_EQ(kept_report.vertices_inserted + kept_report.vertices_removed, 0);
  EXPECT_TRUE(kept_report.vertex2original.empty());
  EXPECT_EQ(kept.points.size(), before.points.size());
  EXPECT_GT(quality(best).dihedral_min, quality(standard).dihedral_min + 2);
  EXPECT_GT(quality(kept).dihedral_min, quality(standard).dihedral_min);
  EXPECT_GT(quality(best).mean_ratio, quality(standard).mean_ratio - 0.01);
}

/// For each vertex half the mean length of its edges on the boundary; 0 for inner ones.
std::vector<double> half_surface_edges(const TetMesh& mesh) {
  std::vector<double> sum(mesh.points.size(), 0);
  std::vector<int> count(mesh.points.size(), 0);
  for (const auto& face : test::skin(mesh)) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(face.v[k]);
      for (std::size_t other = 0; other < 3; ++other) {
        if (other == k) continue;
        sum[v] += norm(vec(mesh.points[static_cast<std::size_t>(face.v[other])]) - vec(mesh.points[v]));
        ++count[v];
      }
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] = count[v] > 0 ? 0.5 * sum[v] / count[v] : 0;
  return sum;
}

TEST(Optimize, TheSurfaceKeepsItsSizes) {
  TetMesh before = test::cube(8, 0.2);
  for (auto& p : before.points) p[2] *= 0.02;
  const std::vector<double> half = half_surface_edges(before);
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    for (const Relocation relocation : {Relocation::newton, Relocation::gradient}) {
      const double part = boundary == Boundary::slide ? 1.5 : 1;
      for (const Energy energy : {Energy::shape, Energy::harmonic}) {
        TetMesh after = before;
        Options options;
        options.boundary = boundary;
        options.relocation = relocation;
        options.energy = energy;
        if (energy == Energy::shape) options.effort = Effort::fast;
        optimize(after, options);
        double most = 0;
        for (std::size_t v = 0; v < half.size(); ++v) {
          if (half[v] > 0) most = std::max(most, norm(vec(after.points[v]) - vec(before.points[v])) / half[v]);
        }
        if (energy == Energy::shape) {
          EXPECT_LT(most, part * (1 + 1e-9));
          EXPECT_GT(most, 0.9 * part) << "no vertex wanted to go far";
        } else if (relocation == Relocation::newton) {
          EXPECT_GT(most, part) << "the harmonic energy has no leash";
        }
      }
    }
  }
}

TEST(Optimize, InFixedModeNoSurfaceVertexMoves) {
  const TetMesh before = test::cube(5, 0.2);
  TetMesh after = before;
  Options options;
  options.boundary = Boundary::fixed;
  optimize(after, options);
  std::size_t moved = 0;
  for (std::size_t v = 0; v < before.points.size(); ++v) {
    const Point3& p = before.points[v];
    const bool surface = std::any_of(p.begin(), p.end(), [](double x) { return x == 0 || x == 1; });
    if (surface) {
      EXPECT_EQ(p, after.points[v]);
    } else {
      moved += p != after.points[v] ? 1 : 0;
    }
  }
  EXPECT_EQ(moved, 64U);
}

Point3 centroid(const TetMesh& mesh, std::size_t tet) {
  Point3 sum{};
  for (const Index v : mesh.tets[tet]) {
    for (std::size_t k = 0; k < 3; ++k) sum[k] += 0.25 * mesh.points[static_cast<std::size_t>(v)][k];
  }
  return sum;
}

TEST(Optimize, EachTetDescendsFromOneNearByOfItsRegion) {
  for (const Effort effort : {Effort::standard, Effort::best}) {
    const TetMesh before = test::scrambled(test::cube(10, 0.25), 2);
    TetMesh regions = before;
    for (std::size_t t = 0; t < before.tets.size(); ++t) regions.tet_tags[t] = centroid(before, t)[0] < 0.5 ? 3 : 4;
    TetMesh after = regions;
    Options options;
    options.effort = effort;
    const Report report = optimize(after, options);
    ASSERT_EQ(report.tet2original.size(), after.tets.size());
    double far = 0;
    for (std::size_t t = 0; t < after.tets.size(); ++t) {
      const auto original = static_cast<std::size_t>(report.tet2original[t]);
      ASSERT_LT(original, before.tets.size());
      ASSERT_EQ(after.tet_tags[t], regions.tet_tags[original]);
      const Point3 a = centroid(after, t);
      const Point3 b = centroid(before, original);
      far += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }
    EXPECT_LT(far / static_cast<double>(after.tets.size()), 0.1);  // the length of an edge of the lattice
  }
}

TEST(Optimize, IsTheSameForAnyNumberOfThreads) {
  for (const Effort effort : {Effort::standard, Effort::best}) {
    const TetMesh before = effort == Effort::standard ? varied(4) : test::scrambled(test::cube(10, 0.25), 2);
    Options options;
    options.effort = effort;
    options.threads = 1;
    TetMesh one = before;
    const Report report = optimize(one, options);
    EXPECT_EQ(report.vertices_inserted > 0, effort == Effort::best);
    for (const int threads : {2, 3, 8}) {
      options.threads = threads;
      TetMesh many = before;
      const Report other = optimize(many, options);
      EXPECT_EQ(one.points, many.points);
      EXPECT_EQ(one.tets, many.tets);
      EXPECT_EQ(one.tet_tags, many.tet_tags);
      EXPECT_EQ(report.tet2original, other.tet2original);
    }
  }
}

TEST(Optimize, ARescaledMeshGivesTheSameMeshRescaled) {
  for (const double scale : {1000.0, 1e-3, 1e-100, 1e100}) {
    TetMesh plain = test::scrambled(test::cube(8, 0.2), 2);
    TetMesh scaled = plain;
    for (Point3& p : scaled.points) {
      for (double& x : p) x *= scale;
    }
    optimize(plain);
    optimize(scaled);
    EXPECT_EQ(plain.tets, scaled.tets);
    double worst = 0;
    for (std::size_t v = 0; v < plain.points.size(); ++v) {
      for (std::size_t k = 0; k < 3; ++k)
        worst = std::max(worst, std::fabs(scaled.points[v][k] / scale - plain.points[v][k]));
    }
    EXPECT_LT(worst, 1e-9);
  }
}

TEST(Optimize, StopsWhenAskedAndLeavesAValidMesh) {
  TetMesh m = test::cube(6, 0.2);
  Context context;
  int calls = 0;
  context.progress = [&calls](const Progress&) { return ++calls < 4; };
  const Report report = optimize(m, {}, context);
  EXPECT_EQ(report.stop, StopReason::cancelled);
  EXPECT_TRUE(validate(m).ok());
  EXPECT_LT(report.energy_after, report.energy_before);
  EXPECT_NEAR(report.energy_after, quality(m).shape_sum, 1e-9 * report.energy_after);
}

TEST(Optimize, IsValidHoweverEarlyItMustEnd) {
  // Flips after the last sweep must not leave stale rings to the work on the worst elements.
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const TetMesh before = test::scrambled(test::cube(6, 0.3), 3, seed);
    for (int sweeps = 1; sweeps <= 5; ++sweeps) {
      TetMesh after = before;
      Options options;
      options.max_iterations = sweeps;
      const Report report = optimize(after, options);
      EXPECT_TRUE(validate(after).ok()) << validate(after).message(false);
      EXPECT_NEAR(quality(after).volume, quality(before).volume, 1e-12);
      EXPECT_GE(quality(after).dihedral_min, quality(before).dihedral_min - 1e-9);
      EXPECT_LE(static_cast<int>(report.sweeps.size()), sweeps);
    }
  }
}

TEST(Optimize, WithoutIterationsOnlyFlips) {
  const TetMesh before = test::scrambled(test::cube(6, 0.2), 2);
  TetMesh after = before;
  Options options;
  options.max_iterations = 0;
  const Report report = optimize(after, options);
  EXPECT_EQ(before.points, after.points);
  EXPECT_GT(report.flips23 + report.flips32, 0);
  EXPECT_TRUE(report.sweeps.empty());
  EXPECT_TRUE(report.worst_rounds.empty());
}

TEST(Optimize, NewtonAndGradientFindTheSameMinimum) {
  Options options;
  options.max_iterations = 0;
  options.max_ring = 3;                // with more flips to choose from, the two soon differ in connectivity
  options.boundary = Boundary::fixed;  // as surface vertices end on their leashes, by different ways
  TetMesh flipped = test::scrambled(test::cube(5, 0.2), 2);
  optimize(flipped, options);
  TetMesh newton = flipped;
  TetMesh gradient = flipped;
  options.max_iterations = 400;
  options.termination = Termination::paper;  // the default one ends a slow descent too early
  const double a = optimize(newton, options).energy_after;
  options.relocation = Relocation::gradient;
  const double b = optimize(gradient, options).energy_after;
  EXPECT_NEAR(a, b, 2e-3 * a);
}

TEST(Optimize, HandlesTheSmallestMeshes) {
  TetMesh one = test::one_tet();
  EXPECT_EQ(optimize(one).fixed_vertices, 4);
  TetMesh two = test::two_tets(0.3);
  EXPECT_EQ(optimize(two).flips23, 1);
  TetMesh none;
  EXPECT_EQ(optimize(none).tets_after, 0);
  TetMesh points;
  for (int i = 0; i < 100; ++i) points.points.push_back({0.1 * i, std::sin(i), std::cos(3 * i)});
  points.point_tags.assign(points.points.size(), 0);
  const std::vector<Point3> before = points.points;
  EXPECT_EQ(optimize(points).tets_after, 0);
  EXPECT_EQ(points.points, before);
  TetMesh loose = test::one_tet();
  loose.points.push_back({9, 9, 9});
  loose.point_tags.push_back(0);
  optimize(loose);
  EXPECT_EQ(loose.points.back(), (Point3{9, 9, 9}));
}

TEST(Optimize, LeavesTheMeshAsItWasWhereverMemoryRunsOut) {
  if (!test::AllocationWatch::works()) GTEST_SKIP() << "memory never runs out here";
  TetMesh before = test::scrambled(test::cube(2, 0.2), 2);
  before.required_tets = {7};
  for (const auto& t : before.tets) {
    before.triangles.push_back({t[0], t[1], t[2]});
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t l = k + 1; l < 4; ++l) before.edges.push_back({t[k], t[l]});
    }
  }
  before.triangle_tags.resize(before.triangles.size());
  before.edge_tags.resize(before.edges.size());
  Options options;
  options.threads = 1;
  options.max_iterations = 1;
  options.effort = Effort::best;
  TetMesh after = before;
  bool done = false;
  for (std::size_t granted = 0; !done; ++granted) {
    ASSERT_LT(granted, 10000U);
    try {
      const test::AllocationWatch watch(granted);
      optimize(after, options);
      done = true;
    } catch (const std::bad_alloc&) {
      ASSERT_TRUE(after.points == before.points && after.tets == before.tets && after.tet_tags == before.tet_tags &&
                  after.required_tets == before.required_tets && after.triangles == before.triangles &&
                  after.edges == before.edges)
          << granted;
    }
  }
  EXPECT_NE(after.points, before.points);
  EXPECT_NE(after.tets, before.tets);
  EXPECT_LT(after.triangles.size(), before.triangles.size());
  EXPECT_LT(after.edges.size(), before.edges.size());
}

TEST(Optimize, AMeshThatOverlapsItselfKeepsItsFacesOrIsRefused) {
  // A 2-3 flip of the third and the last makes the face of the first a second time.
  TetMesh before;
  before.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {2, 1, 5}};
  before.tets = {{0, 1, 2, 5}, {3, 2, 1, 7}, {5, 1, 4, 7}, {6, 4, 2, 7}, {1, 2, 4, 7}};
  before = test::with_tags(std::move(before));
  orient_uniformly(before);
  ASSERT_TRUE(validate(before).ok()) << validate(before).message(false);
  TetMesh m = before;
  try {
    optimize(m);
    ADD_FAILURE() << "not refused";
  } catch (const OverlapError& e) {
    EXPECT_FALSE(e.tets.empty());
    EXPECT_NE(e.message(true).find("--no-flips"), std::string::npos) << e.message(true);
  }
  EXPECT_EQ(m.tets, before.tets);
  EXPECT_EQ(m.points, before.points);
  Options options;
  options.flips = false;
  options.keep_vertices = true;
  for (const Effort effort : {Effort::fast, Effort::standard, Effort::best}) {
    options.effort = effort;
    m = before;
    optimize(m, options);
    EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
  }
}

TEST(Optimize, RefusesOptionsOutOfRange) {
  TetMesh m = test::one_tet();
  Options options;
  options.max_iterations = -1;
  EXPECT_THROW(optimize(m, options), OptionError);
  options = {};
  options.threads = -2;
  EXPECT_THROW(optimize(m, options), OptionError);
  for (const int ring : {2, 8}) {
    options = {};
    options.max_ring = ring;
    EXPECT_THROW(optimize(m, options), OptionError);
  }
}

}  // namespace
}  // namespace tetune
