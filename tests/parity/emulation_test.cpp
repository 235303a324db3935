// SPDX-License-Identifier: Apache-2.0
// Whole runs on the emulation of the CUDA backend against the CPU: what is left to a GPU is what hardware does.
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "curved.hpp"
#include "driver/devices.hpp"
#include "driver/distributed_interface.hpp"
#include "emulation/emulation.hpp"
#include "tetune/error.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using backend::DeviceMemory;
using backend::Emulation;

struct Case {
  std::string name;
  TetMesh mesh;
  Options options;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

TetMesh with_patches(TetMesh m) {
  for (const test::SkinFace& f : test::skin(m)) {
    m.triangles.push_back(f.v);
    m.triangle_tags.push_back(m.points[static_cast<std::size_t>(f.v[0])][0] < 0.4 ? 7 : 9);
  }
  return m;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  const auto add = [&all](const std::string& name, TetMesh mesh) -> Options& {
    all.push_back({name, std::move(mesh), {}});
    return all.back().options;
  };
  const std::pair<const char*, Effort> efforts[] = {
      {"fast", Effort::fast}, {"standard", Effort::standard}, {"best", Effort::best}};
  for (const auto& [name, effort] : efforts) {
    Options& fixed = add(std::string("fixed_") + name, test::waved(test::cube(9, 0.2)));
    fixed.boundary = Boundary::fixed;
    fixed.effort = effort;
    add(std::string("preserve_") + name, test::scrambled(test::two_materials(10, 0.2), 3, 1)).effort = effort;
    Options& slide = add(std::string("slide_") + name, test::ball(9));
    slide.boundary = Boundary::slide;
    slide.effort = effort;
  }
  add("gradient", test::two_materials(8, 0.2)).relocation = Relocation::gradient;
  Options& gradient = add("gradient_slide", test::ball(7));
  gradient.relocation = Relocation::gradient;
  gradient.boundary = Boundary::slide;
  add("harmonic", test::cube(8, 0.2)).energy = Energy::harmonic;
  add("paper", test::cube(8, 0.2)).termination = Termination::paper;
  Options& bound = add("deviation", test::waved(test::cube(8, 0.15)));
  bound.boundary = Boundary::slide;
  bound.max_deviation = 2e-3;
  Options& patches = add("patches", with_patches(test::waved(test::two_materials(8, 0.15))));
  patches.boundary = Boundary::slide;
  patches.frozen_patches = {7};
  add("frozen_region", test::two_materials(8, 0.2)).frozen_regions = {2};
  Options& vertices = add("frozen_vertices", test::cube(8, 0.2));
  vertices.frozen_vertices.resize(all.back().mesh.points.size());
  for (std::size_t v = 0; v < vertices.frozen_vertices.size(); v += 5) vertices.frozen_vertices[v] = 1;
  add("required", test::cube(8, 0.2));
  for (Index t = 0; t < 200; t += 7) all.back().mesh.required_tets.push_back(t);
  add("edges", test::cube(8, 0.2));
  for (std::size_t t = 0; t < 100; t += 9) {
    TetMesh& m = all.back().mesh;
    m.edges.push_back({m.tets[t][0], m.tets[t][2]});
    m.edge_tags.push_back(3);
  }
  add("no_flips", test::cube(8, 0.2)).flips = false;
  add("flips_alone", test::cube(8, 0.2)).max_iterations = 0;
  for (const auto boundary : {Boundary::preserve, Boundary::slide}) {
    Options& untangle = add(boundary == Boundary::slide ? "untangle_slide" : "untangle", test::tangled(8, 0.9, 7));
    untangle.boundary = boundary;
    untangle.untangle = true;
  }
  return all;
}

class EmulationAgainstCpu : public testing::TestWithParam<Case> {};

void expect_same(const TetMesh& a, const TetMesh& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.tets, b.tets);
  EXPECT_EQ(a.tet_tags, b.tet_tags);
  EXPECT_EQ(a.triangles, b.triangles);
}

TEST_P(EmulationAgainstCpu, Agrees) {
  const Case& c = GetParam();
  TetMesh cpu = c.mesh;
  const Report on_cpu = optimize(cpu, c.options);
  TetMesh first = c.mesh;
  // In the memory that a GPU would set aside.
  const std::size_t memory = memory_needed_on_device(c.mesh, c.options);
  const Report report = optimize_on(Emulation(1, memory), first, c.options, {});
  EXPECT_TRUE(validate(first).ok()) << validate(first).message(false);
  EXPECT_LT(std::min(report.energy_after, on_cpu.energy_after), on_cpu.energy_before) << "nothing was done";
  EXPECT_NEAR(report.energy_after, on_cpu.energy_after, 1e-9 * on_cpu.energy_after);
  EXPECT_EQ(report.tets_untangled, on_cpu.tets_untangled);
  EXPECT_EQ(report.tets_untangled > 0, c.options.untangle);
  EXPECT_EQ(report.flips23, on_cpu.flips23);
  EXPECT_EQ(report.flips32, on_cpu.flips32);
  EXPECT_EQ(report.edge_removals, on_cpu.edge_removals);
  EXPECT_EQ(report.face_removals, on_cpu.face_removals);
  EXPECT_EQ(report.boundary_flips, on_cpu.boundary_flips);
  EXPECT_EQ(report.compound_flips, on_cpu.compound_flips);
  EXPECT_EQ(report.vertices_inserted, on_cpu.vertices_inserted);
  EXPECT_EQ(report.vertices_removed, on_cpu.vertices_removed);
  EXPECT_EQ(report.sweeps.size(), on_cpu.sweeps.size());
  EXPECT_EQ(report.stop, on_cpu.stop);

  TetMesh second = c.mesh;
  const Report again = optimize_on(Emulation(2), second, c.options, {});
  EXPECT_EQ(again.energy_after, report.energy_after);
  expect_same(first, second);
  if (c.options.boundary != Boundary::slide) return;
  SlideSurface surface = find_slide_surface(c.mesh, c.options);
  TetMesh given = c.mesh;
  optimize_on(Emulation(3), given, c.options, {}, &surface);
  expect_same(first, given);
}

INSTANTIATE_TEST_SUITE_P(All, EmulationAgainstCpu, testing::ValuesIn(cases()),
                         [](const auto& one) { return one.param.name; });

/// The maximum number of bytes that cross between two calls of the progress callback.
DeviceMemory::Traffic most_between_looks(const TetMesh& mesh, const Options& options) {
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

TEST(Transfers, InTheLoopOnlyAFewScalarsReachTheHost) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    Options options;
    options.boundary = boundary;
    options.effort = Effort::best;
    for (const int n : {6, 12}) {
      const DeviceMemory::Traffic most = most_between_looks(test::ball(n), options);
      EXPECT_EQ(most.uploads, 0U);
      EXPECT_LT(most.downloads, 400U);
      // Less than a byte for each of the 8000 tetrahedra of the larger mesh; the same for the smaller.
      EXPECT_LT(most.bytes_down, 6000U);
    }
  }
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
      Options options;
      options.boundary = boundary;
      options.effort = effort;
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
  optimize_on(Emulation(1, std::size_t{64} << 20, true), guarded, options, {});
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

}  // namespace
}  // namespace tetune
