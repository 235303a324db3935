// SPDX-License-Identifier: Apache-2.0
// Whole runs on the emulation of the CUDA backend against the CPU: what is left to a GPU is what hardware does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "driver/devices.hpp"
#include "driver/distributed_interface.hpp"
#include "driver/move_job.hpp"
#include "emulation/emulation.hpp"
#include "parity/cases.hpp"
#include "support/curved.hpp"
#include "support/options.hpp"
#include "support/sanitized.hpp"
#include "tetune/error.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using backend::DeviceMemory;
using backend::Emulation;
using test::Case;
using test::expect_parity;
using test::expect_same;

class EmulationAgainstCpu : public testing::TestWithParam<Case> {};

TEST_P(EmulationAgainstCpu, Agrees) {
  const Case& c = GetParam();
  TetMesh cpu = c.mesh;
  const Report on_cpu = optimize(cpu, c.options);
  test::expect_operations(c, on_cpu);
  TetMesh first = c.mesh;
  // In the memory that a GPU would set aside.
  const std::size_t memory = memory_needed_on_device(c.mesh, c.options);
  const Report report = optimize_on(Emulation(1, memory), first, c.options, {});
  EXPECT_TRUE(validate(first).ok()) << validate(first).message(false);
  // Per tetrahedron, as their number may have grown.
  EXPECT_LT(std::min(report.energy_after, on_cpu.energy_after) / double(on_cpu.tets_after),
            on_cpu.energy_before / double(on_cpu.tets_before))
      << "nothing was done";
  expect_parity(report, on_cpu);
  expect_same(first, cpu);
  EXPECT_EQ(report.tets_untangled > 0, c.options.untangle);

  TetMesh second = c.mesh;
  const Report again = optimize_on(Emulation(2), second, c.options, {});
  EXPECT_EQ(again.energy_after, report.energy_after);
  expect_same(first, second);
  // A given surface may be a part of one, in which flat patches are not known.
  const bool keeps_flat_patches = c.options.max_deviation > 0 && c.options.effort != Effort::best;
  if (c.options.boundary != Boundary::slide || keeps_flat_patches) return;
  SlideSurface surface = find_slide_surface(c.mesh, c.options);
  TetMesh given = c.mesh;
  optimize_on(Emulation(3), given, c.options, {}, &surface);
  expect_same(first, given);
}

INSTANTIATE_TEST_SUITE_P(All, EmulationAgainstCpu, testing::ValuesIn(test::cases()),
                         [](const auto& one) { return one.param.name; });

/// The maximum number of bytes that cross between two calls of the progress callback.
DeviceMemory::Traffic most_between_callbacks(const TetMesh& mesh, const Options& options) {
  const Emulation gpu(1);
  DeviceMemory::Traffic most, before;
  bool running = false;
  Context context;
  context.progress = [&](const Progress&) {
    const DeviceMemory::Traffic& now = gpu.device_memory().traffic();
    if (running) {
      most.uploads = std::max(most.uploads, now.uploads - before.uploads);
      most.downloads = std::max(most.downloads, now.downloads - before.downloads);
      most.bytes_down = std::max(most.bytes_down, now.bytes_down - before.bytes_down);
    }
    running = true;
    before = now;
    return true;
  };
  TetMesh m = mesh;
  optimize_on(gpu, m, options, context);
  return most;
}

/// Between two calls of the progress callback nothing is uploaded, and as little downloaded from a mesh of 8000
/// tetrahedra as from a smaller one.
void expect_few_transfers(const Options& options, std::size_t downloads, std::size_t bytes) {
  for (const int n : {6, 12}) {
    const DeviceMemory::Traffic most = most_between_callbacks(test::ball(n), options);
    EXPECT_EQ(most.uploads, 0U);
    EXPECT_LT(most.downloads, downloads);
    EXPECT_LT(most.bytes_down, bytes);
  }
}

TEST(Transfers, InTheLoopOnlyAFewScalarsReachTheHost) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    Options options;
    options.boundary = boundary;
    options.effort = Effort::best;
    options.restarts = 0;
    // Less than a byte for each tetrahedron of the larger mesh.
    expect_few_transfers(options, 400, 6000);
  }
}

TEST(Transfers, RestartsTakeTheMeshToTheHostOnce) {
  const auto traffic_of = [](int rounds) {
    Options options;
    options.effort = Effort::best;
    options.restarts = rounds;
    TetMesh mesh = test::waved(test::cube(7, 0.2));
    const Emulation gpu(1);
    const Report report = optimize_on(gpu, mesh, options, {});
    EXPECT_GT(report.restarts_kept, 0);
    return gpu.device_memory().traffic();
  };
  const DeviceMemory::Traffic few = traffic_of(4);
  const DeviceMemory::Traffic many = traffic_of(12);
  // The polish that follows may take a few steps more or fewer.
  EXPECT_LT(many.downloads, few.downloads + few.downloads / 10);
  EXPECT_LT(many.uploads, few.uploads + 5);
}

