// SPDX-License-Identifier: Apache-2.0
#include "par/host_memory.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <new>
#include <random>
#include <thread>
#include <vector>

#include "allocation_watch.hpp"

namespace tetune {
namespace {

namespace memory = par::host_memory;

constexpr std::size_t kMiB = std::size_t{1} << 20;

struct Array {
  std::size_t bytes;
  unsigned char* at;
  explicit Array(std::size_t n) : bytes(n), at(static_cast<unsigned char*>(memory::allocate(n))) {}
  void release() const { memory::release(at, bytes); }
};

TEST(HostMemory, ArraysKeepWhatIsWrittenAndAreAligned) {
  const memory::Session session;
  std::mt19937 random(3);
  std::map<unsigned char, Array> live;
  for (int step = 0; step < 2000; ++step) {
    const auto id = static_cast<unsigned char>(random() % 40);
    if (const auto old = live.find(id); old != live.end()) {
      EXPECT_EQ(old->second.at[0], id);
      EXPECT_EQ(old->second.at[old->second.bytes - 1], id);
      old->second.release();
      live.erase(old);
      continue;
    }
    const Array array(1 + random() % (step % 10 == 0 ? 3 * kMiB : 200000));
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(array.at) % 64, 0U);
    std::memset(array.at, id, array.bytes);
    live.emplace(id, array);
  }
  for (const auto& [id, array] : live) {
    for (std::size_t k = 0; k < array.bytes; k += 4096) EXPECT_EQ(array.at[k], id);
    array.release();
  }
  EXPECT_EQ(memory::allocate(0), nullptr);
}

/// Under the address sanitizer each array is a block of its own, and too large a one ends the process.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kRegions = false;
#elif defined(__has_feature)
constexpr bool kRegions = !__has_feature(address_sanitizer);
#else
constexpr bool kRegions = true;
#endif

TEST(HostMemory, OneLargeArrayIsServedByWhatSmallerOnesGaveBack) {
  if (!kRegions) GTEST_SKIP() << "no regions";
  const memory::Session session;
  std::vector<Array> small;
  for (int i = 0; i < 8; ++i) small.emplace_back(kMiB);
  const Array after(kMiB);
  for (const Array& array : small) array.release();
  const Array large(8 * kMiB);
  EXPECT_LT(large.at, after.at);
  large.release();
  after.release();
}

TEST(HostMemory, BelongsToAllThreads) {
  const memory::Session session;
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([t] {
      for (std::size_t round = 1; round < 200; ++round) {
        const Array array(round * 10000);
        std::memset(array.at, t, array.bytes);
        EXPECT_EQ(array.at[array.bytes / 2], t);
        array.release();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(HostMemory, MoreThanThereIsIsRefused) {
  if (!kRegions) GTEST_SKIP() << "no regions";
  const memory::Session session;
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  for (const std::size_t bytes : {kAll, kAll - 100, kAll / 4}) EXPECT_THROW(memory::allocate(bytes), std::bad_alloc);
  if (!test::AllocationWatch::works()) return;
  void* memory = nullptr;
  std::size_t granted = 0;
  for (; memory == nullptr; ++granted) {
    const test::AllocationWatch watch(granted);
    try {
      memory = memory::allocate(kMiB);
    } catch (const std::bad_alloc&) {
    }
  }
  EXPECT_GT(granted, 1U);
  memory::release(memory, kMiB);
}

TEST(HostMemory, NothingIsKeptWhereAddressSpaceIsLimited) {
  if (!kRegions) GTEST_SKIP() << "no regions";
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_DATA, &before), 0);
  const rlimit large{rlim_t{1} << 46, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_DATA, &large), 0);
  {
    const memory::Session session;
    const Array array(kMiB);
    const auto is_there = [&] { return msync(array.at, 4096, MS_ASYNC) == 0; };
    EXPECT_TRUE(is_there());
    array.release();
    EXPECT_FALSE(is_there());
  }
  ASSERT_EQ(setrlimit(RLIMIT_DATA, &before), 0);
}

}  // namespace
}  // namespace tetune
