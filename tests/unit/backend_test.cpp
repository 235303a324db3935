// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <stdexcept>
#include <thread>

#include "backend/cpu.hpp"
#include "emulation/emulation.hpp"
#include "mesh/csr.hpp"
#include "support/allocation_watch.hpp"

namespace tetune {
namespace {

using backend::Cpu;

struct Sum {
  double value = 0;
  void merge(const Sum& other) { value += other.value; }
};
struct Harmonic {
  Sum operator()(Size i) const { return {1.0 / static_cast<double>(i + 1)}; }
};
struct Count {
  Size value = 0;
  void merge(const Count& other) { value += other.value; }
};
struct One {
  Count operator()(Size) const { return {1}; }
};
struct FewHeavy : Harmonic {
  static constexpr Size kGrain = 4;
};
struct IsThird {
  bool operator()(Size i) const { return i % 3 == 0; }
};
struct Remainder {
  Size rows;
  Size operator()(Size i) const { return i % 7 == 0 ? -1 : i % rows; }
};

/// The contract of backend/concept.hpp.
template <class Setting>
struct Primitives : testing::Test, Setting {};

template <int kThreads>
struct Threads {
  using Backend = Cpu;
  Cpu backend{kThreads};
};
template <int kSeed>
struct Shuffled {
  using Backend = backend::Emulation;
  backend::Emulation backend{kSeed};
};
using Settings = testing::Types<Threads<1>, Threads<3>, Threads<40>, Shuffled<1>, Shuffled<2>>;
TYPED_TEST_SUITE(Primitives, Settings);

constexpr Size kSizes[] = {0, 1, 2, 255, 256, 257, 1024, 1025, 20000};

struct AddSquare {
  Span<Size> out;
  void operator()(Size i) const { out[i] += i * i; }
};

TYPED_TEST(Primitives, ForEachCallsEachIndexOnce) {
  using Here = typename TypeParam::Backend;
  for (const Size n : kSizes) {
    typename Here::template Buffer<Size> out(this->backend, n);
    this->backend.fill(out.span(), Size{5});
    this->backend.for_each(n, AddSquare{out.span()});
    const std::vector<Size> host = out.download();
    for (Size i = 0; i < n; ++i) ASSERT_EQ(host[static_cast<std::size_t>(i)], 5 + i * i) << n;
  }
}

/// Each step reads what the one before wrote for another item.
struct AddNeighbor {
  Span<Size> even, odd;
  void operator()(Size step, Size i) const {
    const Span<Size> from = step % 2 == 0 ? even : odd;
    (step % 2 == 0 ? odd : even)[i] = from[i] + from[(i + 1) % from.size()];
  }
};

TYPED_TEST(Primitives, StepsFollowEachOther) {
  using Here = typename TypeParam::Backend;
  for (const Size n : kSizes) {
    typename Here::template Buffer<Size> even(this->backend, n), odd(this->backend, n);
    std::vector<Size> expected(static_cast<std::size_t>(n));
    std::iota(expected.begin(), expected.end(), 1);
    even.upload(this->backend, expected);
    this->backend.for_each_step(4, n, AddNeighbor{even, odd});
    for (int step = 0; step < 4; ++step) {
      auto next = expected;
      std::rotate(next.begin(), next.begin() + (n > 0 ? 1 : 0), next.end());
      for (std::size_t i = 0; i < next.size(); ++i) expected[i] += next[i];
    }
    EXPECT_EQ(even.download(), expected) << n;
  }
}

TYPED_TEST(Primitives, ReduceMergesEachIndexOnce) {
  for (const Size n : kSizes) {
    double plain = 0;
    for (Size i = 0; i < n; ++i) plain += 1.0 / static_cast<double>(i + 1);
    EXPECT_NEAR(this->backend.template reduce<Sum>(n, Harmonic{}).value, plain, 1e-12 * plain) << n;
  }
}

TYPED_TEST(Primitives, ReduceOfMoreThanAChunkOfChunks) {
  EXPECT_EQ(this->backend.template reduce<Count>(1500000, One{}).value, 1500000);
  EXPECT_EQ(this->backend.template reduce_async<Count>(1500, One{}).get().value, 1500);
}

TYPED_TEST(Primitives, ScanSumsThePrecedingElements) {
  for (const Size n : kSizes) {
    std::vector<std::uint32_t> host(static_cast<std::size_t>(n));
    std::iota(host.begin(), host.end(), 1U);
    typename TypeParam::Backend::template Buffer<std::uint32_t> in;
    in.upload(this->backend, host);
    typename TypeParam::Backend::template Buffer<std::uint32_t> out(this->backend, n);
    EXPECT_EQ(this->backend.exclusive_scan(Span<const std::uint32_t>(in.span()), out.span()), n * (n + 1) / 2);
    EXPECT_EQ(this->backend.exclusive_scan_async(Span<const std::uint32_t>(in.span()), in.span()).get(),
              n * (n + 1) / 2);
    EXPECT_EQ(in.download(), out.download());
    host = in.download();
    for (Size i = 0; i < n; ++i) ASSERT_EQ(host[static_cast<std::size_t>(i)], i * (i + 1) / 2);
  }
}

TYPED_TEST(Primitives, CompactKeepsOrder) {
  for (const Size n : kSizes) {
    typename TypeParam::Backend::template Buffer<Index32> out(this->backend, n);
    const Size kept = this->backend.compact(n, IsThird{}, out.span());
    ASSERT_EQ(kept, (n + 2) / 3);
    const std::vector<Index32> host = out.download();
    for (Size i = 0; i < kept; ++i) ASSERT_EQ(host[static_cast<std::size_t>(i)], 3 * i);
  }
}

struct Square {
  std::uint32_t operator()(Size i) const { return static_cast<std::uint32_t>(i * i); }
};
struct ListWithSum {
  static constexpr Size kGrain = 32;
  Span<Index32> items;
  Span<std::uint32_t> before;
  void operator()(Size i, Size rank, std::uint32_t sum) const {
    items[rank] = static_cast<Index32>(i);
    before[rank] = sum;
  }
};

TYPED_TEST(Primitives, CompactAndSumIsTheScanOfWhatIsKept) {
  for (const Size n : kSizes) {
    typename TypeParam::Backend::template Buffer<Index32> out(this->backend, n);
    typename TypeParam::Backend::template Buffer<std::uint32_t> sums(this->backend, n);
    const auto all = this->backend.compact_and_sum(n, IsThird{}, Square{}, ListWithSum{out.span(), sums.span()});
    ASSERT_EQ(all.count, (n + 2) / 3);
    const std::vector<Index32> host = out.download();
    const std::vector<std::uint32_t> before = sums.download();
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < all.count; ++i) {
      ASSERT_EQ(host[i], static_cast<Index32>(3 * i));
      ASSERT_EQ(before[i], sum);
      sum += Square{}(host[i]);
    }
    EXPECT_EQ(all.sum, sum);
  }
}

/// Both items of a pair, until one of them is placed.
struct IsWholePair {
  Span<std::uint8_t> is_left;
  bool operator()(Size i) const { return is_left[i - i % 2] != 0 && is_left[i - i % 2 + 1] != 0; }
};
struct TakeItem {
  static constexpr Size kGrain = 32;
  Span<std::uint8_t> is_left;
  void operator()(Size i, Size, std::uint32_t) const { is_left[i] = 0; }
};

TYPED_TEST(Primitives, CompactAndSumEvaluatesPairsBeforeOneIsPlaced) {
  for (const Size n : kSizes) {
    typename TypeParam::Backend::template Buffer<std::uint8_t> is_left(this->backend, 2 * n);
    this->backend.fill(is_left.span(), std::uint8_t{1});
    const auto all =
        this->backend.compact_and_sum(2 * n, IsWholePair{is_left.span()}, Square{}, TakeItem{is_left.span()});
    EXPECT_EQ(all.count, 2 * n);
  }
}

TYPED_TEST(Primitives, SortIsStable) {
  std::mt19937_64 random(3);
  std::vector<std::uint64_t> keys(20000);
  for (auto& k : keys) k = random() % 1000 + ((random() % 3) << 40);
  std::vector<Index32> ids(keys.size());
  std::iota(ids.begin(), ids.end(), 0);
  auto expected = ids;
  std::stable_sort(expected.begin(), expected.end(), [&](Index32 a, Index32 b) {
    return keys[static_cast<std::size_t>(a)] < keys[static_cast<std::size_t>(b)];
  });
  typename TypeParam::Backend::template Buffer<std::uint64_t> k;
  typename TypeParam::Backend::template Buffer<Index32> v;
  this->backend.sort_by_key(k, v, 48);
  EXPECT_EQ(v.size(), 0);
  k.upload(this->backend, keys);
  v.upload(this->backend, ids);
  this->backend.sort_by_key(k, v, 48);
  EXPECT_EQ(v.download(), expected);
  keys = k.download();
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end()));
}