TEST(Transfers, TheMeshCrossesAFewTimes) {
  const TetMesh mesh = test::waved(test::cube(10, 0.2));
  TetMesh m = mesh;
  const Emulation gpu(1);
  optimize_on(gpu, m, {}, {});
  const std::size_t bytes = mesh.points.size() * sizeof(Point3) + mesh.tets.size() * sizeof(mesh.tets[0]);
  EXPECT_LT(gpu.device_memory().traffic().bytes_up, 3 * bytes);
  EXPECT_LT(gpu.device_memory().traffic().bytes_down, 3 * bytes);
}

TEST(EmulationMemory, TheEstimateIsEnoughAndNotFarAbove) {
  const TetMesh mesh = test::waved(test::cube(20, 0.2));
  for (const Boundary boundary : {Boundary::fixed, Boundary::preserve, Boundary::slide}) {
    for (const Effort effort : {Effort::fast, Effort::best}) {
      if (test::kSanitized && effort == Effort::best && boundary != Boundary::slide) continue;
      Options options;
      options.boundary = boundary;
      options.effort = effort;
      options.restarts = 1;  // on the host
      TetMesh m = mesh;
      const Emulation gpu(1);
      optimize_on(gpu, m, options, {});
      const std::size_t peak = gpu.device_memory().pool().peak();
      const std::size_t needed = memory_needed_on_device(mesh, options);
      EXPECT_GT(needed, peak);
      // But for the 4 MiB that are for small meshes.
      EXPECT_LT(needed - (std::size_t{5} << 20), 2 * peak);
    }
  }
}

TEST(EmulationMemory, TheHostTouchesNoneOfItInAWholeRun) {
  Options options;
  options.effort = Effort::best;
  options.boundary = Boundary::slide;
  TetMesh guarded = test::ball(5);
  TetMesh plain = guarded;
  optimize_on(Emulation(1, std::size_t{64} << 20, backend::HostAccess::ends_process), guarded, options, {});
  optimize_on(Emulation(1), plain, options, {});
  expect_same(guarded, plain);
}

TEST(EmulationMemory, APoolAsLargeAsItsPeakDoesAndASmallerOneLeavesTheMeshAsItWas) {
  Options options;
  options.effort = Effort::best;
  const TetMesh before = test::two_materials(8, 0.2);
  TetMesh after = before;
  std::size_t peak = 0;
  {
    const Emulation gpu(1);
    optimize_on(gpu, after, options, {});
    peak = gpu.device_memory().pool().peak();
    EXPECT_EQ(gpu.device_memory().pool().in_use(), 0U);
  }
  TetMesh exact = before;
  optimize_on(Emulation(1, peak), exact, options, {});
  expect_same(exact, after);
  for (const std::size_t size : {std::size_t{0}, peak / 4, peak / 2, peak - backend::Pool::kAlignment}) {
    TetMesh m = before;
    try {
      optimize_on(Emulation(1, size), m, options, {});
      FAIL() << size << " of " << peak;
    } catch (const DeviceError& e) {
      EXPECT_NE(std::string(e.what()).find("device=cpu"), std::string::npos) << e.what();
    }
    expect_same(m, before);
  }
}

TEST(EmulationOfMove, APistonFitsIntoTheMemoryThatIsReserved) {
  const TetMesh before = test::scrambled(test::cube(9, 0.2, 4), 2, 2);
  std::vector<VertexTargets> targets(1);
  Options options;
  options.threads = 1;
  for (const Point3& p : before.points) {
    const bool moves = p[0] == 0 || p[0] == 1;
    targets[0].push_back(moves ? Point3{0.5 * p[0], p[1], p[2]} : test::kFree);
    options.frozen_vertices.push_back(moves ? 1 : 0);
  }
  TetMesh cpu = before;
  const MoveReport on_cpu = move(cpu, targets, options);
  ASSERT_TRUE(on_cpu.reached());
  const std::size_t memory = memory_needed_on_device(before, options) + motion_memory(before, options);
  TetMesh first;
  for (const unsigned seed : {1U, 2U}) {
    TetMesh m = before;
    MoveReport report;
    report.targets = targets.size();
    MoveJob job{targets, 1, options.frozen_vertices, report};
    const Report done = optimize_on(Emulation(seed, memory), m, options, {}, nullptr, &job);
    EXPECT_TRUE(report.reached());
    EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
    EXPECT_EQ(report.steps.size(), on_cpu.steps.size());
    EXPECT_NEAR(done.energy_after, on_cpu.optimization.energy_after, 1e-2 * done.energy_after);
    for (std::size_t v = 0; v < m.points.size(); ++v) {
      if (options.frozen_vertices[v] != 0) {
        EXPECT_EQ(m.points[v], targets[0][v]);
      }
    }
    if (seed == 1) {
      first = std::move(m);
    } else {
      expect_same(first, m);
    }
  }
}

}  // namespace
}  // namespace tetune
