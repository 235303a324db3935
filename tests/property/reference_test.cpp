// SPDX-License-Identifier: Apache-2.0
// Compares the parallel method with the sequential baseline.
#include <gtest/gtest.h>

#include "reference/alexa.hpp"
#include "support/meshes.hpp"
#include "tetune/io.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

TEST(OrderedFlips, ProduceAValidMeshOfTheReportedEnergy) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    TetMesh m = test::sheared(test::scrambled(test::two_materials(6, 0.15), 3, seed), seed == 2 ? 2.5 : 0);
    const double before = quality(m).eta_sum;
    const double volume = quality(m).volume;
    const reference::FlipResult r = reference::flip_in_order(m);
    EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
    EXPECT_NEAR(quality(m).eta_sum, before - r.decrease, 1e-9 * before);
    EXPECT_NEAR(quality(m).volume, volume, 1e-12);
    EXPECT_GT(r.flips23 + r.flips32, 100);
    // Neither method finds another flip.
    EXPECT_EQ(reference::flip_in_order(m).flips32, 0);
    Options options;
    options.max_iterations = 0;
    options.energy = Energy::harmonic;
    options.max_ring = 3;
    const Report ours = optimize(m, options);
    EXPECT_EQ(ours.flips23 + ours.flips32, 0);
  }
}

TEST(OrderedFlips, EndCloseToTheParallelFlips) {
  TetMesh sequential = read_mesh(TETUNE_DATA "/bracket.meshb");
  TetMesh parallel = sequential;
  reference::flip_in_order(sequential);
  Options options;
  options.max_iterations = 0;
  options.energy = Energy::harmonic;
  options.max_ring = 3;
  optimize(parallel, options);
  const auto difference = static_cast<double>(sequential.tets.size()) - static_cast<double>(parallel.tets.size());
  EXPECT_LT(std::fabs(difference), 0.005 * static_cast<double>(parallel.tets.size()));
  EXPECT_NEAR(quality(sequential).eta_sum, quality(parallel).eta_sum, 0.005 * quality(parallel).eta_sum);
}

TEST(Alexa, StaysOnTheSurfaceAndEndsAboveTheEnergyOfOptimize) {
  const TetMesh before = test::scrambled(test::cube(6, 0.2), 2);
  const auto run = [&before](reference::AlexaEnd end) {
    TetMesh mesh = before;
    const reference::AlexaReport r = reference::optimize(mesh, end);
    // Whether the last flips end depends on rounding.
    EXPECT_TRUE(r.finished || (end == reference::AlexaEnd::descended && r.iterations.size() == 1000));
    EXPECT_TRUE(validate(mesh).ok());
    EXPECT_LT(r.energy_after, r.energy_before);
    EXPECT_NEAR(r.energy_after, quality(mesh).eta_sum, 1e-9 * r.energy_after);
    EXPECT_LT(compare(before, mesh).vertices_to_old, 1e-12);
    return r;
  };
  const reference::AlexaReport first = run(reference::AlexaEnd::no_flips);
  const reference::AlexaReport converged = run(reference::AlexaEnd::descended);
  EXPECT_GT(converged.iterations.size(), first.iterations.size());
  EXPECT_LT(converged.energy_after, first.energy_after);
  TetMesh ours = before;
  Options options;
  options.energy = Energy::harmonic;
  EXPECT_LT(optimize(ours, options).energy_after, first.energy_after);
}

// On a curved surface projection can make a tetrahedron nearly flat, which would prevent every later step.
TEST(Alexa, DoesNotLowerTheWorstQuality) {
  const TetMesh before = read_mesh(TETUNE_DATA "/bracket.meshb");
  TetMesh after = before;
  const reference::AlexaReport r = reference::optimize(after);
  EXPECT_TRUE(r.finished);
  EXPECT_TRUE(validate(after).ok());
  EXPECT_LT(compare(before, after).vertices_to_old, 1e-12);
  EXPECT_LE(quality(after).eta_max, quality(before).eta_max);
}

}  // namespace
}  // namespace tetune
