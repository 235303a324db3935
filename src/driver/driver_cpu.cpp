// SPDX-License-Identifier: Apache-2.0
#include "driver/alternate.inl"
#include "driver/slide_on.hpp"
#include "par/cpu.hpp"

namespace tetune {
template Report optimize_on(const par::Cpu&, TetMesh&, const Options&, const Context&, SlideSurface*);

SlideSurface find_slide_surface(const TetMesh& mesh, const Options& options) {
  const par::Cpu par(options.threads);
  WorkingSet<par::Cpu> work;
  Report report;
  load(par, mesh, options, nullptr, work, report);
  return tell_surface(work, mesh.points);
}
}  // namespace tetune
