// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "driver/distributed_interface.hpp"
#include "driver/optimize_on.inl"

namespace tetune {

template Report optimize_on(const backend::Cpu&, TetMesh&, const Options&, const Context&, SlideSurface*, MoveJob*);

SlideSurface find_slide_surface(const TetMesh& mesh, const Options& options) {
  const backend::Cpu backend(options.threads);
  WorkingSet<backend::Cpu> work;
  work.scale = unit_scale(mesh);
  Report report;
  import_mesh(backend, mesh, options, nullptr, work, report);
  return export_slide_surface(work.dofs.reference, mesh.points, work.mesh.vertex2original.download());
}

}  // namespace tetune
