// SPDX-License-Identifier: Apache-2.0
#include "backend/pool.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "emulation/emulation.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

using backend::Emulation;
using backend::Pool;

constexpr std::size_t kUnit = Pool::kAlignment;

/// A size larger than all that the tests allocate, and the address of a range of that size without memory: a pool does
/// not access its block.
constexpr std::size_t kHuge = std::size_t{1} << (sizeof(std::size_t) > 4 ? 40 : 28);
char* no_memory() { return reinterpret_cast<char*>(kHuge); }

struct PoolWithoutMemory : testing::Test {
  char* const block = no_memory();
  Pool pool{block, 10 * kUnit};
  std::size_t at(void* part) const { return static_cast<std::size_t>(static_cast<char*>(part) - block) / kUnit; }
};

TEST_F(PoolWithoutMemory, PartsAreAlignedAndApart) {
  EXPECT_EQ(at(pool.allocate(1)), 0U);
  EXPECT_EQ(at(pool.allocate(kUnit)), 1U);
  EXPECT_EQ(at(pool.allocate(kUnit + 1)), 2U);
  EXPECT_EQ(at(pool.allocate(1)), 4U);
  EXPECT_EQ(pool.allocate(0), nullptr);
  EXPECT_EQ(pool.in_use(), 5 * kUnit);
  for (const std::size_t unit : {0U, 1U, 2U, 4U}) pool.release(block + unit * kUnit);
  EXPECT_EQ(pool.in_use(), 0U);
  EXPECT_EQ(pool.peak(), 5 * kUnit);
}

TEST_F(PoolWithoutMemory, TheSmallestFreePartThatFitsIsUsed) {
  void* const large = pool.allocate(3 * kUnit);
  void* const between = pool.allocate(kUnit);
  void* const small = pool.allocate(2 * kUnit);
  void* const last = pool.allocate(kUnit);
  pool.release(large);
  pool.release(small);
  void* const two = pool.allocate(2 * kUnit);
  EXPECT_EQ(two, small);
  void* const one = pool.allocate(kUnit);
  EXPECT_EQ(one, large);
  EXPECT_EQ(pool.peak(), 7 * kUnit);
  for (void* part : {two, one, between, last}) pool.release(part);
}

