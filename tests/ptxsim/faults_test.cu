// SPDX-License-Identifier: Apache-2.0
// Each deliberate fault is reported, as what it is; code without a fault is not.
#include <gtest/gtest.h>

#include <vector>

#include "ptxsim/device_array.cuh"
#include "ptxsim/global_memory.hpp"
#include "ptxsim/problems.hpp"
#include "ptxsim/settings.hpp"

namespace tetune::ptxsim {
namespace {

constexpr int kSize = 64;

__global__ void copy_from(const int* from, int* to, int offset) { to[threadIdx.x] = from[threadIdx.x + offset]; }
__global__ void load_misaligned(const char* from, double* to) {
  to[threadIdx.x] = *reinterpret_cast<const double*>(from + 4 + 8 * threadIdx.x);
}
__global__ void write_by_pairs(int* p) { p[threadIdx.x / 2] = static_cast<int>(threadIdx.x); }
__global__ void read_next_then_write(int* p, int* q) {
  q[threadIdx.x] = p[(threadIdx.x + 1) % kSize];
  p[threadIdx.x] = 1;
}
template <bool kHasBarrier>
__global__ void reverse_in_shared(int* p) {
  __shared__ int values[kSize];
  values[threadIdx.x] = p[threadIdx.x];
  if (kHasBarrier) __syncthreads();
  p[threadIdx.x] = values[kSize - 1 - threadIdx.x];
}
template <bool kHasBarrier>
__global__ void reverse_in_warp(int* p) {
  __shared__ int values[kLanes];
  values[threadIdx.x] = p[threadIdx.x];
  if (kHasBarrier) __syncwarp();
  p[threadIdx.x] = values[kLanes - 1 - threadIdx.x];
}
__global__ void read_shared(int* p, int index) {
  __shared__ int values[kSize];
  values[threadIdx.x] = 1;
  __syncthreads();
  p[threadIdx.x] = values[(threadIdx.x + index) % 4096];
}
__global__ void read_stack(int* p, int n) {
  int a[8];
  for (int i = 0; i < 8; ++i) a[i] = p[i];
  int sum = 0;
  for (int i = 0; i < n; ++i) sum += a[i * n % 9 + (n > 7 ? 20000 : 0)];
  p[8] = sum;
}
__global__ void shuffle_of_others(int* p) {
  if (threadIdx.x < 16) p[threadIdx.x] = __shfl_sync(0xffff0000U, static_cast<int>(threadIdx.x), 20);
}
__global__ void shuffle_from_absent(int* p) {
  if (threadIdx.x < 16) p[threadIdx.x] = __shfl_sync(0x0000ffffU, static_cast<int>(threadIdx.x), 20);
}
__global__ void wait_for_ended(int* p) {
  // The other half of the block waits at another barrier.
  if (threadIdx.x < 32) {
    asm volatile("bar.sync 1, 64;");
  } else {
    asm volatile("bar.sync 2, 64;");
  }
  p[threadIdx.x] = 1;
}
template <bool kWaits>
__global__ void reverse_in_global(int* p) {
  const int other = p[blockDim.x - 1 - threadIdx.x];
  if (kWaits) __syncthreads();
  p[threadIdx.x] = other;
}
/// Each lane adds to the value that the one before wrote.
template <bool kWaits>
__global__ void add_in_turn(int* p) {
  for (unsigned lane = 0; lane < kLanes; ++lane) {
    if (threadIdx.x == lane) *p = *p + 1;
    if (kWaits) __syncwarp();
  }
}
/// All threads read a value that one of them writes after a barrier.
__global__ void read_by_all_then_write(int* p) {
  const int read = *p;
  __syncthreads();
  if (threadIdx.x == 0) *p = read + 1;
}
__global__ void stop_here() { __trap(); }
__global__ void count(int* p) { atomicAdd(p, 1); }

/// Ends with no problem left, so that only unexpected ones fail the process.
struct Faults : testing::Test {
  const std::vector<int> values = std::vector<int>(kSize, 3);
  DeviceArray<int> written{values};
  DeviceArray<int> unwritten{kSize};

  Faults() { EXPECT_TRUE(settings().races) << "PTXSIM_RACES=1 is needed"; }
  ~Faults() override { problems().clear(); }

