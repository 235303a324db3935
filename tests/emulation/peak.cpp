// SPDX-License-Identifier: Apache-2.0
// Prints the peak of the device memory of a run, measured by the emulation: docs/benchmarks/gpu-memory.md.
//   emulation_peak MESH fixed|preserve|slide fast|standard|best
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>

#include "driver/devices.hpp"
#include "emulation/emulation.hpp"
#include "tetune/io.hpp"
#include "tetune/option_table.hpp"

using namespace tetune;

int main(int argc, char** argv) try {
  if (argc != 4) throw std::runtime_error("usage: emulation_peak MESH fixed|preserve|slide fast|standard|best");
  Options options;
  set_option(options, "boundary", argv[2]);
  set_option(options, "effort", argv[3]);
  TetMesh mesh = read_mesh(argv[1]);
  const auto vertices = mesh.points.size();
  const auto tets = mesh.tets.size();
  const auto triangles = mesh.triangles.size();
  const backend::Emulation gpu(1, std::size_t{32} << 30);
  std::size_t peak = 0;
  const auto print_peak = [&](const char* phase) {
    if (gpu.device_memory().pool().peak() == peak) return true;
    peak = gpu.device_memory().pool().peak();
    std::printf("%10s: %6.1f bytes per tetrahedron\n", phase, static_cast<double>(peak) / static_cast<double>(tets));
    return true;
  };
  Context context;
  context.progress = [&](const Progress& p) { return print_peak(p.phase); };
  optimize_on(gpu, mesh, options, context);
  print_peak("store");
  std::printf("%zu bytes for %zu vertices, %zu tetrahedra, %zu triangles listed\n", peak, vertices, tets, triangles);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "emulation_peak: %s\n", e.what());
  return 2;
}
