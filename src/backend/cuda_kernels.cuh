// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "backend/macros.hpp"
#include "backend/results.hpp"
#include "backend/span.hpp"
#include "backend/team.hpp"

/// The kernels of the CUDA backend (backend/cuda.cuh).
namespace tetune::backend {

template <class F>
__global__ void for_each_kernel(Size n, F f) {
  const Size i = Size{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i < n) f(i);
}

/// All steps in one block.
template <class F, int kMaxThreads>
__global__ void __launch_bounds__(kMaxThreads) steps_kernel(Size steps, Size n, F f) {
  for (Size step = 0; step < steps; ++step) {
    if (threadIdx.x < n) f(step, Size{threadIdx.x});
    __syncthreads();
  }
}

/// kThreads consecutive threads of a warp as a team (backend/team.hpp).
template <int kThreads>
class PartOfWarp {
 public:
  static constexpr int kSize = kThreads;
  template <int kPart>
  using Part = PartOfWarp<(kPart < kThreads ? kPart : kThreads)>;

  TETUNE_HD static int rank() {
#if defined(__CUDA_ARCH__)
    return int(threadIdx.x) % kSize;
#else
    return 0;
#endif
  }
  TETUNE_HD static bool any([[maybe_unused]] bool condition) {
#if defined(__CUDA_ARCH__)
    return __any_sync(threads(), condition) != 0;
#else
    return condition;
#endif
  }
  template <class T>
  TETUNE_HD static T merge(T value) {
    for (int distance = kSize / 2; distance > 0; distance /= 2) value.merge(broadcast(value, rank() ^ distance));
    return value;
  }
  template <class T>
  TETUNE_HD static T broadcast(const T& value, [[maybe_unused]] int rank) {
#if defined(__CUDA_ARCH__)
    static_assert(std::is_trivially_copyable_v<T>);
    constexpr int kWords = (sizeof(T) + sizeof(unsigned) - 1) / sizeof(unsigned);
    unsigned words[kWords]{};
    memcpy(words, &value, sizeof(T));
    for (int k = 0; k < kWords; ++k) words[k] = __shfl_sync(threads(), words[k], rank, kSize);
    T result;
    memcpy(&result, words, sizeof(T));
    return result;
#else
    return value;
#endif
  }
  TETUNE_HD static void sync() {
#if defined(__CUDA_ARCH__)
    __syncwarp(threads());
#endif
  }

 private:
#if defined(__CUDA_ARCH__)
  /// The lanes of the team.
  __device__ static unsigned threads() {
    constexpr unsigned kFirst = ~0U >> (32 - kSize);
    return kFirst << (threadIdx.x % 32 / kSize * kSize);
  }
#endif
};
using Warp = PartOfWarp<32>;

/// A block of one warp, or of the teams of one that there are items for.
template <class F>
__global__ void __launch_bounds__(Warp::kSize) team_kernel(Size n, F f) {
  using Team = PartOfWarp<kTeamSizeOf<F>>;
  constexpr unsigned kTeams = Warp::kSize / Team::kSize;
  __shared__ alignas(16) unsigned char shared[kTeams][sizeof(typename F::Shared)];
  const unsigned team = threadIdx.x / Team::kSize;
  const Size i = Size{blockIdx.x} * (blockDim.x / Team::kSize) + team;
  if (i < n) f(Team(), *reinterpret_cast<typename F::Shared*>(shared[team]), i);
}

/// Stores and loads what other blocks of the same launch load and store.
template <class T>
__device__ void store_volatile(T* to, const T& value) {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % sizeof(unsigned) == 0);
  constexpr int kWords = sizeof(T) / sizeof(unsigned);
  unsigned words[kWords];
  memcpy(words, &value, sizeof(T));
  volatile unsigned* const memory = reinterpret_cast<unsigned*>(to);
  for (int k = 0; k < kWords; ++k) memory[k] = words[k];
}
template <class T>
__device__ T load_volatile(const T* from) {
  constexpr int kWords = sizeof(T) / sizeof(unsigned);
  unsigned words[kWords];
  const volatile unsigned* const memory = reinterpret_cast<const unsigned*>(from);
  for (int k = 0; k < kWords; ++k) words[k] = memory[k];
  T value;
  memcpy(&value, words, sizeof(T));
  return value;
}

/// Results that are merged at a time, by a tree of fixed shape, so that each run yields the same bits.
inline constexpr int kMergeChunk = 128;

