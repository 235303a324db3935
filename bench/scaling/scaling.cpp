// SPDX-License-Identifier: Apache-2.0
// One size through the optimizer: bench_scaling TETS THREADS. Prints one line of JSON. Times per tetrahedron are
// processor time, of all threads together: other programs on the machine change that little.
#include <sys/resource.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "reference/generate.hpp"
#include "tetune/tetune.hpp"

namespace {

double peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: bench_scaling TETS THREADS\n");
    return 2;
  }
  // A round of flips makes about a sixth more tetrahedra.
  const int n = static_cast<int>(std::lround(std::cbrt(std::atof(argv[1]) / 7)));
  tetune::TetMesh mesh = tetune::reference::scrambled(tetune::reference::lattice(n, 0.2), 1);
  const auto tets = static_cast<double>(mesh.tets.size());
  // The memory of the caller's arrays is not counted.
  const double before = peak_bytes();
  tetune::Options options;
  options.threads = std::atoi(argv[2]);
  const std::clock_t start = std::clock();
  const tetune::Report report = tetune::optimize(mesh, options);
  const double processor = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  const double memory = peak_bytes() - before;
  const bool valid = tetune::validate(mesh).ok();
  std::printf(
      "{\"tets\": %.0f, \"threads\": %d, \"valid\": %s, \"seconds\": %.4f, \"processor_seconds\": %.4f, "
      "\"ns_per_tet\": %.1f, \"sweeps\": %zu, \"ns_per_tet_and_sweep\": %.2f, \"bytes_per_tet\": %.0f}\n",
      tets, report.threads, valid ? "true" : "false", report.seconds, processor, 1e9 * processor / tets,
      report.sweeps.size(), 1e9 * processor / tets / static_cast<double>(report.sweeps.size()), memory / tets);
  return valid ? 0 : 1;
}
