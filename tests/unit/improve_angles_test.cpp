// SPDX-License-Identifier: Apache-2.0
// Which rounds on the mean energy and the angles follow, and on which tetrahedra.
#include "phases/improve_angles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "backend/cpu.hpp"
#include "driver/import_mesh.hpp"
#include "phases/lower_mean_energy.hpp"
#include "support/meshes.hpp"

namespace tetune {
namespace {

using backend::Cpu;

/// The optimizer of a mesh under Effort::best, with its energies.
struct OptimizerOfMesh {
  explicit OptimizerOfMesh(const TetMesh& mesh) {
    import_mesh(backend, ImportInput{mesh, options}, set, report);
    optimizer.sum_energy(kShapeObjective);
  }

  static Options best() {
    Options options;
    options.effort = Effort::best;
    return options;
  }

  const Options options = best();
  const Cpu backend{1};
  WorkingSet<Cpu> set;
  Report report;
  PhaseTimer timer{report};
  const Context context;
  Optimizer<Cpu> optimizer{backend, set, options, context, timer};
};

bool has_many_tied(const TetMesh& mesh) {
  OptimizerOfMesh work(mesh);
  const AngleParameters& p = work.optimizer.tuning.angles;
  const AngleExtremes<Cpu> extremes(work.backend, work.set.mesh, work.optimizer.slot_energies(), p.min_cost,
                                    p.obtuse_weight);
  return improve_angles_detail::has_many_tied(work.optimizer, extremes);
}

/// A lattice of n^3 cubes whose height is scaled: its smallest angles are all equal.
TetMesh flattened(int n, double scale) {
  TetMesh mesh = test::cube(n);
  for (Point3& p : mesh.points) p[2] *= scale;
  return mesh;
}

TEST(ImproveAngles, ManyEquallyBadElementsAreTied) { EXPECT_TRUE(has_many_tied(flattened(4, 0.5))); }

TEST(ImproveAngles, ElementsBelowTheTiedCostAreNotCounted) { EXPECT_FALSE(has_many_tied(flattened(4, 0.95))); }

TEST(ImproveAngles, FewerElementsAreNotMany) {
  // 48 tetrahedra in all.
  EXPECT_FALSE(has_many_tied(flattened(2, 0.5)));
}

TEST(ImproveAngles, ElementsNearAWorseOneAreNotTied) {
  TetMesh mesh = flattened(4, 0.5);
  // The vertex in the middle, nearer to the layer below: some tetrahedra there become much flatter.
  for (Point3& p : mesh.points) {
    if (p[0] == 0.5 && p[1] == 0.5 && p[2] == 0.25) p[2] -= 0.08;
  }
  EXPECT_FALSE(has_many_tied(mesh));
}

std::vector<double> costs_of(const AngleExtremes<Cpu>& extremes) {
  const Span<const double> costs = extremes.costs();
  return {costs.data(), costs.data() + costs.size()};
}

TEST(AngleExtremes, AnUpdateGivesTheCostsOfANewComputation) {
  OptimizerOfMesh work(test::cube(5, 0.2));
  WorkMesh<Cpu>& mesh = work.set.mesh;
  const auto compute = [&] { return AngleExtremes<Cpu>(work.backend, mesh, work.optimizer.slot_energies(), 1.2, 1.5); };
  AngleExtremes<Cpu> extremes = compute();
  // A vertex moves next to another one, and a slot becomes free.
  const Tet tet = mesh.tet2vertex.span()[40];
  mesh.points.span()[tet[0]].x += 0.9 * (mesh.points.span()[tet[1]].x - mesh.points.span()[tet[0]].x);
  std::vector<Index> moved;
  for (Size t = 0; t < mesh.slots(); ++t) {
    const Tet other = mesh.tet2vertex.span()[t];
    for (int k = 0; k < 4; ++k) {
      if (other[k] == tet[0]) moved.push_back(static_cast<Index>(t));
    }
  }
  work.optimizer.sum_energy(kShapeObjective);
  const std::vector<double> before = costs_of(extremes);
  const auto worst = std::max_element(before.begin(), before.end()) - before.begin();
  work.set.flips.energies.span()[worst] = 0;
  const double largest = extremes.largest();
  extremes.update(work.backend, mesh, work.optimizer.slot_energies(), {moved.data(), static_cast<Size>(moved.size())});
  EXPECT_NE(extremes.largest(), largest);
  const AngleExtremes<Cpu> expected = compute();
  EXPECT_EQ(extremes.largest(), expected.largest());
  EXPECT_EQ(costs_of(extremes), costs_of(expected));
  EXPECT_EQ(extremes.costs()[worst], 0);
}

TEST(AngleExtremes, HaveAQuantileThatAboutANumberOfThemExceed) {
  OptimizerOfMesh work(test::cube(5, 0.2));
  const AngleExtremes<Cpu> extremes(work.backend, work.set.mesh, work.optimizer.slot_energies(), 1.2, 1.5);
  const std::vector<double> costs = costs_of(extremes);
  const auto above = [&](double cost) {
    return std::count_if(costs.begin(), costs.end(), [=](double c) { return c > cost; });
  };
  constexpr double kResolution = 1e-6;
  for (const int count : {1, 10, 100}) {
    const double cost = extremes.quantile(work.backend, count, kResolution);
    EXPECT_GT(above(cost), count);
    EXPECT_LE(above((1 + 2 * kResolution) * cost), count);
  }
  EXPECT_EQ(extremes.count_above(work.backend, 1.3), above(1.3));
  EXPECT_EQ(extremes.quantile(work.backend, 1e6, kResolution), 1.2);
  EXPECT_NEAR(extremes.quantile(work.backend, 0, kResolution), extremes.largest(), 1e-4);
}

TEST(NewNeighborhoods, AreThoseOfTheVerticesOfNewTetrahedra) {
  OptimizerOfMesh work(test::cube(4, 0.2));
  lower_mean_energy_detail::NewNeighborhoods<Cpu> neighborhoods;
  const auto find = [&] { return neighborhoods.find_above(work.optimizer, 0).download(); };
  const MeshView mesh = work.set.mesh.view();
  const Size slots = mesh.tet2vertex.size();
  EXPECT_EQ(std::ssize(find()), slots);
  EXPECT_TRUE(find().empty());
  // Positions alone.
  work.set.mesh.points.span()[0].x += 1e-3;
  EXPECT_TRUE(find().empty());
  // Another order of the same vertices stands for another tetrahedron.
  Tet& changed = work.set.mesh.tet2vertex.span()[7];
  std::swap(changed[2], changed[3]);
  const std::vector<Index> found = find();
  std::vector<Index> expected;
  for (Index t = 0; t < slots; ++t) {
    const Tet tet = mesh.tet2vertex[t];
    bool shares = false;
    for (int k = 0; k < 4; ++k) {
      for (int l = 0; l < 4; ++l) shares = shares || tet[k] == changed[l];
    }
    if (shares) expected.push_back(t);
  }
  EXPECT_EQ(found, expected);
  EXPECT_LT(std::ssize(found), slots);
  EXPECT_TRUE(find().empty());
}

TEST(LowerMeanEnergy, RemovesAsManyVerticesAsItMay) {
  const auto removed = [](Size removable) {
    TetMesh flat = test::cube(6, 0.1);
    for (Point3& p : flat.points) p[2] *= 0.02;
    OptimizerOfMesh work(std::move(flat));
    work.report.vertices = work.set.mesh.vertices();
    work.set.removable = removable;
    const MeanParameters& p = work.optimizer.tuning.mean;
    EXPECT_TRUE(lower_mean_energy(work.optimizer, p, {kShapeObjective, QualityFloor::none()}));
    const std::int64_t net = work.report.vertices_removed - work.report.vertices_inserted;
    EXPECT_EQ(work.set.removable, removable - net);
    EXPECT_GT(work.report.worst_rounds.size(), 0U);
    return net;
  };
  EXPECT_GT(removed(1000), 2);
  EXPECT_LE(removed(2), 2);
  EXPECT_LE(removed(0), 0);
}

TEST(LowerMeanEnergy, ARootIsLoweredWhereAFewTetrahedraMakeUpTheMean) {
  const auto log2_power = [](double height) {
    OptimizerOfMesh work(flattened(4, height));
    return mean_objective(work.optimizer).log2_power;
  };
  EXPECT_EQ(log2_power(0.5), 0);
  EXPECT_EQ(log2_power(1e-3), MeanParameters::kLog2Root);
}

}  // namespace
}  // namespace tetune
