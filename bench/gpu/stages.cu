// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/stopwatch.cuh"
#include "driver/devices.hpp"
#include "energy/mesh_energy.hpp"
#include "mesh/connect.hpp"
#include "mesh/sort_mesh.hpp"
#include "mesh/work_mesh.hpp"
#include "operators/flips/flip_pass.hpp"
#include "relocation/coloring.hpp"
#include "relocation/rings.hpp"

namespace tetune::gpu_bench {

std::vector<std::pair<std::string, double>> measure_stages(const TetMesh& mesh, int runs) {
  const Stopwatch watch;
  // The data of all parts exist at once here, and in a run only those of some.
  const backend::Cuda backend(2 * memory_needed_on_device(mesh, {}));
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
    WorkMesh<backend::Cuda> work = upload_mesh(backend, mesh);
    const Criterion criterion{kShapeObjective, QualityFloor::none()};
    measure("upload", counts, [&] {
      work.points.upload(backend, points);
      backend.memory().upload(work.tet2vertex.span().data(), mesh.tets.data(), mesh.tets.size() * sizeof(Tet));
    });
    measure("sorting", counts, [&] { sort_mesh(backend, work); });
    measure("connectivity", counts, [&] { build_adjacency(backend, work); });
    Rings<backend::Cuda> rings;
    measure("rings", counts, [&] { build_rings(backend, work, rings); });
    backend::Cuda::Buffer<VertexDof> dof(backend, work.vertices());
    backend.fill(dof.span(), VertexDof::free);
    Coloring<backend::Cuda> coloring;
    measure("coloring", counts, [&] { color_vertices(backend, rings.view(), dof.span(), coloring); });
    FlipState<backend::Cuda> flips;
    measure("energies", counts, [&] { refresh_energy(backend, work, criterion, flips.energies); });
    measure("first flip pass", counts, [&] {
      activate_all(backend, work, criterion, flips);
      flip_pass(backend, work, criterion, flips, {});
    });
    std::vector<Tet> tets(to_size_t(work.slots()));
    measure("download", counts, [&] {
      backend::CudaMemory::download(points.data(), work.points.span().data(), points.size() * sizeof(Point));
      backend::CudaMemory::download(tets.data(), work.tet2vertex.span().data(), tets.size() * sizeof(Tet));
    });
    for (std::size_t v = 0; v < points.size(); ++v) points[v] = point(vec(mesh.points[v]));
  }
  std::vector<std::pair<std::string, double>> medians;
  for (const auto& [name, seconds] : stages) medians.emplace_back(name, median(seconds));
  return medians;
}

}  // namespace tetune::gpu_bench
