// SPDX-License-Identifier: Apache-2.0
// The primitives of the CUDA backend against their contract in backend/concept.hpp. Skipped where there is no GPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "backend/atomic.hpp"
#include "backend/cuda.cuh"

namespace tetune::backend {
namespace cuda_primitives_test {

struct Reciprocal {
  TETUNE_HD Sum<double> operator()(Size i) const { return {1.0 / static_cast<double>(i + 1)}; }
};
/// With much work per item: few items are spread over warps.
struct HeavyReciprocal : Reciprocal {
  static constexpr Size kGrain = 1;
};
/// The largest of 50 values that depend on i, its index, and their sum; each thread of the team has some of them, and
/// writes its part of the sum to shared memory.
struct LargestOfItem {
  static constexpr Size kGrain = 1;
  static constexpr int kValues = 50;
  struct Shared {
    Size sum[Warp::kSize];
  };
  struct Result {
    double largest = 0;
    Size index = 0, sum = 0;
    TETUNE_HD void merge(const Result& other) {
      largest += other.largest;
      index += other.index;
      sum += other.sum;
    }
  };
  TETUNE_HD static int value(Size i, int k) { return static_cast<int>((i * 31 + k * 17) % 23); }
  TETUNE_HD Result operator()(Size i) const {
    Shared shared;
    return (*this)(SingleThread(), shared, i);
  }
  template <class Team>
  TETUNE_HD Result operator()(const Team& team, Shared& shared, Size i) const {
    IndexedMax largest{-1, -1};
    shared.sum[team.rank()] = 0;
    for (int k = team.rank(); k < kValues; k += Team::kSize) {
      largest.add(value(i, k), k);
      shared.sum[team.rank()] += value(i, k);
    }
    largest = team.merge(largest);
    const bool is_owner = largest.index % Team::kSize == team.rank();
    const int found = team.broadcast(is_owner ? largest.index : -1, largest.index % Team::kSize);
    team.sync();
    Result result{largest.value, team.any(is_owner) ? found : -1, 0};
    for (int t = 0; t < Team::kSize; ++t) result.sum += shared.sum[t];
    return result;
  }
};
struct IsThird {
  TETUNE_HD bool operator()(Size i) const { return i % 3 == 0; }
};
/// Each step reads what the one before wrote for another item.
struct AddNeighbor {
  Span<Size> even, odd;
  TETUNE_HD void operator()(Size step, Size i) const {
    const Span<Size> from = step % 2 == 0 ? even : odd;
    (step % 2 == 0 ? odd : even)[i] = from[i] + from[(i + 1) % from.size()];
  }
};
/// Each item needs the result of the one before it.
struct AddToItemBefore {
  struct Shared {
    Size before;
  };
  Span<Size> sums;
  Span<std::uint8_t> finished;
  template <class Team>
  TETUNE_HD bool is_ready(const Team& team, Size i) const {
    return i == 0 || team.rank() > 0 || load_shared(finished[i - 1]) == 1;
  }
  template <class Team>
  TETUNE_HD void operator()(const Team& team, Shared& shared, Size i) const {
    if (team.rank() == Team::kSize - 1) shared.before = i == 0 ? 0 : load_shared(sums[i - 1]);
    team.sync();
    if (team.rank() == 0) store_shared(sums[i], shared.before + i);
  }
  TETUNE_HD void finish(Size i) const { store_shared(finished[i], std::uint8_t{1}); }
};
struct AddSquare {
  Span<Size> out;
  TETUNE_HD void operator()(Size i) const { out[i] += i * i; }
};

/// The merges of reduce() in its order: a tree over chunks of 128, repeated until one is left.
double sum_in_chunks(std::vector<double> values) {
  constexpr std::size_t kChunk = 128;
  do {
    std::vector<double> sums;
    for (std::size_t begin = 0; begin < values.size(); begin += kChunk) {
      double chunk[kChunk] = {};
      std::copy(values.begin() + static_cast<std::ptrdiff_t>(begin),
                values.begin() + static_cast<std::ptrdiff_t>(std::min(begin + kChunk, values.size())), chunk);
      for (std::size_t half = kChunk / 2; half > 0; half /= 2) {
        for (std::size_t t = 0; t < half; ++t) chunk[t] += chunk[t + half];
      }
      sums.push_back(chunk[0]);
    }
    values = std::move(sums);
  } while (values.size() > 1);
  return values[0];
}

class CudaPrimitives : public testing::TestWithParam<Size> {
 protected:
  void SetUp() override {
    int devices = 0;
    if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) GTEST_SKIP() << "no GPU";
    cuda.emplace(std::size_t{64} << 20U);
  }
  Size n() const { return GetParam(); }
  std::optional<Cuda> cuda;
};

TEST_P(CudaPrimitives, ForEachCallsEachIndexOnce) {
  Cuda::Buffer<Size> out(*cuda, n());
  cuda->fill(out.span(), Size{5});
  cuda->for_each(n(), AddSquare{out.span()});
  const std::vector<Size> host = out.download();
  for (Size i = 0; i < n(); ++i) ASSERT_EQ(host[to_size_t(i)], 5 + i * i);
}

TEST_P(CudaPrimitives, StepsFollowEachOther) {
  std::vector<Size> expected(to_size_t(n()));
  std::iota(expected.begin(), expected.end(), 1);
  Cuda::Buffer<Size> even, odd(*cuda, n());
  even.upload(*cuda, expected);
  cuda->for_each_step(4, n(), AddNeighbor{even, odd});
  for (int step = 0; step < 4; ++step) {
    auto next = expected;
    std::rotate(next.begin(), next.begin() + 1, next.end());
    for (std::size_t i = 0; i < next.size(); ++i) expected[i] += next[i];
  }
  EXPECT_EQ(even.download(), expected);
}

TEST_P(CudaPrimitives, ItemsInOrderFollowThoseTheyNeed) {
  const Size items = std::min<Size>(n(), 1000);
  for (int run = 0; run < 2; ++run) {
    Cuda::Buffer<Size> sums(*cuda, items);
    Cuda::Buffer<std::uint8_t> finished(*cuda, items);
    cuda->fill(finished.span(), std::uint8_t{0});
    cuda->for_each_in_order(items, AddToItemBefore{sums.span(), finished.span()});
    const std::vector<Size> host = sums.download();
    for (Size i = 0; i < items; ++i) ASSERT_EQ(host[to_size_t(i)], i * (i + 1) / 2);
  }
}

TEST_P(CudaPrimitives, ReduceMergesInItsOrder) {
  std::vector<double> values(to_size_t(n()));
  for (Size i = 0; i < n(); ++i) values[to_size_t(i)] = 1.0 / static_cast<double>(i + 1);
  EXPECT_EQ(cuda->reduce<Sum<double>>(n(), Reciprocal{}).value, sum_in_chunks(values));
  EXPECT_EQ(cuda->reduce<Sum<double>>(n(), HeavyReciprocal{}).value, sum_in_chunks(values));
}

/// More results than arrive with one wait.
TEST_P(CudaPrimitives, PendingResultsAreThoseOfTheirReductions) {
  using Result = LargestOfItem::Result;
  const auto items = [this](int k) { return std::min<Size>(n(), 200) / (k % 3 + 1) + k % 2; };
  std::vector<Pending<Result>> pending;
  Cuda::Buffer<Index32> ids(*cuda, n());
  for (int k = 0; k < 150; ++k) {
    pending.push_back(cuda->reduce_async<Result>(items(k), LargestOfItem{}));
    if (k == 50) cuda->compact(n(), IsThird{}, ids.span());
  }
  for (int k = 0; k < 150; ++k) {
    Result expected;
    for (Size i = 0; i < items(k); ++i) expected.merge(LargestOfItem{}(i));
    EXPECT_EQ(pending[to_size_t(k)].get().sum, expected.sum);
  }
}

TEST_P(CudaPrimitives, TeamsFindWhatASingleThreadFinds) {
  const auto found = cuda->reduce<LargestOfItem::Result>(n(), LargestOfItem{});
  LargestOfItem::Result expected;
  for (Size i = 0; i < n(); ++i) expected.merge(LargestOfItem{}(i));
  EXPECT_EQ(found.largest, expected.largest);
  EXPECT_EQ(found.index, expected.index);
  EXPECT_EQ(found.sum, expected.sum);
}

TEST_P(CudaPrimitives, ScanSumsThePrecedingElements) {
  std::vector<std::uint32_t> host(to_size_t(n()));
  std::iota(host.begin(), host.end(), 1U);
  std::vector<std::uint32_t> expected(host.size());
  std::exclusive_scan(host.begin(), host.end(), expected.begin(), 0U);
  Cuda::Buffer<std::uint32_t> in;
  in.upload(*cuda, host);
  Cuda::Buffer<std::uint32_t> out(*cuda, n());
  const std::uint32_t sum = expected.back() + host.back();
  EXPECT_EQ(cuda->exclusive_scan(Span<const std::uint32_t>(in.span()), out.span()), sum);
  EXPECT_EQ(cuda->exclusive_scan_async(Span<const std::uint32_t>(in.span()), in.span()).get(), sum);
  EXPECT_EQ(out.download(), expected);
  EXPECT_EQ(in.download(), expected);
}

TEST_P(CudaPrimitives, CompactKeepsOrder) {
  Cuda::Buffer<Index32> out(*cuda, n());
  const Size kept = cuda->compact(n(), IsThird{}, out.span());
  ASSERT_EQ(kept, (n() + 2) / 3);
  cuda->fill(Span<Index32>(out.span().data() + kept, n() - kept), Index32{0});
  const std::vector<Index32> host = out.download();
  for (Size i = 0; i < kept; ++i) ASSERT_EQ(host[to_size_t(i)], 3 * i);
}

/// Of a size that scans add up in fewer rows.
struct Totals {
  std::uint32_t items = 0;
  std::uint32_t digits[4] = {};
  TETUNE_HD friend Totals operator+(Totals x, const Totals& y) {
    x.items += y.items;
    for (int k = 0; k < 4; ++k) x.digits[k] += y.digits[k];
    return x;
  }
};
struct EvaluateTotals {
  TETUNE_HD Totals operator()(Size i) const {
    Totals t;
    t.items = static_cast<std::uint32_t>(i);
    for (int k = 0; k < 4; ++k, i /= 10) t.digits[k] = static_cast<std::uint32_t>(i % 10);
    return t;
  }
};
struct ListWithSum {
  static constexpr Size kGrain = 32;
  Span<Index32> items;
  Span<Totals> before;
  TETUNE_HD void operator()(Size i, Size rank, const Totals& sum) const {
    items[rank] = static_cast<Index32>(i);
    before[rank] = sum;
  }
};

/// Twice, so that the second scan meets what the first one left.
TEST_P(CudaPrimitives, CompactAndSumIsTheScanOfWhatIsKept) {
  Cuda::Buffer<Index32> out(*cuda, n());
  Cuda::Buffer<Totals> sums(*cuda, n());
  for (int k = 0; k < 2; ++k) {
    const auto all = cuda->compact_and_sum(n(), IsThird{}, EvaluateTotals{}, ListWithSum{out.span(), sums.span()});
    ASSERT_EQ(all.count, (n() + 2) / 3);
    std::vector<Index32> ids(all.count);
    std::vector<Totals> before(all.count);
    Cuda::Memory::download(ids.data(), out.span().data(), ids.size() * sizeof(Index32));
    Cuda::Memory::download(before.data(), sums.span().data(), before.size() * sizeof(Totals));
    Totals expected;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      ASSERT_EQ(ids[i], static_cast<Index32>(3 * i));
      ASSERT_EQ(before[i].items, expected.items) << i;
      for (int digit = 0; digit < 4; ++digit) ASSERT_EQ(before[i].digits[digit], expected.digits[digit]) << i;
      expected = expected + EvaluateTotals{}(ids[i]);
    }
    EXPECT_EQ(all.sum.items, expected.items);
    EXPECT_EQ(all.sum.digits[3], expected.digits[3]);
  }
}

