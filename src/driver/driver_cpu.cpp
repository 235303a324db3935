// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "driver/distributed_interface.hpp"
#include "driver/optimize_on.inl"
#include "driver/parts/optimize_active.hpp"

namespace tetune {

template Report optimize_on(const backend::Cpu&, TetMesh&, const Options&, const Context&, SlideSurface*, MoveJob*);

namespace {

/// A mesh as optimize() has it after classification.
struct ClassifiedMesh {
  backend::Cpu backend;
  WorkingSet<backend::Cpu> work;
  Report report;
  ClassifiedMesh(const TetMesh& mesh, const Options& options) : backend(options.threads) {
    work.scale = unit_scale(mesh);
    import_mesh(backend, ImportInput{.mesh = mesh, .options = options}, work, report);
  }
};

}  // namespace

Report report_constraints(const TetMesh& mesh, const Options& options) { return ClassifiedMesh(mesh, options).report; }

ImportedMesh imported_mesh(const TetMesh& mesh, const Options& options) {
  ClassifiedMesh imported(mesh, options);
  return {constrained_mesh(imported.work, mesh), imported.work.mesh.tet2original.download()};
}

SlideSurface find_slide_surface(const TetMesh& mesh, const Options& options) {
  const ClassifiedMesh imported(mesh, options);
  const WorkingSet<backend::Cpu>& work = imported.work;
  return export_slide_surface(work.dofs.reference, mesh.points, work.mesh.vertex2original.download());
}

}  // namespace tetune