/// Called by a block whose stores of a result are to be counted. Returns whether it is the last of `count` blocks,
/// which then reads the results of all. `arrived` is 0 before and after.
__device__ inline bool is_last_to_store(unsigned* arrived, unsigned count) {
  __shared__ bool is_last;
  __threadfence();
  __syncthreads();
  if (threadIdx.x == 0) is_last = atomicInc(arrived, count - 1) == count - 1;
  __syncthreads();
  if (is_last) __threadfence();
  return is_last;
}

/// The levels of a reduction above its items: `partial` holds the results of all levels but the last one after the
/// other, `arrived` the number of blocks that stored theirs, per kMergeChunk results of each level.
template <class R>
struct MergeLevels {
  R* partial;
  unsigned* arrived;
  R* result;

  /// Called by a block of kThreads with the items of a chunk in `shared`. The last of kMergeChunk consecutive blocks to
  /// store its result merges theirs in the same way, as one block of the next level, until one result is left.
  template <int kThreads>
  __device__ void merge(R* shared, unsigned chunk, unsigned chunks) const {
    R* stored = partial;
    unsigned* count = arrived;
    for (;;) {
#pragma unroll
      for (int half = kMergeChunk / 2; half > 0; half /= 2) {
        __syncthreads();
#pragma unroll
        for (int t = int(threadIdx.x); t < half; t += kThreads) shared[t].merge(shared[t + half]);
      }
      const unsigned group = chunk / kMergeChunk;
      const unsigned first = group * kMergeChunk;
      const unsigned size = chunks - first < kMergeChunk ? chunks - first : kMergeChunk;
      if (threadIdx.x == 0) store_volatile(chunks > 1 ? &stored[chunk] : result, shared[0]);
      if (chunks == 1 || !is_last_to_store(&count[group], size)) return;
      load<kThreads>(shared, stored, first, first + size);
      stored += chunks;
      chunks = (chunks + kMergeChunk - 1) / kMergeChunk;
      count += chunks;
      chunk = group;
    }
  }

  /// Loads a chunk of results that other blocks stored.
  template <int kThreads>
  __device__ static void load(R* shared, const R* from, Size first, Size end) {
    for (int t = int(threadIdx.x); t < kMergeChunk; t += kThreads) {
      R r{};
      if (first + t < end) r.merge(load_volatile(&from[first + t]));
      shared[t] = r;
    }
  }
};

/// Each block evaluates and merges one chunk. One item per thread, as there may be too few items to occupy a GPU.
template <class R, class F>
__global__ void __launch_bounds__(kMergeChunk) reduce_kernel(Size n, F f, MergeLevels<R> levels) {
  __shared__ alignas(16) unsigned char storage[sizeof(R) * kMergeChunk];
  R* shared = reinterpret_cast<R*>(storage);
  const Size i = Size{blockIdx.x} * kMergeChunk + threadIdx.x;
  R r{};
  if (i < n) r.merge(f(i));
  shared[threadIdx.x] = r;
  levels.template merge<kMergeChunk>(shared, blockIdx.x, gridDim.x);
}

/// The memory of a block that evaluates, and then merges.
template <class R, class F>
inline constexpr std::size_t kSpreadBytes = sizeof(R) * kMergeChunk;
template <class R, class F>
requires TeamKernel<F>
inline constexpr std::size_t kSpreadBytes<R, F> =
    std::max(sizeof(R) * kMergeChunk, sizeof(typename F::Shared) * (Warp::kSize / kTeamSizeOf<F>));