/// Both items of a pair, until one of them is placed.
struct IsWholePair {
  Span<std::uint8_t> is_left;
  TETUNE_HD bool operator()(Size i) const {
    return load_shared(is_left[i - i % 2]) != 0 && load_shared(is_left[i - i % 2 + 1]) != 0;
  }
};
struct TakeItem {
  static constexpr Size kGrain = 32;
  Span<std::uint8_t> is_left;
  TETUNE_HD void operator()(Size i, Size, const Totals&) const { store_shared(is_left[i], 0); }
};

TEST_P(CudaPrimitives, CompactAndSumEvaluatesPairsBeforeOneIsPlaced) {
  Cuda::Buffer<std::uint8_t> is_left(*cuda, 2 * n());
  cuda->fill(is_left.span(), std::uint8_t{1});
  const auto all =
      cuda->compact_and_sum(2 * n(), IsWholePair{is_left.span()}, EvaluateTotals{}, TakeItem{is_left.span()});
  EXPECT_EQ(all.count, 2 * n());
}

/// With several rows per tile.
TEST(CudaScans, OfManyItems) {
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) GTEST_SKIP() << "no GPU";
  const Cuda cuda(std::size_t{64} << 20U);
  constexpr Size kItems = 460001;
  Cuda::Buffer<Index32> out(cuda, kItems);
  ASSERT_EQ(cuda.compact(kItems, IsThird{}, out.span()), (kItems + 2) / 3);
  std::vector<Index32> ids(to_size_t((kItems + 2) / 3));
  Cuda::Memory::download(ids.data(), out.span().data(), ids.size() * sizeof(Index32));
  for (std::size_t i = 0; i < ids.size(); ++i) ASSERT_EQ(ids[i], static_cast<Index32>(3 * i));
}

TEST_P(CudaPrimitives, SortIsStableAndReadsTheLowestBits) {
  std::mt19937_64 random(3);
  std::vector<std::uint64_t> keys(to_size_t(n()));
  for (auto& k : keys) k = (random() % 1000) << 30U | (random() % 3) << 40U;
  constexpr std::uint64_t kMask = (std::uint64_t{1} << 40U) - 1;
  std::vector<Index32> expected(keys.size());
  std::iota(expected.begin(), expected.end(), 0);
  Cuda::Buffer<std::uint64_t> k;
  Cuda::Buffer<Index32> v;
  k.upload(*cuda, keys);
  v.upload(*cuda, expected);
  std::stable_sort(expected.begin(), expected.end(),
                   [&](Index32 a, Index32 b) { return (keys[to_size_t(a)] & kMask) < (keys[to_size_t(b)] & kMask); });
  cuda->sort_by_key(k, v, 40);
  EXPECT_EQ(v.download(), expected);
}

INSTANTIATE_TEST_SUITE_P(Sizes, CudaPrimitives, testing::Values(1, 2, 127, 128, 129, 1000, 5000, 17000, 70000));

}  // namespace cuda_primitives_test
}  // namespace tetune::backend
