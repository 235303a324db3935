// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <type_traits>

#include "backend/cuda_kernels.cuh"
#include "backend/macros.hpp"
#include "backend/results.hpp"
#include "backend/span.hpp"

/// The scan of the CUDA backend (backend/cuda.cuh).
namespace tetune::backend {

/// The values that a scan adds up; those of a predicate count the items for which it holds.
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
  unsigned* states;   ///< has_sum: its sum is known; has_sum + 1: that up to it too; else neither (of an earlier scan)
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
  static_assert(kThreads % 2 == 0, "a tile has both items of a pair, see compact_and_sum() in backend/concept.hpp");
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

/// Calls a kernel for these items, with their rank and the sum of the values before.
template <class Predicate, class Evaluate, class Place>
struct PlaceKept {
  using Value = CountAndSum<std::invoke_result_t<const Evaluate&, Size>>;
  Predicate keep;
  Evaluate evaluate;
  Place place_kept;
  TETUNE_HD Value operator()(Size i) const { return keep(i) ? Value{1, evaluate(i)} : Value{}; }
  TETUNE_HD void place(Size i, const Value& before, const Value& value) const {
    if (value.count > 0) place_kept(i, Size{before.count}, before.sum);
  }
};

}  // namespace tetune::backend
