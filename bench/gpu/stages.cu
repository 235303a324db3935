// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/stopwatch.cuh"
#include "core/connect.hpp"
#include "core/upload.hpp"
#include "flips/flip_pass.hpp"
#include "relocate/sweep.hpp"

namespace tetune::gpu_bench {

std::vector<std::pair<std::string, double>> measure_stages(const TetMesh& mesh, int runs) {
  const Stopwatch watch;
  const par::Cuda par(memory_needed_on_device(mesh, {}));
  std::vector<std::pair<std::string, std::vector<double>>> stages;
  const auto measure = [&](const char* name, bool counts, const auto& work) {
    const double seconds = watch.seconds(work);
    if (!counts) return;
    std::size_t at = 0;
    while (at < stages.size() && stages[at].first != name) ++at;
    if (at == stages.size()) stages.push_back({name, {}});
    stages[at].second.push_back(seconds);
  };
  std::vector<Point> points;
  for (const Point3& p : mesh.points) points.push_back(point(vec(p)));
  for (int run = 0; run <= runs; ++run) {
    const bool counts = run > 0;
    WorkMesh<par::Cuda> work = upload_mesh<par::Cuda>(mesh);
    work.law = kShapeLaw;
    measure("upload", counts, [&] {
      work.points.upload(points);
      par::Cuda::upload(work.tet2vertex.span().data(), mesh.tets.data(), mesh.tets.size() * sizeof(Tet));
    });
    measure("sorting", counts, [&] { sort_mesh(par, work); });
    measure("connectivity", counts, [&] { build_adjacency(par, work); });
    Rings<par::Cuda> rings;
    measure("rings", counts, [&] { build_rings(par, work, rings); });
    par::Cuda::Buffer<Mobility> mobility(work.vertices());
    par.fill(mobility.span(), Mobility::free);
    Coloring<par::Cuda> coloring;
    measure("colouring", counts, [&] { color_vertices(par, rings.view(), mobility.span(), coloring); });
    FlipState<par::Cuda> flips;
    measure("energies", counts, [&] { refresh_energy(par, work, flips); });
    measure("first flip pass", counts, [&] {
      activate_all(par, work, flips);
      flip_pass(par, work, flips, {});
    });
    std::vector<Tet> tets(static_cast<std::size_t>(work.slots()));
    measure("download", counts, [&] {
      par::Cuda::download(points.data(), work.points.span().data(), points.size() * sizeof(Point));
      par::Cuda::download(tets.data(), work.tet2vertex.span().data(), tets.size() * sizeof(Tet));
    });
    for (std::size_t v = 0; v < points.size(); ++v) points[v] = point(vec(mesh.points[v]));
  }
  std::vector<std::pair<std::string, double>> medians;
  for (const auto& [name, seconds] : stages) medians.emplace_back(name, median(seconds));
  return medians;
}

}  // namespace tetune::gpu_bench
