// SPDX-License-Identifier: Apache-2.0
// The GPU against the CPU. Without a usable GPU these tests are skipped, and counted as skipped.
#include <gtest/gtest.h>

#include "meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

std::string why_no_gpu() {
  TetMesh m = test::one_tet();
  Options options;
  options.device = Device::cuda;
  try {
    optimize(m, options);
  } catch (const DeviceError& e) {
    return e.what();
  }
  return "";
}

TEST(Devices, CudaAgreesWithTheCpu) {
  if (const std::string why = why_no_gpu(); !why.empty()) GTEST_SKIP() << why;
  for (const Relocation relocation : {Relocation::newton, Relocation::gradient}) {
    Options options;
    options.relocation = relocation;
    TetMesh cpu = test::two_materials(12, 0.2);
    TetMesh gpu = cpu;
    options.device = Device::cpu;
    const Report on_cpu = optimize(cpu, options);
    options.device = Device::cuda;
    const Report on_gpu = optimize(gpu, options);
    EXPECT_TRUE(validate(gpu).ok());
    EXPECT_NEAR(on_gpu.energy_after, on_cpu.energy_after, 1e-9 * on_cpu.energy_after);
    EXPECT_EQ(on_gpu.flips23, on_cpu.flips23);
    EXPECT_EQ(on_gpu.flips32, on_cpu.flips32);
    EXPECT_EQ(on_gpu.edge_removals, on_cpu.edge_removals);
    EXPECT_EQ(on_gpu.face_removals, on_cpu.face_removals);
    EXPECT_EQ(on_gpu.boundary_flips, on_cpu.boundary_flips);
  }
}

TEST(Devices, AskingForAnAbsentGpuIsAClearErrorAndLeavesTheMesh) {
  const std::string why = why_no_gpu();
  if (why.empty()) GTEST_SKIP() << "there is a GPU";
  EXPECT_NE(why.find("device=cpu"), std::string::npos) << why;
  TetMesh m = test::cube(3, 0.2);
  const auto tets = m.tets;
  Options options;
  options.device = Device::cuda;
  EXPECT_THROW(optimize(m, options), DeviceError);
  EXPECT_EQ(m.tets, tets);
}

}  // namespace
}  // namespace tetune
