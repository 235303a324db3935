// SPDX-License-Identifier: Apache-2.0
// The GPU against the CPU. Without a usable GPU these tests are skipped, and counted as skipped.
#include <gtest/gtest.h>

#include "parity/cases.hpp"
#include "support/meshes.hpp"
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

class Devices : public testing::TestWithParam<test::Case> {};

TEST_P(Devices, CudaAgreesWithTheCpu) {
  static const std::string why = why_no_gpu();
  if (!why.empty()) GTEST_SKIP() << why;
  const test::Case& c = GetParam();
  TetMesh cpu = c.mesh;
  const Report on_cpu = optimize(cpu, c.options);
  TetMesh gpu = c.mesh;
  Options options = c.options;
  options.device = Device::cuda;
  const Report on_gpu = optimize(gpu, options);
  EXPECT_TRUE(validate(gpu).ok()) << validate(gpu).message(false);
  test::expect_parity(on_gpu, on_cpu);
  test::expect_same(gpu, cpu);
}

INSTANTIATE_TEST_SUITE_P(All, Devices, testing::ValuesIn(test::cases()),
                         [](const auto& one) { return one.param.name; });

TEST(DeviceErrors, AskingForAnAbsentGpuIsAClearErrorAndLeavesTheMesh) {
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
