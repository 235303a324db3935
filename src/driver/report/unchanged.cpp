// SPDX-License-Identifier: Apache-2.0
#include "driver/report/unchanged.hpp"

#include <iterator>
#include <utility>
#include <vector>

#include "backend/cpu.hpp"
#include "backend/span.hpp"
#include "driver/report/run_warnings.hpp"
#include "driver/report/targets.hpp"
#include "mesh/id_maps.hpp"

namespace tetune {
namespace {

/// Sets all that describes the result.
void describe_unchanged(const TetMesh& mesh, const Options& options, Report& report) {
  OperationCounts& operations = report;
  operations = {};
  report.tets_after = report.tets_before;
  report.energy_after = report.energy_before;
  report.tets_untangled = report.triangles_dropped = report.edges_dropped = 0;
  report.restarts = report.restarts_kept = 0;
  report.deviation = report.uncovered = 0;
  report.transfer_stopped = false;
  report.straightened.clear();
  report.sweeps.clear();
  report.flip_passes.clear();
  report.worst_rounds.clear();
  report.vertex2original.clear();
  report.triangle2original.clear();
  report.edge2original.clear();
  report.tet2original = identity_map(mesh.tets.size());
  report.places.assign(options.data == DataTransfer::carry ? 0 : mesh.points.size(), {});
  for (Index v = 0; v < std::ssize(report.places); ++v) span_of(report.places)[v].vertices.fill(v);
  report.targets.clear();
  for (const Target& target : options.targets) report.targets.emplace_back().target = target;
  add_locked(
      mesh, std::vector<std::uint8_t>(mesh.tets.size(), 0), options.threads, [](Index t) { return t; }, report.targets);
  for (TargetReport& target : report.targets) target.tets = report.tets_after;
  RunWarnings(mesh, options).add_to(report);
}

}  // namespace

Report report_unchanged(const TetMesh& mesh, const Options& options) {
  Report report;
  report.device = "CPU";
  report.threads = backend::Cpu::requested_threads(options.threads);
  report.vertices = report.fixed_vertices = std::ssize(mesh.points);
  report.tets_before = std::ssize(mesh.tets);
  describe_unchanged(mesh, options, report);
  return report;
}

void discard_result(const TetMesh& mesh, const Options& options, std::string reason, Report& report) {
  report.fixed_vertices += std::ssize(mesh.points) - report.vertices;
  report.vertices = std::ssize(mesh.points);
  report.tets_before = std::ssize(mesh.tets);
  describe_unchanged(mesh, options, report);
  report.unchanged = std::move(reason);
  report.warnings.push_back(report.unchanged);
}

}  // namespace tetune