TYPED_TEST(Primitives, BuffersKeepTheirContentWhenTheyGrow) {
  typename TypeParam::Backend::template Buffer<int> b;
  b.upload(this->backend, {1, 2, 3});
  b.grow(this->backend, 1000);
  EXPECT_EQ(b.size(), 1000);
  b.grow(this->backend, 3);
  EXPECT_EQ(b.download(), (std::vector<int>{1, 2, 3}));
}

TYPED_TEST(Primitives, LargeBuffersAreCopiedAsAWhole) {
  std::vector<int> values(300001);  // several parts of a copy, the last one shorter
  std::iota(values.begin(), values.end(), 7);
  typename TypeParam::Backend::template Buffer<int> a, b;
  a.upload(this->backend, values);
  EXPECT_EQ(a.download(), values);
  b.assign(this->backend, a);
  EXPECT_EQ(b.download(), values);
  b.grow(this->backend, 2 * b.size());
  b.resize(this->backend, a.size());
  EXPECT_EQ(b.download(), values);
}

TYPED_TEST(Primitives, RowsHoldEachItemOnceInOrder) {
  using Here = typename TypeParam::Backend;
  Csr<Here> rows;
  build_csr(this->backend, 10, 5000, Remainder{10}, rows);
  const auto offsets = rows.offsets.download();
  const auto items = rows.items.download();
  ASSERT_EQ(offsets.size(), 11U);
  EXPECT_EQ(offsets[10], 5000U - 715U);
  ASSERT_EQ(items.size(), offsets[10]);
  for (std::size_t r = 0; r < 10; ++r) {
    for (std::size_t i = offsets[r]; i < offsets[r + 1]; ++i) {
      ASSERT_EQ(Remainder{10}(items[i]), static_cast<Size>(r));
      if (i > offsets[r]) {
        ASSERT_GT(items[i], items[i - 1]);
      }
    }
  }
}

