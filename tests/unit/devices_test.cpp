// SPDX-License-Identifier: Apache-2.0
#include "driver/devices.hpp"

#include <gtest/gtest.h>

#include "support/meshes.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

void expect_says(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
}

CudaSystem usable_system() { return {12040, 12060, "", 1}; }
Gpu usable_gpu() { return {"Tesla T4", 7, 5, std::size_t{15} << 30, std::size_t{16} << 30, 40 * 1024}; }

TEST(Devices, SystemsWithoutAGpuToUseAreDistinguished) {
  EXPECT_EQ(why_no_gpu(usable_system()), "");
  CudaSystem newer = usable_system();
  newer.driver = 13000;
  EXPECT_EQ(why_no_gpu(newer), "");

  CudaSystem no_driver = usable_system();
  no_driver.driver = 0;
  no_driver.devices = 0;
  no_driver.error = "CUDA driver version is insufficient for CUDA runtime version";  // CUDA's message then
  expect_says(why_no_gpu(no_driver), {"no NVIDIA driver", "nvidia-smi", "device=cpu"});

  CudaSystem old_driver = no_driver;
  old_driver.driver = 11080;
  expect_says(why_no_gpu(old_driver), {"too old", "11.8", "12.6", "newer driver", "device=cpu"});

  CudaSystem hidden = usable_system();
  hidden.devices = 0;
  expect_says(why_no_gpu(hidden), {"none found", "CUDA_VISIBLE_DEVICES", "device=cpu"});
  hidden.error = "system not yet initialized";
  expect_says(why_no_gpu(hidden), {"system not yet initialized", "device=cpu"});
}

TEST(Devices, OldGpusAndFullOnesAreRefusedWithTheNeed) {
  Gpu gpu = usable_gpu();
  EXPECT_EQ(why_unusable(gpu, std::size_t{1} << 30), "");
  gpu.major = 8;
  gpu.minor = 0;
  EXPECT_EQ(why_unusable(gpu, 1), "");
  gpu.major = 7;
  gpu.minor = 2;
  expect_says(why_unusable(gpu, 1), {"Tesla T4", "7.2", "7.5", "device=cpu"});

  gpu = usable_gpu();
  expect_says(why_unusable(gpu, std::size_t{15} << 30), {"Tesla T4", "15360 of its 16384 MiB", "effort=fast"});
  // Beside the buffers there is the local memory of the threads.
  const std::size_t most = std::size_t{13} << 30;
  EXPECT_EQ(why_unusable(gpu, most), "");
  gpu.resident_threads *= 100;
  EXPECT_NE(why_unusable(gpu, most), "");
}

TEST(Devices, AutomaticTakesTheCpuForSmallMeshesAndWhereThereIsNoGpu) {
  TetMesh m = test::cube(3, 0.2);
  Options options;
  options.device = Device::automatic;
  const DeviceChoice small = choose_device(m, options);
  EXPECT_EQ(small.device, Device::cpu);
  expect_says(small.reason, {std::to_string(kAutoTets)});
  const Report report = optimize(m, options);
  EXPECT_EQ(report.device, "CPU");
  EXPECT_EQ(report.device_reason, small.reason);
  EXPECT_EQ(optimize(m).device_reason, "");

  m.tets.resize(kAutoTets);
  const std::string why_not = why_not_on_cuda(device_memory(m, options, nullptr));
  const DeviceChoice large = choose_device(m, options);
  EXPECT_EQ(large.device, why_not.empty() ? Device::cuda : Device::cpu);
  EXPECT_NE(large.reason, small.reason);
  if (!why_not.empty()) {
    EXPECT_EQ(large.reason, why_not);
  }
}

TEST(Devices, WhatIsRefusedBeforehandIsRefused) {
  TetMesh m = test::cube(2);
  Options options;
  options.device = Device::cuda;
  const std::string why = why_not_on_cuda(device_memory(m, options, nullptr));
  if (why.empty()) GTEST_SKIP() << "there is a GPU";
  expect_says(why, {"CUDA", "device=cpu"});
  try {
    optimize(m, options);
    FAIL();
  } catch (const DeviceError& e) {
    EXPECT_EQ(e.what(), why);
  }
}

}  // namespace
}  // namespace tetune
