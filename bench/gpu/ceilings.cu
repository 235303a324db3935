// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "bench/gpu/stopwatch.cuh"

namespace tetune::gpu_bench {
namespace {

constexpr int kRuns = 7;
constexpr int kThreads = 256;
constexpr int kChains = 8;
constexpr int kSteps = 4096;

/// Independent chains of multiply-adds, enough to hide their latency.
template <class T>
__global__ void multiply_add(T factor, T summand, T* out) {
  T x[kChains];
  for (int c = 0; c < kChains; ++c) x[c] = static_cast<T>(threadIdx.x + c);
  for (int step = 0; step < kSteps; ++step) {
#pragma unroll
    for (int c = 0; c < kChains; ++c) x[c] = fma(x[c], factor, summand);
  }
  T sum{};
  for (int c = 0; c < kChains; ++c) sum += x[c];
  if (sum == T{-1}) *out = sum;  // never true; keeps the compiler from removing the loop
}

__global__ void empty_kernel() {}

cudaDeviceProp properties() {
  int device = 0;
  backend::check_cuda(cudaGetDevice(&device), "device query");
  cudaDeviceProp p{};
  backend::check_cuda(cudaGetDeviceProperties(&p, device), "device query");
  return p;
}

/// A block of device memory.
class Block {
 public:
  explicit Block(std::size_t bytes) { backend::check_cuda(cudaMalloc(&data_, bytes), "allocation"); }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  ~Block() { cudaFree(data_); }
  void* data() const { return data_; }

 private:
  void* data_ = nullptr;
};

template <class F>
double seconds_of(const F& work) {
  const Stopwatch watch;
  watch.seconds(work);
  std::vector<double> seconds;
  for (int run = 0; run < kRuns; ++run) seconds.push_back(watch.seconds(work));
  return median(seconds);
}

template <class T>
double flops() {
  const int blocks = 16 * properties().multiProcessorCount;
  const Block out(sizeof(T));
  const double seconds =
      seconds_of([&] { multiply_add<T><<<blocks, kThreads>>>(T(0.999), T(0.001), static_cast<T*>(out.data())); });
  backend::check_cuda(cudaGetLastError(), "launch");
  return 2.0 * kChains * kSteps * kThreads * blocks / seconds;
}

}  // namespace

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 2];
}

Card card() {
  const cudaDeviceProp p = properties();
  Card card{p.name, p.major, p.minor, p.multiProcessorCount};
  backend::check_cuda(cudaMemGetInfo(&card.free_memory, &card.memory), "device query");
  backend::check_cuda(cudaDriverGetVersion(&card.driver), "device query");
  backend::check_cuda(cudaRuntimeGetVersion(&card.runtime), "device query");
  return card;
}

Ceilings measure_ceilings() {
  Ceilings ceilings;
  const std::size_t bytes = std::min(std::size_t{1} << 30, card().free_memory / 8);
  const Block from(bytes);
  const Block to(bytes);
  const auto both = 2.0 * static_cast<double>(bytes);
  ceilings.copy_bytes = both / seconds_of([&] { backend::CudaMemory::copy(to.data(), from.data(), bytes); });
  std::vector<unsigned char> host(bytes / 4);
  ceilings.upload_bytes = static_cast<double>(host.size()) /
                          seconds_of([&] { backend::CudaMemory::upload(to.data(), host.data(), host.size()); });
  ceilings.download_bytes = static_cast<double>(host.size()) /
                            seconds_of([&] { backend::CudaMemory::download(host.data(), to.data(), host.size()); });
  ceilings.single_flops = flops<float>();
  ceilings.double_flops = flops<double>();
  constexpr int kLaunches = 1000;
  ceilings.launch_seconds = seconds_of([] {
                              for (int i = 0; i < kLaunches; ++i) empty_kernel<<<1, 32>>>();
                            }) /
                            kLaunches;
  constexpr int kTrips = 100;
  ceilings.round_trip_seconds = seconds_of([&] {
                                  double value = 0;
                                  for (int i = 0; i < kTrips; ++i) {
                                    empty_kernel<<<1, 32>>>();
                                    backend::CudaMemory::download(&value, to.data(), sizeof value);
                                  }
                                }) /
                                kTrips;
  backend::check_cuda(cudaGetLastError(), "launch");
  return ceilings;
}

std::size_t free_bytes() { return card().free_memory; }

}  // namespace tetune::gpu_bench