  static std::vector<Fault> found() {
    std::vector<Fault> faults;
    for (const Problem& p : problems().all()) faults.push_back(p.fault);
    return faults;
  }
  static void expect_only(Fault fault) {
    EXPECT_FALSE(problems().all().empty());
    for (const Fault f : found()) EXPECT_EQ(f, fault);
  }
};

TEST_F(Faults, NoneInCorrectCode) {
  copy_from<<<1, kSize>>>(written.data(), unwritten.data(), 0);
  count<<<4, kSize>>>(unwritten.data());
  reverse_in_shared<true><<<1, kSize>>>(written.data());
  reverse_in_warp<true><<<1, kLanes>>>(written.data());
  reverse_in_global<true><<<1, kSize>>>(written.data());
  add_in_turn<true><<<1, kLanes>>>(written.data());
  read_by_all_then_write<<<1, kSize>>>(written.data());
  EXPECT_TRUE(problems().all().empty());
  EXPECT_EQ(unwritten.data()[0], 3 + 4 * kSize);
}
TEST_F(Faults, ReadBeyondABuffer) {
  copy_from<<<1, kSize>>>(written.data(), unwritten.data(), 1);
  expect_only(Fault::outside_memory);
}
TEST_F(Faults, ReadOfHostMemory) {
  copy_from<<<1, kSize>>>(values.data(), unwritten.data(), 0);
  expect_only(Fault::outside_memory);
}
TEST_F(Faults, ReadOfUnwrittenMemory) {
  copy_from<<<1, kSize>>>(unwritten.data(), written.data(), 0);
  expect_only(Fault::unwritten);
}
TEST_F(Faults, MisalignedLoad) {
  DeviceArray<double> to(8);
  load_misaligned<<<1, 8>>>(reinterpret_cast<const char*>(written.data()), to.data());
  expect_only(Fault::misaligned);
}
TEST_F(Faults, TwoThreadsWrite) {
  write_by_pairs<<<1, kSize>>>(written.data());
  expect_only(Fault::race);
}
TEST_F(Faults, OneThreadWritesWhatAnotherReads) {
  read_next_then_write<<<1, kSize>>>(written.data(), unwritten.data());
  expect_only(Fault::race);
}
TEST_F(Faults, MissingBarrier) {
  reverse_in_shared<false><<<1, kSize>>>(written.data());
  expect_only(Fault::race);
}
TEST_F(Faults, MissingBarrierBeforeGlobalMemory) {
  reverse_in_global<false><<<1, kSize>>>(written.data());
  expect_only(Fault::race);
}
TEST_F(Faults, BarrierOfOneOfTwoBlocks) {
  reverse_in_global<true><<<2, kSize>>>(written.data());
  expect_only(Fault::race);
}
TEST_F(Faults, MissingWarpBarrierBeforeGlobalMemory) {
  add_in_turn<false><<<1, kLanes>>>(written.data());
  expect_only(Fault::race);
}
TEST_F(Faults, WarpsInTurnInOneOfTwoBlocks) {
  add_in_turn<true><<<2, kLanes>>>(written.data());
  expect_only(Fault::race);
}
TEST_F(Faults, ReadByAllBeforeAWriteInOneOfTwoBlocks) {
  read_by_all_then_write<<<2, kSize>>>(written.data());
  expect_only(Fault::race);
}
TEST_F(Faults, MissingWarpBarrier) {
  reverse_in_warp<false><<<1, kLanes>>>(written.data());
  expect_only(Fault::race);
}
TEST_F(Faults, ReadBeyondSharedMemory) {
  read_shared<<<1, kSize>>>(written.data(), 1);
  expect_only(Fault::outside_shared);
}
TEST_F(Faults, ReadBeyondTheStack) {
  read_stack<<<1, 1>>>(written.data(), 9);
  expect_only(Fault::outside_stack);
}
TEST_F(Faults, LaneThatIsNotNamed) {
  shuffle_of_others<<<1, kLanes>>>(written.data());
  EXPECT_EQ(found().front(), Fault::unnamed_lane);
}
TEST_F(Faults, ShuffleFromALaneThatIsAbsent) {
  shuffle_from_absent<<<1, kLanes>>>(written.data());
  expect_only(Fault::absent_lane);
}
TEST_F(Faults, EndlessWait) {
  wait_for_ended<<<1, kSize>>>(written.data());
  expect_only(Fault::endless_wait);
}
TEST_F(Faults, Trap) {
  stop_here<<<1, 1>>>();
  expect_only(Fault::trap);
}
TEST_F(Faults, CopiesBeyondABufferAndOfUnwrittenBytes) {
  std::vector<int> host(2 * kSize);
  EXPECT_NE(cudaMemcpy(written.data(), host.data(), 2 * kSize * sizeof(int), cudaMemcpyHostToDevice), cudaSuccess);
  EXPECT_NE(cudaMemcpy(host.data(), unwritten.data(), kSize * sizeof(int), cudaMemcpyDeviceToHost), cudaSuccess);
  expect_only(Fault::transfer);
  EXPECT_NE(cudaGetLastError(), cudaSuccess);
}

TEST_F(Faults, BuffersOfAPoolAreKnown) {
  constexpr std::size_t kBytes = kSize * sizeof(int);
  DeviceArray<char> block(16 * backend::Pool::kAlignment);
  backend::Pool pool(block.data(), 16 * backend::Pool::kAlignment);
  auto* const first = static_cast<int*>(pool.allocate(kBytes));
  auto* const second = static_cast<int*>(pool.allocate(kBytes));
  copy_from<<<1, kSize>>>(written.data(), first, 0);
  copy_from<<<1, kSize>>>(first, second, 0);
  EXPECT_TRUE(problems().all().empty());
  pool.release(second);
  copy_from<<<1, kSize>>>(second, first, 0);
  expect_only(Fault::outside_buffer);
  problems().clear();
  auto* const again = static_cast<int*>(pool.allocate(kBytes));
  EXPECT_EQ(again, second);
  copy_from<<<1, kSize>>>(again, first, 0);
  expect_only(Fault::unwritten);
  pool.release(first);
  pool.release(again);
}

}  // namespace
}  // namespace tetune::ptxsim
