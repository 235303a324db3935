// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <stdexcept>
#include <thread>

#include "allocation_watch.hpp"
#include "core/rows.hpp"
#include "par/cpu.hpp"

namespace tetune {
namespace {

using par::Cpu;
using Index = par::Index32;

struct Sum {
  double value = 0;
  void merge(const Sum& other) { value += other.value; }
};
struct Harmonic {
  Sum operator()(Size i) const { return {1.0 / static_cast<double>(i + 1)}; }
};
struct IsThird {
  bool operator()(Size i) const { return i % 3 == 0; }
};
struct Remainder {
  Size rows;
  Size operator()(Size i) const { return i % 7 == 0 ? -1 : i % rows; }
};

TEST(Cpu, ReduceGivesTheSameBitsForAnyNumberOfThreads) {
  const double one = Cpu(1).reduce<Sum>(100000, Harmonic{}).value;
  EXPECT_NEAR(one, 12.090146129863, 1e-9);
  for (const int threads : {2, 3, 7}) EXPECT_EQ(Cpu(threads).reduce<Sum>(100000, Harmonic{}).value, one);
  EXPECT_EQ(Cpu(2).reduce<Sum>(0, Harmonic{}).value, 0);
}

TEST(Cpu, ScanAddsWhatCameBefore) {
  for (const int threads : {1, 3}) {
    for (const Size n : {Size{0}, Size{1}, Size{5000}}) {
      std::vector<std::uint32_t> host(static_cast<std::size_t>(n));
      std::iota(host.begin(), host.end(), 1U);
      Cpu::Buffer<std::uint32_t> in;
      in.upload(host);
      const std::uint32_t total = Cpu(threads).exclusive_scan(Span<const std::uint32_t>(in.span()), in.span());
      EXPECT_EQ(total, static_cast<std::uint32_t>(n * (n + 1) / 2));
      for (Size i = 0; i < n; ++i) ASSERT_EQ(in.span()[i], static_cast<std::uint32_t>(i * (i + 1) / 2));
    }
  }
}

TEST(Cpu, CompactKeepsOrder) {
  for (const int threads : {1, 3}) {
    Cpu::Buffer<Index> out(10000);
    ASSERT_EQ(Cpu(threads).compact(10000, IsThird{}, out.span()), 3334);
    for (Size i = 0; i < 3334; ++i) ASSERT_EQ(out.span()[i], 3 * i);
  }
}

TEST(Cpu, SortIsStable) {
  std::mt19937_64 random(3);
  std::vector<std::uint64_t> keys(20000);
  for (auto& k : keys) k = random() % 1000 + ((random() % 3) << 40);
  std::vector<Index> ids(keys.size());
  std::iota(ids.begin(), ids.end(), 0);
  auto expected = ids;
  std::stable_sort(expected.begin(), expected.end(), [&](Index a, Index b) {
    return keys[static_cast<std::size_t>(a)] < keys[static_cast<std::size_t>(b)];
  });
  for (const int threads : {1, 2, 3}) {
    Cpu::Buffer<std::uint64_t> k;
    Cpu::Buffer<Index> v;
    k.upload(keys);
    v.upload(ids);
    Cpu(threads).sort_by_key(k, v, 48);
    EXPECT_EQ(v.download(), expected);
    EXPECT_TRUE(std::is_sorted(k.span().data(), k.span().data() + k.size()));
  }
}

TEST(Buffer, GrowKeepsItsContent) {
  Cpu::Buffer<int> b;
  b.upload({1, 2, 3});
  b.grow(1000);
  EXPECT_EQ(b.size(), 1000);
  EXPECT_EQ(b.span()[0], 1);
  EXPECT_EQ(b.span()[2], 3);
}

TEST(Rows, HoldEachItemOnceInOrder) {
  for (const int threads : {1, 3, 40}) {
    Rows<Cpu> rows;
    build_rows(Cpu(threads), 10, 5000, Remainder{10}, rows);
    Size seen = 0;
    for (Size r = 0; r < 10; ++r) {
      for (Size i = rows.view().begin(r); i < rows.view().end(r); ++i) {
        const Size item = rows.items.span()[i];
        ASSERT_EQ(Remainder{10}(item), r);
        if (i > rows.view().begin(r)) {
          ASSERT_GT(item, rows.items.span()[i - 1]);
        }
        ++seen;
      }
    }
    EXPECT_EQ(seen, 5000 - 715);
  }
}

TEST(ThreadPool, RunsEachPartOnceRoundAfterRound) {
  par::ThreadPool pool(4);
  std::vector<int> done(100, 0);
  for (int round = 1; round <= 2000; ++round) {
    pool.run(100, [&](Size part) { ++done[static_cast<std::size_t>(part)]; });
    for (const int d : done) ASSERT_EQ(d, round);
  }
  pool.run(0, [](Size) { FAIL(); });
}

TEST(ThreadPool, ThrowsOnWhatAPartThrew) {
  par::ThreadPool pool(3);
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

TEST(ThreadPool, SeveralLiveSideBySide) {
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

TEST(ThreadPool, GoesOnWithTheThreadsThatStarted) {
  if (!test::AllocationWatch::works()) GTEST_SKIP() << "memory never runs out here";
  for (const std::size_t granted : {0U, 1U, 3U}) {
    std::optional<par::ThreadPool> pool;
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

TEST(ThreadPool, HasAMostNumberOfThreads) {
  if (!test::AllocationWatch::works()) GTEST_SKIP() << "would start them";
  const test::AllocationWatch watch(1);
  const par::ThreadPool pool(std::numeric_limits<int>::max());
  EXPECT_EQ(watch.largest(), sizeof(std::thread) * par::ThreadPool::kMaxThreads);
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