TEST(Cpu, ReduceGivesTheSameBitsForAnyNumberOfThreads) {
  const double one = Cpu(1).reduce<Sum>(100000, Harmonic{}).value;
  for (const int threads : {2, 3, 7}) EXPECT_EQ(Cpu(threads).reduce<Sum>(100000, Harmonic{}).value, one);
}

TEST(Emulation, ReduceGivesTheSameBitsForAnyOrder) {
  const double one = backend::Emulation(1).reduce<Sum>(100000, Harmonic{}).value;
  for (const std::uint64_t seed : {2U, 3U, 7U}) {
    EXPECT_EQ(backend::Emulation(seed).reduce<Sum>(100000, Harmonic{}).value, one);
  }
}

TEST(Cpu, FewHeavyItemsGiveTheSameBitsForAnyNumberOfThreads) {
  for (const Size n : {Size{3}, Size{100}, Size{1000}, Size{100000}}) {
    const double few = Cpu(1).reduce<Sum>(n, FewHeavy{}).value;
    EXPECT_NEAR(few, Cpu(1).reduce<Sum>(n, Harmonic{}).value, 1e-12 * few);
    for (const int threads : {2, 3, 7}) EXPECT_EQ(Cpu(threads).reduce<Sum>(n, FewHeavy{}).value, few);
  }
}

