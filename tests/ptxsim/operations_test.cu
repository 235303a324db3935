// SPDX-License-Identifier: Apache-2.0
// Operations of the simulated device against the same code on the host.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "backend/macros.hpp"
#include "ptxsim/device_array.cuh"

namespace tetune::ptxsim {
namespace {

struct Operands {
  u64 a, b, c;
  double x, y, z;
  float f, g;
};

/// Results as bits, in the order in which they are added.
struct Results {
  static constexpr int kMax = 96;
  u64 bits[kMax];
  int count = 0;

  TETUNE_HD void add(u64 value) { bits[count++] = value; }
  TETUNE_HD void add(i64 value) { add(static_cast<u64>(value)); }
  TETUNE_HD void add(i32 value) { add(i64{value}); }
  TETUNE_HD void add(u32 value) { add(u64{value}); }
  TETUNE_HD void add(bool value) { add(value ? u64{1} : u64{0}); }
  /// All NaN are equal.
  TETUNE_HD void add(double value) {
    u64 pattern = 0x7ff8000000000000U;
    if (value == value) memcpy(&pattern, &value, sizeof value);
    add(pattern);
  }
  TETUNE_HD void add(float value) { add(static_cast<double>(value)); }
};

TETUNE_HD void integer_operations(const Operands& o, Results& r) {
  const auto a = static_cast<u32>(o.a);
  const auto b = static_cast<u32>(o.b);
  const auto sa = static_cast<i32>(a);
  const auto sb = static_cast<i32>(b);
  const auto la = static_cast<i64>(o.a);
  const auto lb = static_cast<i64>(o.b);
  const auto ha = static_cast<i16>(a);
  const auto hb = static_cast<i16>(b);
  r.add(a + b);
  r.add(o.a * o.b);
  r.add(b != 0 ? a / b : 0);
  r.add(b != 0 ? a % b : 0);
  r.add(sb > 0 ? sa / sb : 0);
  r.add(sb > 0 ? sa % sb : 0);
  r.add(lb > 0 ? la / lb : i64{0});
  r.add(lb > 0 ? la % lb : i64{0});
  r.add(o.b != 0 ? o.a / o.b : u64{0});
  r.add(o.b != 0 ? o.a % o.b : u64{0});
  r.add(static_cast<u64>((static_cast<__int128>(la) * lb) >> 64));
  r.add(static_cast<u64>((static_cast<unsigned __int128>(o.a) * o.b) >> 64));
  r.add(a >> (b & 31U));
  r.add(sa >> (b & 31U));
  r.add(a << (b & 31U));
  r.add(o.a >> (b & 63U));
  r.add(la >> (b & 63U));
  r.add(o.a << (b & 63U));
  r.add(static_cast<i32>(static_cast<i16>(ha * hb)));
  r.add(static_cast<i32>(ha < hb ? ha : hb));
  r.add(static_cast<u32>(static_cast<u8>(a ^ b)));
  r.add(static_cast<i32>(static_cast<i8>(a)));
  r.add((a & b) | (~a & static_cast<u32>(o.c)));
  r.add(sa < sb ? sa : sb);
  r.add(la > lb ? o.a : o.b);
  r.add(sa < 0 ? -i64{sa} : i64{sa});
  r.add((o.a >> 13U & 0x7ffU) + (o.b << 40U >> 52U));
  r.add(i64{sa} * sb + la);
  r.add(u64{a} * b + o.c);
}

TETUNE_HD void float_operations(const Operands& o, Results& r) {
  for (const double value : {o.x + o.y, o.x - o.y, o.x * o.y, o.x / o.y, std::sqrt(o.x), 1 / o.x, o.x * o.y + o.z,
                             std::fma(o.x, o.y, o.z), std::fabs(o.x), -o.x, o.x < o.y ? o.x : o.y, std::floor(o.x),
                             std::trunc(o.y), std::rint(o.z), std::ceil(o.x)}) {
    r.add(value);
  }
  // Of two zeros either may be the result; the sum is positive.
  r.add(std::fmin(o.x, o.y) + 0.0);
  r.add(std::fmax(o.x, o.y) + 0.0);
  for (const float value : {o.f + o.g, o.f * o.g, o.f / o.g, std::sqrt(o.f), o.f - o.g}) r.add(value);
  r.add(o.x < o.y);
  r.add(!(o.x < o.y));
  r.add(o.x != o.y);
  r.add(o.x == o.y);
  r.add(o.x >= o.y && o.y <= o.z);
  r.add(!(o.x > o.y) || o.z > o.x);
  r.add(std::signbit(o.x));
  r.add(std::isnan(o.y) || std::isinf(o.z));
}

TETUNE_HD void conversions(const Operands& o, Results& r) {
  const auto a = static_cast<u32>(o.a);
  r.add(static_cast<double>(static_cast<i32>(a)));
  r.add(static_cast<double>(a));
  r.add(static_cast<double>(static_cast<i64>(o.a)));
  r.add(static_cast<double>(o.a));
  r.add(static_cast<double>(o.f));
  r.add(static_cast<float>(o.x));
  r.add(static_cast<float>(static_cast<i32>(a)));
  r.add(static_cast<float>(static_cast<i64>(o.a)));
  // Only values of which the host defines the result.
  r.add(std::fabs(o.x) < 2e9 ? static_cast<i32>(o.x) : 0);
  r.add(std::fabs(o.x) < 9e18 ? static_cast<i64>(o.x) : i64{0});
  r.add(o.x >= 0 && o.x < 4e9 ? static_cast<u32>(o.x) : 0U);
}

/// Intrinsics of the device, and what they mean.
TETUNE_HD void intrinsics(const Operands& o, Results& r) {
  const auto a = static_cast<u32>(o.a);
  const auto b = static_cast<u32>(o.b);
#if defined(__CUDA_ARCH__)
  r.add(__popc(a));
  r.add(__popcll(o.a));
  r.add(__clz(static_cast<int>(a)));
  r.add(__clzll(static_cast<long long>(o.a)));
  r.add(__brev(a));
  r.add(u64{__brevll(o.a)});
  r.add(__ffs(static_cast<int>(a)));
  r.add(__byte_perm(a, b, b & 0x7777U));
  r.add(__funnelshift_l(a, b, a));
  r.add(__funnelshift_r(a, b, b));
  r.add(__umulhi(a, b));
  r.add(__mulhi(static_cast<int>(a), static_cast<int>(b)));
#else
  const auto reversed = [](u64 x, int bits) {
    u64 y = 0;
    for (int k = 0; k < bits; ++k) y |= (x >> k & 1U) << (bits - 1 - k);
    return y;
  };
  const u64 both = a | u64{b} << 32U;
  u32 permuted = 0;
  for (u32 k = 0; k < 4; ++k) permuted |= (both >> (8 * (b >> (4 * k) & 7U)) & 0xffU) << (8 * k);
  r.add(__builtin_popcount(a));
  r.add(__builtin_popcountll(o.a));
  r.add(a != 0 ? __builtin_clz(a) : 32);
  r.add(o.a != 0 ? __builtin_clzll(o.a) : 64);
  r.add(static_cast<u32>(reversed(a, 32)));
  r.add(reversed(o.a, 64));
  r.add(__builtin_ffs(static_cast<int>(a)));
  r.add(permuted);
  r.add(static_cast<u32>((both << (a & 31U)) >> 32U));
  r.add(static_cast<u32>(both >> (b & 31U)));
  r.add(static_cast<u32>((u64{a} * b) >> 32U));
  r.add(static_cast<i32>((i64{static_cast<i32>(a)} * static_cast<i32>(b)) >> 32));
#endif
}

TETUNE_HD void evaluate(int group, const Operands& o, Results& r) {
  r.count = 0;
  if (group == 0) integer_operations(o, r);
  if (group == 1) float_operations(o, r);
  if (group == 2) conversions(o, r);
  if (group == 3) intrinsics(o, r);
}

__global__ void evaluate_kernel(int group, const Operands* operands, Results* results, int n) {
  const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < n) evaluate(group, operands[i], results[i]);
}

std::vector<Operands> many_operands(int n) {
  std::mt19937_64 random(3);
  const auto integer = [&random]() -> u64 {
    const u64 x = random();
    switch (random() % 4) {
      case 0:
        return x;
      case 1:
        return x >> (random() % 64);
      case 2:
        return 0 - (x >> (32 + random() % 32));
      default:
        return x % 100;
    }
  };
  const auto real = [&random] {
    constexpr double kSpecial[] = {0.0,   -0.0,   1.0,          -1.5,          NAN, INFINITY, -INFINITY,
                                   1e300, 1e-310, 2147483648.5, -2147483649.5, 0.5, 2.5};
    const u64 x = random();
    double any = 0;
    std::memcpy(&any, &x, sizeof any);
    if (std::isnan(any)) any = NAN;  // not a signaling one
    switch (random() % 4) {
      case 0:
        return kSpecial[random() % std::size(kSpecial)];
      case 1:
        return any;
      case 2:
        return static_cast<double>(static_cast<i64>(x)) / 1e10;
      default:
        return static_cast<double>(x % 1000) / 8 - 50;
    }
  };
  std::vector<Operands> all(static_cast<std::size_t>(n));
  for (Operands& o : all) {
    o = {integer(),
         integer(),
         integer(),
         real(),
         real(),
         real(),
         static_cast<float>(real()),
         static_cast<float>(real())};
  }
  return all;
}

class Operation : public testing::TestWithParam<int> {};

TEST_P(Operation, IsThatOfTheHost) {
  constexpr int kCount = 5000;
  constexpr unsigned kBlock = 96;
  const std::vector<Operands> operands = many_operands(kCount);
  const DeviceArray<Operands> in(operands);
  const DeviceArray<Results> out(kCount);
  evaluate_kernel<<<(kCount + kBlock - 1) / kBlock, kBlock>>>(GetParam(), in.data(), out.data(), kCount);
  const Results* const results = out.data();  // the simulated memory is the process's own
  for (int i = 0; i < kCount; ++i) {
    Results expected;
    evaluate(GetParam(), operands[static_cast<std::size_t>(i)], expected);
    ASSERT_EQ(results[i].count, expected.count);
    for (int k = 0; k < expected.count; ++k) {
      ASSERT_EQ(results[i].bits[k], expected.bits[k]) << "operation " << k << " on operands " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Groups, Operation, testing::Range(0, 4));

// -- Warps and blocks --

__global__ void exchange_kernel(const u32* in, u32* out) {
  const u32 t = threadIdx.x;
  const u32 x = in[t];
  constexpr u32 kAll = ~0U;
  u32 r = __shfl_up_sync(kAll, x, 3) * 3;
  r += __shfl_down_sync(kAll, x, 5) * 5;
  r += __shfl_xor_sync(kAll, x, 9) * 7;
  r += __shfl_sync(kAll, x, static_cast<int>(t * 7)) * 11;
  r += __shfl_sync(kAll, x, static_cast<int>(t), 8) * 13;
  r += __ballot_sync(kAll, static_cast<int>(x & 1U));
  r += __any_sync(kAll, x == 7) + 2 * __all_sync(kAll, x < 1000);
  r ^= __match_any_sync(kAll, x & 3U);
  if ((t & 1U) != 0) {
    r += __ballot_sync(0xaaaaaaaaU, static_cast<int>(x & 2U));
  } else {
    r += 17 * __shfl_sync(0x55555555U, x, 4);
  }
  __syncwarp();
  out[t] = r;
}

u32 exchanged(const std::vector<u32>& in, u32 t) {
  u32 odd = 0, any = 0, all = 1, match = 0, second = 0;
  for (u32 k = 0; k < kLanes; ++k) {
    odd |= (in[k] & 1U) << k;
    any |= in[k] == 7 ? 1 : 0;
    all &= in[k] < 1000 ? 1 : 0;
    match |= ((in[k] ^ in[t]) & 3U) == 0 ? 1U << k : 0;
    if ((k & 1U) != 0) second |= (in[k] & 2U) != 0 ? 1U << k : 0;
  }
  u32 r = in[t < 3 ? t : t - 3] * 3 + in[t + 5 > 31 ? t : t + 5] * 5 + in[t ^ 9U] * 7 + in[t * 7 % 32] * 11;
  r += in[t / 8 * 8 + t % 8] * 13 + odd + any + 2 * all;
  return (r ^ match) + ((t & 1U) != 0 ? second : 17 * in[4]);
}

TEST(WarpOperations, ExchangeValuesBetweenLanes) {
  std::vector<u32> in(kLanes);
  for (u32 t = 0; t < kLanes; ++t) in[t] = (t * 37 + 11) % 50;
  const DeviceArray<u32> from(in);
  const DeviceArray<u32> to(kLanes);
  exchange_kernel<<<1, kLanes>>>(from.data(), to.data());
  for (u32 t = 0; t < kLanes; ++t) EXPECT_EQ(to.data()[t], exchanged(in, t)) << t;
}

/// Groups of four lanes, of which each takes its own number of turns.
__global__ void exchange_in_groups_kernel(const u32* in, u32* out) {
  const u32 t = threadIdx.x;
  const u32 group = 0xfU << (t / 4 * 4);
  u32 x = in[t];
  for (u32 turn = 0; turn <= t / 4 % 3; ++turn) {
    x = x * 3 + __shfl_sync(group, x, static_cast<int>(t + 1), 4);
    x += 5 * __ballot_sync(group, static_cast<int>(x & 1U)) + __any_sync(group, (x & 14U) == 0);
    __syncwarp(group);
  }
  out[t] = x + __match_any_sync(group, x & 1U);
}

/// exchange_in_groups_kernel for one group.
std::array<u32, 4> exchanged_in_group(std::array<u32, 4> x, u32 group) {
  for (u32 turn = 0; turn <= group % 3; ++turn) {
    const std::array<u32, 4> old = x;
    u32 odd = 0, any = 0;
    for (u32 k = 0; k < 4; ++k) {
      x[k] = old[k] * 3 + old[(k + 1) % 4];
      odd |= (x[k] & 1U) << (4 * group + k);
    }
    for (u32 k = 0; k < 4; ++k) any |= (x[k] & 14U) == 0 ? 1 : 0;
    for (u32 k = 0; k < 4; ++k) x[k] += 5 * odd + any;
  }
  std::array<u32, 4> result = x;
  for (u32 k = 0; k < 4; ++k) {
    for (u32 other = 0; other < 4; ++other) result[k] += ((x[k] ^ x[other]) & 1U) == 0 ? 1U << (4 * group + other) : 0;
  }
  return result;
}

TEST(WarpOperations, ExchangeValuesWithinGroupsThatDiverge) {
  std::vector<u32> in(kLanes);
  for (u32 t = 0; t < kLanes; ++t) in[t] = (t * 37 + 11) % 50;
  const DeviceArray<u32> from(in);
  const DeviceArray<u32> to(kLanes);
  exchange_in_groups_kernel<<<1, kLanes>>>(from.data(), to.data());
  for (u32 group = 0; group < kLanes / 4; ++group) {
    const auto expected =
        exchanged_in_group({in[4 * group], in[4 * group + 1], in[4 * group + 2], in[4 * group + 3]}, group);
    for (u32 k = 0; k < 4; ++k) EXPECT_EQ(to.data()[4 * group + k], expected[k]) << group << ' ' << k;
  }
}

__global__ void block_kernel(const u32* in, u32* out) {
  __shared__ u32 values[256];
  __shared__ u32 bins[8];
  const u32 t = threadIdx.x;
  if (t < 8) bins[t] = 0;
  values[t] = in[blockIdx.x * 256 + t];
  __syncthreads();
  atomicAdd(&bins[values[t] & 7U], 1);
  for (u32 half = 128; half > 0; half /= 2) {
    __syncthreads();
    if (t < half) values[t] += values[t + half];
  }
  __syncthreads();
  const int any = __syncthreads_or(t == 77 ? 1 : 0);
  const int count = __syncthreads_count(t % 3 == 0 ? 1 : 0);
  if (t < 8) out[blockIdx.x * 10 + t] = bins[t];
  if (t == 8) out[blockIdx.x * 10 + 8] = values[0];
  if (t == 9) out[blockIdx.x * 10 + 9] = static_cast<u32>(any * 1000 + count);
}

TEST(Blocks, ShareMemoryAndBarriers) {
  std::vector<u32> in(1024);
  for (u32 t = 0; t < 1024; ++t) in[t] = (t * 7919 + 5) % 1000;
  const DeviceArray<u32> from(in);
  const DeviceArray<u32> to(40);
  block_kernel<<<4, 256>>>(from.data(), to.data());
  for (u32 b = 0; b < 4; ++b) {
    u32 expected[10] = {};
    for (u32 t = 0; t < 256; ++t) {
      expected[8] += in[b * 256 + t];
      ++expected[in[b * 256 + t] & 7U];
    }
    expected[9] = 1000 + 86;
    for (u32 k = 0; k < 10; ++k) EXPECT_EQ(to.data()[b * 10 + k], expected[k]) << b << ", " << k;
  }
}

}  // namespace
}  // namespace tetune::ptxsim
