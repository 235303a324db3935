// SPDX-License-Identifier: Apache-2.0
// Each kernel by itself, beside what the machine can do: bench_micro [--benchmark_filter=...]. Each measurement checks
// its result first. The argument is the number of threads.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>

#include "backend/cpu.hpp"
#include "mesh/connect.hpp"
#include "mesh/sort_mesh.hpp"
#include "mesh/work_mesh.hpp"
#include "operators/flips/flip_pass.hpp"
#include "reference/generate.hpp"
#include "relocation/coloring.hpp"
#include "relocation/rings.hpp"
#include "relocation/sweep.hpp"
#include "tetune/tetune.hpp"

namespace tetune {
namespace {

using backend::Cpu;

/// 57^3 cells, some 1.3 M tetrahedra and 195 k vertices.
const TetMesh& input() {
  static const TetMesh mesh = reference::scrambled(reference::lattice(57, 0.2), 1);
  return mesh;
}

WorkMesh<Cpu> sorted() {
  WorkMesh<Cpu> work = upload_mesh(Cpu(1), input());
  sort_mesh(Cpu(0), work);
  build_adjacency(Cpu(0), work);
  return work;
}

double tets() { return double(input().tets.size()); }
double vertices() { return double(input().points.size()); }
double ring_bytes(const Rings<Cpu>& rings) {
  return double(rings.faces.size()) * sizeof(*rings.faces.span().data()) + vertices() * sizeof(Index);
}

int thread_count(const benchmark::State& state) { return static_cast<int>(state.range(0)); }
Cpu threads(const benchmark::State& state) { return Cpu(thread_count(state)); }

void per_item(benchmark::State& state, const char* item, Size items) {
  state.counters[item] =
      benchmark::Counter(double(items), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// The limits of the machine, measured once for each number of threads.
struct Ceilings {
  double bytes_per_second;
  double flops_per_second;
};

struct CopyKernel {
  static constexpr Size kBlock = 4096;
  const double* from;
  double* to;
  void operator()(Size i) const { std::memcpy(to + kBlock * i, from + kBlock * i, kBlock * sizeof(double)); }
};

struct FlopSum {
  double value = 0;
  void merge(const FlopSum& other) { value += other.value; }
};
/// Independent fused multiply-adds on vector registers. The library itself fuses none, so half of this is its peak.
struct FlopKernel {
  static constexpr int kLanes = 96;
  static constexpr int kSteps = 2000;
  static constexpr double kFlops = 2.0 * kLanes * kSteps;
  FlopSum operator()(Size i) const {
    double x[kLanes];
    for (int c = 0; c < kLanes; ++c) x[c] = double(i + c);
    for (int s = 0; s < kSteps; ++s) {
      for (int c = 0; c < kLanes; ++c) x[c] = __builtin_fma(x[c], 0.999, 0.001);
    }
    double sum = 0;
    for (int c = 0; c < kLanes; ++c) sum += x[c];
    return {sum};
  }
};

template <class F>
double fastest_of(int times, const F& f) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < times; ++i) {
    const auto start = std::chrono::steady_clock::now();
    f();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

Ceilings measure_ceilings(int threads) {
  constexpr Size kBlocks = 8192;  // 256 MiB each way, far beyond the caches
  constexpr Size kItems = 4096;
  const Cpu cpu(threads);
  Cpu::Buffer<double> from(cpu, CopyKernel::kBlock * kBlocks);
  Cpu::Buffer<double> to(cpu, CopyKernel::kBlock * kBlocks);
  cpu.fill(from.span(), 1.0);
  cpu.fill(to.span(), 0.0);
  const CopyKernel copy{from.span().data(), to.span().data()};
  const double copy_seconds = fastest_of(5, [&] { cpu.for_each(kBlocks, copy); });
  const double flop_seconds =
      fastest_of(5, [&] { benchmark::DoNotOptimize(cpu.reduce<FlopSum>(kItems, FlopKernel{}).value); });
  return {2.0 * CopyKernel::kBlock * kBlocks * sizeof(double) / copy_seconds,
          kItems * FlopKernel::kFlops / flop_seconds};
}

const Ceilings& ceilings(int threads) {
  static std::map<int, Ceilings> measured;
  const auto known = measured.find(threads);
  return known != measured.end() ? known->second : measured.emplace(threads, measure_ceilings(threads)).first->second;
}

/// Beside its roofline: the part of the time that the fewest bytes (what is read and written, each once) and the
/// arithmetic would take at the machine's ceilings, the longer of the two.
void roofline(benchmark::State& state, double bytes, double flops = 0) {
  const Ceilings& top = ceilings(thread_count(state));
  const auto rate = [](double each) { return benchmark::Counter(each, benchmark::Counter::kIsIterationInvariantRate); };
  state.counters["GB/s"] = rate(1e-9 * bytes);
  if (flops > 0) state.counters["Gflop/s"] = rate(1e-9 * flops);
  state.counters["of roof"] = rate(std::max(bytes / top.bytes_per_second, flops / top.flops_per_second));
}

void Machine(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(ceilings(thread_count(state)));
  state.counters["GB/s"] = 1e-9 * ceilings(thread_count(state)).bytes_per_second;
  state.counters["Gflop/s"] = 1e-9 * ceilings(thread_count(state)).flops_per_second;
}

void Sort(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    WorkMesh<Cpu> work = upload_mesh(Cpu(1), input());
    state.ResumeTiming();
    sort_mesh(threads(state), work);
  }
  per_item(state, "per tet", std::ssize(input().tets));
  roofline(state, tets() * (2 * sizeof(Tet) + sizeof(Index)) + vertices() * (2 * sizeof(Point) + sizeof(Index)));
}

void Adjacency(benchmark::State& state) {
  WorkMesh<Cpu> work = sorted();
  for (auto _ : state) {
    const AdjacencyReport r = build_adjacency(threads(state), work);
    if (r.non_manifold_faces + r.misoriented_faces > 0) state.SkipWithError("broken adjacency");
  }
  per_item(state, "per tet", work.slots());
  roofline(state, tets() * (sizeof(Tet) + sizeof(FaceAdjacency)));
}

void VertexRings(benchmark::State& state) {
  WorkMesh<Cpu> work = sorted();
  Rings<Cpu> rings;
  for (auto _ : state) build_rings(threads(state), work, rings);
  if (rings.faces.size() != 4 * work.slots()) state.SkipWithError("broken rings");
  per_item(state, "per tet", work.slots());
  roofline(state, tets() * sizeof(Tet) + ring_bytes(rings));
}

void VertexColoring(benchmark::State& state) {
  WorkMesh<Cpu> work = sorted();
  Rings<Cpu> rings;
  build_rings(Cpu(0), work, rings);
  Cpu::Buffer<VertexDof> kind;
  kind.upload(backend::Cpu(1), std::vector<VertexDof>(static_cast<std::size_t>(work.vertices()), VertexDof::free));
  for (auto _ : state) {
    Coloring<Cpu> coloring;
    color_vertices(threads(state), rings.view(), Span<const VertexDof>(kind.span()), coloring);
    if (coloring.vertices.size() != work.vertices()) state.SkipWithError("a vertex without a color");
    state.counters["colors"] = coloring.colors();
  }
  per_item(state, "per vertex", work.vertices());
  roofline(state, ring_bytes(rings) + vertices() * 2 * sizeof(Index));
}

void FirstFlipPass(benchmark::State& state) {
  const Cpu cpu = threads(state);
  for (auto _ : state) {
    state.PauseTiming();
    WorkMesh<Cpu> work = sorted();
    FlipState<Cpu> flips;
    const double energy = refresh_energy(cpu, work, Criterion{}, flips.energies);
    activate_all(cpu, work, Criterion{}, flips);
    state.ResumeTiming();
    const PassResult r = flip_pass(cpu, work, Criterion{}, flips, {});
    state.PauseTiming();
    if (std::abs(refresh_energy(cpu, work, Criterion{}, flips.energies) - (energy - r.decrease)) > 1e-9 * energy)
      state.SkipWithError("energy is off");
    state.counters["flips"] = double(r.counts.flips());
    state.ResumeTiming();
  }
  per_item(state, "per tet", std::ssize(input().tets));
  // Read, and written for most: each tetrahedron, its adjacency, energy and slack; read: the points.
  roofline(state, tets() * (sizeof(Tet) + sizeof(FaceAdjacency) + 2 * sizeof(double) + 2 * sizeof(float)) +
                      vertices() * sizeof(Point));
}

template <class Step>
void sweep_with(benchmark::State& state, const Step& step) {
  const Cpu cpu = threads(state);
  WorkMesh<Cpu> work = sorted();
  Rings<Cpu> rings;
  build_rings(cpu, work, rings);
  const auto n = static_cast<std::size_t>(work.vertices());
  // The vertices of the cube's faces are fixed, as in `--boundary fixed`.
  std::vector<VertexDof> kinds(n, VertexDof::free);
  for (std::size_t v = 0; v < n; ++v) {
    const Point p = work.points.span()[static_cast<Size>(v)];
    for (const double x : {p.x, p.y, p.z}) {
      if (x == 0 || x == 1) kinds[v] = VertexDof::fixed;
    }
  }
  VertexDofs<Cpu> m;
  m.dof.upload(cpu, kinds);
  m.axis.upload(cpu, std::vector<Vec3>(n, Vec3{0, 0, 0}));
  m.active.upload(cpu, std::vector<std::uint8_t>(n, 1));
  Coloring<Cpu> coloring;
  color_vertices(cpu, rings.view(), Span<const VertexDof>(m.dof.span()), coloring);
  const std::vector<Point> start = work.points.download();
  for (auto _ : state) {
    state.PauseTiming();
    work.points.upload(cpu, start);
    cpu.fill(m.active.span(), std::uint8_t{1});
    state.ResumeTiming();
    const SweepSum sum = sweep<SweepRing<Cpu>>(cpu, work, Criterion{}, {rings.view(), coloring, m}, step).get();
    if (!(sum.decrease > 0)) state.SkipWithError("the energy did not fall");
  }
  per_item(state, "per vertex", coloring.vertices.size());
  // Arithmetic of one visit: two passes over the ring, about 190 and 100 operations per tetrahedron, 23 of them per
  // vertex.
  roofline(state, ring_bytes(rings) + vertices() * (2 * sizeof(Point) + sizeof(Index)),
           double(rings.faces.size()) * 290);
}
void NewtonSweep(benchmark::State& state) { sweep_with(state, NewtonStep{1.7, 1e-10}); }
void GradientSweep(benchmark::State& state) { sweep_with(state, GradientStep{1e-5}); }

std::string scratch(const char* ending) {
  return (std::filesystem::temp_directory_path() / ("tetune-bench-" + std::to_string(getpid()) + ending)).string();
}

void count_bytes(benchmark::State& state, double bytes) {
  state.counters["MB/s"] = benchmark::Counter(1e-6 * bytes, benchmark::Counter::kIsIterationInvariantRate);
}

void read_speed(benchmark::State& state, const char* ending) {
  const std::string path = scratch(ending);
  write_mesh(path, input());
  for (auto _ : state) {
    if (read_mesh(path, nullptr, thread_count(state)).tets != input().tets) state.SkipWithError("read something else");
  }
  count_bytes(state, double(std::filesystem::file_size(path)));
  std::filesystem::remove(path);
}

void write_speed(benchmark::State& state, const char* ending) {
  const std::string path = scratch(ending);
  for (auto _ : state) write_mesh(path, input(), thread_count(state));
  count_bytes(state, double(std::filesystem::file_size(path)));
  std::filesystem::remove(path);
}

void ReadMesh(benchmark::State& state) { read_speed(state, ".mesh"); }
void ReadMeshb(benchmark::State& state) { read_speed(state, ".meshb"); }
void WriteMesh(benchmark::State& state) { write_speed(state, ".mesh"); }
void WriteMeshb(benchmark::State& state) { write_speed(state, ".meshb"); }

#define TETUNE_BENCHMARK(name) BENCHMARK(name)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond)
TETUNE_BENCHMARK(Machine);
TETUNE_BENCHMARK(Sort);
TETUNE_BENCHMARK(Adjacency);
TETUNE_BENCHMARK(VertexRings);
TETUNE_BENCHMARK(VertexColoring);
TETUNE_BENCHMARK(FirstFlipPass);
TETUNE_BENCHMARK(NewtonSweep);
TETUNE_BENCHMARK(GradientSweep);
TETUNE_BENCHMARK(ReadMesh);
TETUNE_BENCHMARK(ReadMeshb);
TETUNE_BENCHMARK(WriteMesh);
TETUNE_BENCHMARK(WriteMeshb);

}  // namespace
}  // namespace tetune
