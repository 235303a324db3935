// SPDX-License-Identifier: Apache-2.0
// Each kernel by itself, beside what the machine can do: bench_micro [--benchmark_filter=...]. Each measurement checks
// its result first. The argument is the number of threads.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

#include "core/connect.hpp"
#include "core/upload.hpp"
#include "flips/flip_pass.hpp"
#include "par/cpu.hpp"
#include "reference/generate.hpp"
#include "relocate/coloring.hpp"
#include "relocate/sweep.hpp"
#include "tetune/tetune.hpp"

namespace tetune {
namespace {

using par::Cpu;

/// 57^3 cells, some 1.3 M tetrahedra and 195 k vertices.
const TetMesh& input() {
  static const TetMesh mesh = reference::scrambled(reference::lattice(57, 0.2), 1);
  return mesh;
}

WorkMesh<Cpu> sorted() {
  WorkMesh<Cpu> work = upload_mesh<Cpu>(input());
  sort_mesh(Cpu(0), work);
  build_adjacency(Cpu(0), work);
  return work;
}

Cpu threads(const benchmark::State& state) { return Cpu(static_cast<int>(state.range(0))); }

void per_item(benchmark::State& state, const char* item, Size items) {
  state.counters[item] = benchmark::Counter(
      static_cast<double>(items), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void Sort(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    WorkMesh<Cpu> work = upload_mesh<Cpu>(input());
    state.ResumeTiming();
    sort_mesh(threads(state), work);
  }
  per_item(state, "a tet", static_cast<Size>(input().tets.size()));
}

void Adjacency(benchmark::State& state) {
  WorkMesh<Cpu> work = sorted();
  for (auto _ : state) {
    const AdjacencyReport r = build_adjacency(threads(state), work);
    if (r.crowded_faces + r.same_side_faces > 0) state.SkipWithError("broken adjacency");
  }
  per_item(state, "a tet", work.slots());
}

void VertexRings(benchmark::State& state) {
  WorkMesh<Cpu> work = sorted();
  Rings<Cpu> rings;
  for (auto _ : state) build_rings(threads(state), work, rings);
  if (rings.faces.size() != 4 * work.slots()) state.SkipWithError("broken rings");
  per_item(state, "a tet", work.slots());
}

void Colouring(benchmark::State& state) {
  WorkMesh<Cpu> work = sorted();
  Rings<Cpu> rings;
  build_rings(Cpu(0), work, rings);
  Cpu::Buffer<Mobility> kind;
  kind.upload(std::vector<Mobility>(static_cast<std::size_t>(work.vertices()), Mobility::free));
  for (auto _ : state) {
    Coloring<Cpu> coloring;
    color_vertices(threads(state), rings.view(), Span<const Mobility>(kind.span()), coloring);
    if (coloring.vertices.size() != work.vertices()) state.SkipWithError("a vertex without colour");
    state.counters["colours"] = coloring.colors();
  }
  per_item(state, "a vertex", work.vertices());
}

void FirstFlipPass(benchmark::State& state) {
  const Cpu cpu = threads(state);
  for (auto _ : state) {
    state.PauseTiming();
    WorkMesh<Cpu> work = sorted();
    FlipState<Cpu> flips;
    const double energy = refresh_energy(cpu, work, flips);
    activate_all(cpu, work, flips);
    state.ResumeTiming();
    const FlipReport r = flip_pass(cpu, work, flips, {});
    state.PauseTiming();
    if (std::abs(refresh_energy(cpu, work, flips) - (energy - r.decrease)) > 1e-9 * energy)
      state.SkipWithError("energy is off");
    state.counters["flips"] = static_cast<double>(r.flips());
    state.ResumeTiming();
  }
  per_item(state, "a tet", static_cast<Size>(input().tets.size()));
}

template <class Step>
void sweep_with(benchmark::State& state, const Step& step) {
  const Cpu cpu = threads(state);
  WorkMesh<Cpu> work = sorted();
  Rings<Cpu> rings;
  build_rings(cpu, work, rings);
  const auto n = static_cast<std::size_t>(work.vertices());
  // The vertices of the cube's faces are fixed, as in `--boundary fixed`.
  std::vector<Mobility> kinds(n, Mobility::free);
  for (std::size_t v = 0; v < n; ++v) {
    const Point p = work.points.span()[static_cast<Size>(v)];
    for (const double x : {p.x, p.y, p.z}) {
      if (x == 0 || x == 1) kinds[v] = Mobility::fixed;
    }
  }
  Mobilities<Cpu> m;
  m.kind.upload(kinds);
  m.axis.upload(std::vector<Vec3>(n, Vec3{0, 0, 0}));
  m.awake.upload(std::vector<std::uint8_t>(n, 1));
  Coloring<Cpu> coloring;
  color_vertices(cpu, rings.view(), Span<const Mobility>(m.kind.span()), coloring);
  const std::vector<Point> start = work.points.download();
  for (auto _ : state) {
    state.PauseTiming();
    work.points.upload(start);
    cpu.fill(m.awake.span(), std::uint8_t{1});
    state.ResumeTiming();
    const SweepSum sum = sweep(cpu, work, rings.view(), coloring, m, step);
    if (!(sum.decrease > 0)) state.SkipWithError("the energy did not fall");
  }
  per_item(state, "a vertex", coloring.vertices.size());
  // Arithmetic of one visit: two passes over the ring, about 190 and 100 operations a tetrahedron, 23 of them a vertex.
  state.counters["Gflop/s"] = benchmark::Counter(static_cast<double>(rings.faces.size()) * 290 * 1e-9,
                                                 benchmark::Counter::kIsIterationInvariantRate);
}
void NewtonSweep(benchmark::State& state) { sweep_with(state, NewtonStep{1.6, 1e-10}); }
void GradientSweep(benchmark::State& state) { sweep_with(state, GradientStep{1e-5}); }

std::string scratch(const char* ending) {
  return (std::filesystem::temp_directory_path() / ("tetune-bench-" + std::to_string(getpid()) + ending)).string();
}

void file_speed(benchmark::State& state, const char* ending, bool reading) {
  const std::string path = scratch(ending);
  write_mesh(path, input());
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  for (auto _ : state) {
    if (reading) {
      if (read_mesh(path, nullptr, static_cast<int>(state.range(0))).tets != input().tets)
        state.SkipWithError("read something else");
    } else {
      write_mesh(path, input(), static_cast<int>(state.range(0)));
    }
  }
  std::filesystem::remove(path);
  state.counters["MB/s"] = benchmark::Counter(1e-6 * bytes, benchmark::Counter::kIsIterationInvariantRate);
}
void ReadMesh(benchmark::State& state) { file_speed(state, ".mesh", true); }
void ReadMeshb(benchmark::State& state) { file_speed(state, ".meshb", true); }
void WriteMesh(benchmark::State& state) { file_speed(state, ".mesh", false); }
void WriteMeshb(benchmark::State& state) { file_speed(state, ".meshb", false); }

struct CopyKernel {
  const double* from;
  double* to;
  void operator()(Size i) const { std::memcpy(to + 4096 * i, from + 4096 * i, 4096 * sizeof(double)); }
};
void CopyBandwidth(benchmark::State& state) {
  constexpr Size kBlocks = 8192;  // 256 MiB each way, far beyond the caches
  Cpu::Buffer<double> from(4096 * kBlocks);
  Cpu::Buffer<double> to(4096 * kBlocks);
  const Cpu cpu = threads(state);
  cpu.fill(from.span(), 1.0);
  cpu.fill(to.span(), 0.0);
  for (auto _ : state) cpu.for_each(kBlocks, CopyKernel{from.span().data(), to.span().data()});
  state.counters["GB/s"] =
      benchmark::Counter(2e-9 * 4096 * kBlocks * sizeof(double), benchmark::Counter::kIsIterationInvariantRate);
}

struct FlopSum {
  double value = 0;
  void merge(const FlopSum& other) { value += other.value; }
};
/// Independent fused multiply-adds on vector registers: the machine's peak.
struct FlopKernel {
  typedef double Lanes __attribute__((vector_size(64)));
  static constexpr int kChains = 12;
  static constexpr int kSteps = 2000;
  FlopSum operator()(Size i) const {
    Lanes x[kChains];
    for (int c = 0; c < kChains; ++c) x[c] = Lanes{} + static_cast<double>(i + c);
    const Lanes a = Lanes{} + 0.999;
    const Lanes b = Lanes{} + 0.001;
    for (int s = 0; s < kSteps; ++s) {
      for (int c = 0; c < kChains; ++c) x[c] = x[c] * a + b;
    }
    double sum = 0;
    for (int c = 0; c < kChains; ++c) sum += x[c][0];
    return {sum};
  }
};
void PeakFlops(benchmark::State& state) {
  constexpr Size kItems = 8192;
  const Cpu cpu = threads(state);
  double sum = 0;
  for (auto _ : state) sum += cpu.reduce<FlopSum>(kItems, FlopKernel{}).value;
  benchmark::DoNotOptimize(sum);
  state.counters["Gflop/s"] = benchmark::Counter(1e-9 * kItems * FlopKernel::kSteps * FlopKernel::kChains * 16,
                                                 benchmark::Counter::kIsIterationInvariantRate);
}

#define TETUNE_BENCHMARK(name) BENCHMARK(name)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond)
TETUNE_BENCHMARK(CopyBandwidth);
TETUNE_BENCHMARK(PeakFlops);
TETUNE_BENCHMARK(Sort);
TETUNE_BENCHMARK(Adjacency);
TETUNE_BENCHMARK(VertexRings);
TETUNE_BENCHMARK(Colouring);
TETUNE_BENCHMARK(FirstFlipPass);
TETUNE_BENCHMARK(NewtonSweep);
TETUNE_BENCHMARK(GradientSweep);
TETUNE_BENCHMARK(ReadMesh);
TETUNE_BENCHMARK(ReadMeshb);
TETUNE_BENCHMARK(WriteMesh);
TETUNE_BENCHMARK(WriteMeshb);

}  // namespace
}  // namespace tetune