/// The first item waits until another has started, which only another thread can do.
struct Meet {
  static constexpr Size kGrain = 1;
  std::atomic<int>* started;
  std::atomic<bool>* met;
  void operator()(Size) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    ++*started;
    while (*started < 2 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    if (*started < 2) *met = false;
  }
};

TEST(Cpu, FewHeavyItemsRunOnSeveralThreads) {
  const Cpu cpu(2);
  ASSERT_EQ(cpu.threads(), 2);
  std::atomic<int> started = 0;
  std::atomic<bool> met = true;
  cpu.for_each(8, Meet{&started, &met});
  EXPECT_TRUE(met);
  EXPECT_EQ(started, 8);
}

TEST(ThreadPool, RunsEachPartOncePerLoop) {
  backend::ThreadPool pool(4);
  std::vector<int> done(100, 0);
  for (int round = 1; round <= 2000; ++round) {
    pool.run(100, [&](Size part) { ++done[static_cast<std::size_t>(part)]; });
    for (const int d : done) ASSERT_EQ(d, round);
  }
  pool.run(0, [](Size) { FAIL(); });
}

TEST(ThreadPool, RethrowsTheExceptionOfAPart) {
  backend::ThreadPool pool(3);
  std::atomic<int> others{0};
  const auto task = [&](Size part) {
    if (part == 7) throw std::runtime_error("seven");
    ++others;
  };
  EXPECT_THROW(pool.run(50, task), std::runtime_error);
  EXPECT_EQ(others.load(), 49);
  pool.run(10, [&](Size) { ++others; });
  EXPECT_EQ(others.load(), 59);
}

TEST(ThreadPool, SeveralPoolsRunConcurrently) {
  std::vector<std::thread> users;
  std::atomic<Size> sum{0};
  for (int u = 0; u < 3; ++u) {
    users.emplace_back([&sum] {
      const Cpu cpu(2);
      for (int round = 0; round < 200; ++round) cpu.for_parts(20, [&sum](Size part) { sum += part; });
    });
  }
  for (std::thread& u : users) u.join();
  EXPECT_EQ(sum.load(), 3 * 200 * 190);
}

TEST(ThreadPool, RunsWithTheThreadsThatStarted) {
  if (!test::AllocationWatch::works()) GTEST_SKIP() << "allocations cannot be made to fail here";
  for (const std::size_t granted : {0U, 1U, 3U}) {
    std::optional<backend::ThreadPool> pool;
    {
      const test::AllocationWatch watch(granted);
      pool.emplace(8);
    }
    EXPECT_LT(pool->threads(), 8);
    std::atomic<Size> sum{0};
    pool->run(20, [&sum](Size part) { sum += part; });
    EXPECT_EQ(sum.load(), 190);
  }
}

TEST(ThreadPool, LimitsTheNumberOfThreads) {
  if (!test::AllocationWatch::works()) GTEST_SKIP() << "would start all threads";
  const test::AllocationWatch watch(1);
  const backend::ThreadPool pool(std::numeric_limits<int>::max());
  EXPECT_EQ(watch.largest(), sizeof(std::thread) * backend::ThreadPool::kMaxThreads);
}

struct IntLess {
  bool operator()(int a, int b) const { return a < b; }
};
TEST(SortSmall, SortsShortAndLong) {
  std::mt19937 random(1);
  for (const std::size_t n : {0U, 1U, 2U, 47U, 48U, 49U, 50U, 1000U}) {
    std::vector<int> a(n);
    for (int& x : a) x = static_cast<int>(random() % 100);
    auto expected = a;
    std::sort(expected.begin(), expected.end());
    sort_small(a.data(), static_cast<Size>(n), IntLess{});
    EXPECT_EQ(a, expected) << n;
  }
}

}  // namespace
}  // namespace tetune