/// The same result for kernels of much work: a block is a warp, which evaluates `each` items, a power of two, by its
/// first lanes or by teams, and stores their results in `items`. The last block to store those of a chunk merges them.
/// `arrived` holds the number of these blocks per chunk.
template <class R, class F>
__global__ void __launch_bounds__(Warp::kSize)
    spread_reduce_kernel(Size n, unsigned each, F f, R* items, unsigned* arrived, MergeLevels<R> levels) {
  __shared__ alignas(16) unsigned char storage[kSpreadBytes<R, F>];
  const Size first = Size{blockIdx.x} * each;
  if constexpr (TeamKernel<F>) {
    using Team = PartOfWarp<kTeamSizeOf<F>>;
    using Shared = typename F::Shared;
    const unsigned team = threadIdx.x / Team::kSize;
    const Size i = first + team;
    if (team < each && i < n) {
      const R r = f(Team(), reinterpret_cast<Shared*>(storage)[team], i);
      if (Team::rank() == 0) store_volatile(&items[i], r);
    }
  } else {
    const Size i = first + threadIdx.x;
    if (threadIdx.x < each && i < n) store_volatile(&items[i], f(i));
  }
  const unsigned chunk = static_cast<unsigned>(first / kMergeChunk);
  const Size begin = Size{chunk} * kMergeChunk;
  const Size end = begin + kMergeChunk < n ? begin + kMergeChunk : n;
  if (!is_last_to_store(&arrived[chunk], static_cast<unsigned>((end - begin + each - 1) / each))) return;
  R* shared = reinterpret_cast<R*>(storage);
  levels.template load<Warp::kSize>(shared, items, begin, end);
  levels.template merge<Warp::kSize>(shared, chunk, static_cast<unsigned>((n + kMergeChunk - 1) / kMergeChunk));
}

/// What a scan adds up: its values; those of a predicate count the items for which it holds.
template <class Value>
using SumOf = std::conditional_t<std::is_same_v<Value, bool>, std::uint32_t, Value>;

/// Returns the sum of the values of the lanes before; sets `total` to that of all lanes.
template <class T>
__device__ T sum_of_lanes_before(const T& value, T& total) {
  const int lane = Warp::rank();
  T sum = value;
  for (int distance = 1; distance < Warp::kSize; distance *= 2) {
    const T before = Warp::broadcast(sum, lane < distance ? lane : lane - distance);
    if (lane >= distance) sum = before + sum;
  }
  total = Warp::broadcast(sum, Warp::kSize - 1);
  const T before = Warp::broadcast(sum, lane > 0 ? lane - 1 : 0);
  return lane > 0 ? before : T{};
}
__device__ inline std::uint32_t sum_of_lanes_before(bool value, std::uint32_t& total) {
  const unsigned lanes = __ballot_sync(~0U, value);
  total = __popc(lanes);
  return __popc(lanes & ~(~0U << Warp::rank()));
}
template <class T>
__device__ T sum_of_lanes(T value) {
  for (int distance = 1; distance < Warp::kSize; distance *= 2) {
    value = value + Warp::broadcast(value, Warp::rank() ^ distance);
  }
  return value;
}

/// Sums of the tiles of a scan, by which a tile finds the sum of all before it while these are being evaluated
/// ("decoupled lookback", Merrill & Garland 2016). Additions are associative: the result does not depend on how many
/// tiles are added up.
template <class T>
struct ScannedTiles {
  T* sums;            ///< of each tile
  T* sums_up_to;      ///< of all tiles up to and including each
  unsigned* states;   ///< has_sum or has_sum + 1 (also up to it); else neither is known: a value of an earlier scan
  unsigned has_sum;   ///< differs by at least 2 from that of any earlier scan
  unsigned* started;  ///< number of tiles that were started; 0 before and after

  /// Blocks take tiles in order, so that those before a tile are evaluated by blocks that run already.
  __device__ unsigned start() const { return atomicInc(started, gridDim.x - 1); }

  /// Called by a warp. Returns the sum of the tiles before.
  __device__ T finish(unsigned tile, const T& sum) const {
    const bool writes = Warp::rank() == 0;
    if (writes && tile > 0) publish(&sums[tile], sum, tile, has_sum);
    T before{};
    for (int last = int(tile) - 1; last >= 0; last -= Warp::kSize) {
      bool is_complete = false;
      before = sum_of_window(last - Warp::rank(), is_complete) + before;
      if (is_complete) break;
    }
    if (writes) publish(&sums_up_to[tile], before + sum, tile, has_sum + 1);
    return before;
  }

 private:
  __device__ void publish(T* to, const T& value, unsigned tile, unsigned state) const {
    store_volatile(to, value);
    __threadfence();
    store_volatile(&states[tile], state);
  }
  /// Returns the sum of 32 tiles, of which each lane reads one, or of the last of them from a sum up to one on, which
  /// makes the sum complete. Requires that the lanes have decreasing tiles; those below 0 count as summed up.
  __device__ T sum_of_window(int tile, bool& is_complete) const {
    unsigned state = has_sum + 1;
    if (tile >= 0) {
      do state = load_volatile(&states[tile]);
      while (state - has_sum > 1);
    }
    __syncwarp();
    __threadfence();
    const unsigned summed_up = __ballot_sync(~0U, state != has_sum);
    const int first = summed_up == 0 ? Warp::kSize : __ffs(int(summed_up)) - 1;
    is_complete = summed_up != 0;
    T value{};
    if (tile >= 0 && Warp::rank() <= first)
      value = load_volatile(Warp::rank() == first ? &sums_up_to[tile] : &sums[tile]);
    return sum_of_lanes(value);
  }
};