TEST_F(PoolWithoutMemory, AdjacentPartsAreMergedInAnyOrder) {
  std::vector<int> order{0, 1, 2, 3};
  do {
    std::vector<void*> parts;
    for (int i = 0; i < 4; ++i) parts.push_back(pool.allocate(2 * kUnit));
    for (const int i : order) pool.release(parts[static_cast<std::size_t>(i)]);
    void* const all = pool.allocate(8 * kUnit);
    EXPECT_EQ(at(all), 0U);
    pool.release(all);
    EXPECT_EQ(pool.peak(), 8 * kUnit);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_F(PoolWithoutMemory, AFreePartAtTheEndGrows) {
  void* const first = pool.allocate(6 * kUnit);
  void* const second = pool.allocate(3 * kUnit);
  pool.release(second);
  void* const third = pool.allocate(4 * kUnit);
  EXPECT_EQ(third, second);
  EXPECT_EQ(pool.peak(), 10 * kUnit);
  pool.release(first);
  pool.release(third);
}

TEST_F(PoolWithoutMemory, AFailedAllocationReportsTheSizeAndChangesNothing) {
  void* const first = pool.allocate(6 * kUnit);
  try {
    pool.allocate(5 * kUnit);
    FAIL();
  } catch (const DeviceError& e) {
    EXPECT_NE(std::string(e.what()).find("device=cpu"), std::string::npos) << e.what();
  }
  EXPECT_THROW(pool.allocate(std::size_t{1} << 62), DeviceError);
  EXPECT_EQ(pool.in_use(), 6 * kUnit);
  EXPECT_EQ(pool.peak(), 6 * kUnit);
  void* const rest = pool.allocate(4 * kUnit);
  EXPECT_EQ(at(rest), 6U);
  pool.release(first);
  pool.release(rest);
}

/// A device with memory for two blocks of at most 10 units and one of at most 2.
struct GrowingPoolOfADevice : testing::Test {
  static inline std::vector<std::size_t> allocated;
  static inline int freed = 0;
  static void* allocate(std::size_t bytes) {
    const bool fits = allocated.size() < 2 ? bytes <= 10 * kUnit : allocated.size() < 3 && bytes <= 2 * kUnit;
    if (!fits) return nullptr;
    allocated.push_back(bytes);
    return no_memory() + 100 * allocated.size() * kUnit;
  }
  static void free(void*) { ++freed; }
  GrowingPoolOfADevice() {
    allocated.clear();
    freed = 0;
  }
};

TEST_F(GrowingPoolOfADevice, TakesAnotherBlockWhereThoseItHasAreTooSmall) {
  {
    backend::GrowingPool pool({allocate, free}, 10 * kUnit);
    void* const first = pool.allocate(8 * kUnit);
    void* const second = pool.allocate(4 * kUnit);
    EXPECT_EQ(first, no_memory() + 100 * kUnit);
    EXPECT_EQ(second, no_memory() + 200 * kUnit);
    EXPECT_EQ(pool.allocate(2 * kUnit), no_memory() + 108 * kUnit) << "the first block still has room";
    EXPECT_EQ(pool.allocate(0), nullptr);
    void* const third = pool.allocate(1);
    EXPECT_EQ(allocated, (std::vector<std::size_t>{10 * kUnit, 4 * kUnit, kUnit})) << "2.5 units are not to be had";
    EXPECT_THROW(pool.allocate(21 * kUnit), DeviceError);
    EXPECT_THROW(pool.allocate(3 * kUnit), DeviceError) << "the device has no more";
    pool.release(second);
    EXPECT_EQ(pool.allocate(3 * kUnit), second);
    for (void* part : {first, second, third, static_cast<void*>(no_memory() + 108 * kUnit)}) pool.release(part);
    EXPECT_EQ(freed, 0);
  }
  EXPECT_EQ(freed, 3);
}

TEST_F(GrowingPoolOfADevice, RefusesAFirstBlockThatIsTooLarge) {
  try {
    backend::GrowingPool({allocate, free}, 11 * kUnit);
    FAIL();
  } catch (const DeviceError& e) {
    EXPECT_NE(std::string(e.what()).find("device=cpu"), std::string::npos) << e.what();
  }
}

TEST(Pool, PartsDoNotOverlapAndHaveTheSamePositionsInABlockOfThePeakSize) {
  const auto run = [](std::size_t size) {
    char* const block = no_memory();
    Pool pool(block, size);
    std::mt19937 random(5);
    std::map<char*, std::size_t> live;
    std::vector<std::size_t> places;
    for (int step = 0; step < 4000; ++step) {
      if (live.size() > 60 || (!live.empty() && random() % 2 == 0)) {
        const auto gone = std::next(live.begin(), static_cast<std::ptrdiff_t>(random() % live.size()));
        pool.release(gone->first);
        live.erase(gone);
        continue;
      }
      const std::size_t bytes = 1 + random() % 100000;
      char* const part = static_cast<char*>(pool.allocate(bytes));
      const auto next = live.lower_bound(part);
      if (next != live.end()) {
        EXPECT_LE(part + bytes, next->first);
      }
      if (next != live.begin()) {
        EXPECT_LE(std::prev(next)->first + std::prev(next)->second, part);
      }
      live.emplace(part, bytes);
      places.push_back(static_cast<std::size_t>(part - block));
      EXPECT_LE(places.back() + bytes, pool.peak());
    }
    for (const auto& [part, bytes] : live) pool.release(part);
    return std::pair(places, pool.peak());
  };
  const auto [places, peak] = run(kHuge);
  EXPECT_EQ(run(peak).first, places);
  EXPECT_LT(peak, 60U * 100000U);
}

struct Read {
  Span<const double> from;
  Span<std::uint8_t> is_number;
  void operator()(Size i) const { is_number[i] = std::isnan(from[i]) ? 0 : 1; }
};

TEST(EmulatedMemory, IsNaNUntilWritten) {
  const Emulation gpu;
  for (int turn = 0; turn < 2; ++turn) {
    Emulation::Buffer<double> values(gpu, 1000);
    Emulation::Buffer<std::uint8_t> is_number(gpu, 1000);
    gpu.for_each(1000, Read{values.span(), is_number.span()});
    EXPECT_EQ(is_number.download(), std::vector<std::uint8_t>(1000, 0));
    gpu.fill(values.span(), 1.0);  // invalid again once released
    gpu.for_each(1000, Read{values.span(), is_number.span()});
    EXPECT_EQ(is_number.download(), std::vector<std::uint8_t>(1000, 1));
  }
}

TEST(EmulatedMemory, CountsTransfers) {
  const Emulation gpu;
  Emulation::Buffer<double> values;
  values.upload(gpu, {1, 2, 3});
  EXPECT_EQ(values.download(), (std::vector<double>{1, 2, 3}));
  gpu.exclusive_scan(Span<const double>(values.span()), values.span());
  const auto& traffic = gpu.device_memory().traffic();
  EXPECT_EQ(traffic.uploads, 1U);
  EXPECT_EQ(traffic.bytes_up, 24U);
  EXPECT_EQ(traffic.downloads, 2U) << "a scan downloads its sum";
  EXPECT_EQ(traffic.bytes_down, 24U + 16U);
}

#if defined(__has_builtin)
#if __has_builtin(__builtin_clear_padding)
struct ReadsHost {
  const double* from;
  Span<double> to;
  void operator()(Size i) const { to[i] = *from; }
};
TEST(EmulatedMemory, KernelsMayHoldNoHostAddress) {
  const Emulation gpu;
  const double value = 1;
  if (reinterpret_cast<std::uintptr_t>(&value) < backend::DeviceMemory::kLowestHostAddress) {
    GTEST_SKIP() << "addresses of this system cannot be distinguished from other words";
  }
  Emulation::Buffer<double> values(gpu, 10);
  EXPECT_THROW(gpu.for_each(10, ReadsHost{&value, values.span()}), std::logic_error);
  EXPECT_NO_THROW(gpu.for_each(10, ReadsHost{values.span().data() + 3, values.span()}));
}
#endif
#endif

#ifdef GTEST_HAS_DEATH_TEST
TEST(EmulatedMemoryDeathTest, TheHostMayNotAccessIt) {
  const Emulation gpu(1, std::size_t{1} << 20, backend::HostAccess::ends_process);
  Emulation::Buffer<int> values(gpu, 10);
  gpu.fill(values.span(), 7);
  EXPECT_EQ(values.download()[9], 7);
  EXPECT_DEATH({ values.span()[9] = 8; }, "");
}
#endif

}  // namespace
}  // namespace tetune
