// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"
#include "driver/distributed_interface.hpp"
#include "driver/optimize_on.inl"
#include "driver/parts/optimize_active.hpp"

namespace tetune {

template Report optimize_on(const backend::Cpu&, TetMesh&, const Options&, const Context&, SlideSurface*, MoveJob*);

namespace {

/// A mesh as optimize() has it after classification.
struct ImportedMesh {
  backend::Cpu backend;
  WorkingSet<backend::Cpu> work;
  Report report;
  ImportedMesh(const TetMesh& mesh, const Options& options) : backend(options.threads) {
    work.scale = unit_scale(mesh);
    import_mesh(backend, mesh, options, nullptr, true, work, report);
  }
};

}  // namespace

Report report_constraints(const TetMesh& mesh, const Options& options) { return ImportedMesh(mesh, options).report; }

MeshOutcome import_outcome(const TetMesh& mesh, const Options& options) {
  ImportedMesh imported(mesh, options);
  return {outcome_of(imported.work, mesh), imported.work.mesh.tet2original.download()};
}

SlideSurface find_slide_surface(const TetMesh& mesh, const Options& options) {
  const ImportedMesh imported(mesh, options);
  const WorkingSet<backend::Cpu>& work = imported.work;
  return export_slide_surface(work.dofs.reference, mesh.points, work.mesh.vertex2original.download());
}

}  // namespace tetune