/// Calls f.place(i, before, f(i)) for each item, with the sum of f(j) over the items j < i, in one launch. A block
/// takes a tile: `rows` times kThreads consecutive items. `total` receives the sum over all items.
template <class F, int kThreads, int kMaxRows>
__global__ void __launch_bounds__(kThreads)
    scan_kernel(Size n, int rows, F f, ScannedTiles<SumOf<typename F::Value>> tiles, SumOf<typename F::Value>* total) {
  using Value = typename F::Value;
  using T = SumOf<Value>;
  constexpr int kWarps = kThreads / Warp::kSize;
  __shared__ alignas(16) unsigned char storage[sizeof(T) * (kMaxRows * kWarps + 1)];
  __shared__ unsigned tile;
  T* sums = reinterpret_cast<T*>(storage);    // of each row and warp; then of those before in the tile
  T* before_tile = sums + kMaxRows * kWarps;  // the sum of the tiles before
  if (threadIdx.x == 0) tile = tiles.start();
  __syncthreads();
  const int warp = int(threadIdx.x) / Warp::kSize;
  const int lane = Warp::rank();
  const Size first = Size{tile} * rows * kThreads + threadIdx.x;
  Value values[kMaxRows];
  T before[kMaxRows];
#pragma unroll
  for (int row = 0; row < kMaxRows; ++row) {
    if (row >= rows) break;
    const Size i = first + Size{row} * kThreads;
    values[row] = i < n ? f(i) : Value{};
    T sum;
    before[row] = sum_of_lanes_before(values[row], sum);
    if (lane == 0) sums[row * kWarps + warp] = sum;
  }
  __syncthreads();
  if (warp == 0) {
    T tile_sum{};
    for (int first_sum = 0; first_sum < rows * kWarps; first_sum += Warp::kSize) {
      const int k = first_sum + lane;
      T sum;
      const T before_sum = sum_of_lanes_before(k < rows * kWarps ? sums[k] : T{}, sum);
      if (k < rows * kWarps) sums[k] = tile_sum + before_sum;
      tile_sum = tile_sum + sum;
    }
    const T before_all = tiles.finish(tile, tile_sum);
    if (lane == 0) *before_tile = before_all;
    if (lane == 0 && tile + 1 == gridDim.x) *total = before_all + tile_sum;
  }
  __syncthreads();
#pragma unroll
  for (int row = 0; row < kMaxRows; ++row) {
    if (row >= rows) break;
    const Size i = first + Size{row} * kThreads;
    if (i < n) f.place(i, *before_tile + sums[row * kWarps + warp] + before[row], values[row]);
  }
}

/// out[i] = in[0] + ... + in[i-1], which may be the same array.
template <class T>
struct ScanArray {
  using Value = T;
  Span<const T> in;
  Span<T> out;
  TETUNE_HD T operator()(Size i) const { return in[i]; }
  TETUNE_HD void place(Size i, const T& before, const T&) const { out[i] = before; }
};

/// Lists the items for which a predicate holds.
template <class Predicate>
struct ListKept {
  using Value = bool;
  Predicate keep;
  Span<Index32> out;
  TETUNE_HD bool operator()(Size i) const { return keep(i); }
  TETUNE_HD void place(Size i, std::uint32_t before, bool kept) const {
    if (kept) out[before] = to_index(i);
  }
};

/// Also sums up a value of each of them.
template <class T, class Predicate, class Evaluate>
struct ListAndSumKept {
  using Value = CountAndSum<T>;
  Predicate keep;
  Span<Index32> out;
  Evaluate evaluate;
  Span<T> sums;
  TETUNE_HD Value operator()(Size i) const { return keep(i) ? Value{1, evaluate(i)} : Value{}; }
  TETUNE_HD void place(Size i, const Value& before, const Value& value) const {
    if (value.count == 0) return;
    out[before.count] = to_index(i);
    sums[before.count] = before.sum;
  }
};

}  // namespace tetune::backend
