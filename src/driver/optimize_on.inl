// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "driver/devices.hpp"
#include "driver/export_mesh.hpp"
#include "driver/import_mesh.hpp"
#include "driver/move_job.hpp"
#include "driver/place_tracker.hpp"
#include "driver/report/targets.hpp"
#include "driver/transfer_stop.hpp"
#include "phases/improve.hpp"
#include "phases/motion/follow_targets.hpp"
#include "phases/motion/sliding_motion.hpp"
#include "phases/untangle/untangle.hpp"

namespace tetune {
namespace optimize_on_detail {

/// Runs improve(), and follows the vertices if there is a tracker.
template <class Backend>
auto improve_with(PlaceTracker* tracker) {
  return [tracker](Optimizer<Backend>& optimizer) {
    if (tracker == nullptr) return improve(optimizer);
    optimizer.timer.measure(Phase::data, [&] { tracker->start(HostMesh(optimizer.work.mesh)); });
    const bool proceeds = improve(optimizer);
    optimizer.timer.measure(Phase::data, [&] { tracker->finish(HostMesh(optimizer.work.mesh)); });
    return proceeds;
  };
}

/// Removes the triangles that `motion` moves from the reference surface.
template <class Backend>
void cut_reference(const Backend& backend, const std::vector<std::uint8_t>& motion, WorkingSet<Backend>& work) {
  std::vector<std::uint8_t> by_work;
  for (const Index v : work.mesh.vertex2original.download()) by_work.push_back(span_of(motion)[v]);
  const DeviceViewOf<Backend, std::uint8_t> view(backend, by_work);
  cut_moving_triangles(backend, view.span(), work.dofs.reference);
}

/// Moves the mesh to one target after the other, until one cannot be reached or the caller cancels.
template <class Backend>
void follow_all(Optimizer<Backend>& optimizer, MoveJob& job, PlaceTracker* tracker) {
  optimizer.sum_energy(optimizer.objective());
  optimizer.report.energy_before = optimizer.in_callers_unit(optimizer.energy());
  optimizer.progress.set_done(0);
  job.report.fraction = 0;
  if (!optimizer.proceed(Phase::load, 0)) return;
  const std::vector<Index> vertex2original = optimizer.work.mesh.vertex2original.download();
  TargetFollower<Backend> follower(optimizer, improve_with<Backend>(tracker), job.targets.size(), job.report.steps);
  for (std::size_t i = 0; i < job.targets.size(); ++i) {
    const WorkTarget target = work_target(job.targets[i], vertex2original, optimizer.work.scale);
    job.report.fraction = follower.follow(i, target.positions, target.prescribed);
    if (job.report.fraction < 1) break;
    ++job.report.targets_reached;
    if (optimizer.report.stop == StopReason::cancelled) break;
  }
  if (job.report.reached()) return;
  if (job.report.fraction == 1) job.report.fraction = 0;  // stopped between two targets
  if (optimizer.report.stop == StopReason::cancelled) return;
  const auto& mesh = optimizer.work.mesh;
  report_blocking({mesh.tet2vertex.download(), follower.blocking_slots(1 - job.report.fraction), follower.unfinished(),
                   number_vertices(mesh.vertex2original.download(), job.targets[0].size()).work2new()},
                  job.report);
}

/// Runs the phases in order, until one is cancelled. Returns the tracker of the vertices; null with
/// DataTransfer::carry. Untangling is no motion through the input, as an inverted mesh has no places.
template <class Backend>
std::unique_ptr<PlaceTracker> run_phases(Optimizer<Backend>& optimizer, MoveJob* job) {
  const DataTransfer data = optimizer.options.data;
  if (optimizer.work.tangled > 0) {
    if (data == DataTransfer::conserve) {
      throw OptionError("data=conserve needs positive volumes, and " + std::to_string(optimizer.work.tangled) +
                        " tetrahedra are inverted; untangle the mesh with data=carry first");
    }
    untangle(optimizer);
  }
  std::unique_ptr<PlaceTracker> tracker;
  if (data != DataTransfer::carry) {
    const auto& mesh = optimizer.work.mesh;
    tracker =
        std::make_unique<PlaceTracker>(HostMesh(mesh), mesh.vertex2original.download(), optimizer.options.threads);
  }
  if (job == nullptr) {
    improve_with<Backend>(tracker.get())(optimizer);
  } else {
    follow_all(optimizer, *job, tracker.get());
  }
  return tracker;
}

}  // namespace optimize_on_detail

template <class Backend>
Report optimize_on(const Backend& backend, TetMesh& mesh, const Options& options, const Context& context,
                   SlideSurface* surface, MoveJob* job) {
  Report report;
  PhaseTimer timer(report);
  report.vertices = std::ssize(mesh.points);
  report.tets_before = std::ssize(mesh.tets);
  WorkingSet<Backend> work;
  work.scale = job == nullptr ? unit_scale(mesh) : std::min(unit_scale(mesh), job->scale);
  const ImportInput source{.mesh = mesh,
                           .options = options,
                           .slides_on = surface,
                           .linked = job == nullptr ? LinkedVertices::move : LinkedVertices::fixed};
  timer.measure(Phase::load, [&] { import_mesh(backend, source, work, report); });
  if (job != nullptr && options.boundary == Boundary::slide) {
    optimize_on_detail::cut_reference(backend, job->motion, work);
  }

  Optimizer<Backend> optimizer(backend, work, options, context, timer);
  auto tracker = optimize_on_detail::run_phases(optimizer, job);
  optimizer.sum_energy(optimizer.objective());
  report.energy_after = optimizer.in_callers_unit(optimizer.energy());

  if (!options.targets.empty()) {
    timer.measure(Phase::targets, [&] { report.targets = report_targets(constrained_mesh(work, mesh), options); });
  }
  if (tracker != nullptr) {
    timer.measure(Phase::data, [&] { report.places = places_of(*tracker, work, mesh.points.size()); });
    tracker.reset();  // its memory is free for the transfer
  }
  timer.measure(Phase::store, [&] {
    const ExportRules rules{
        .options = options, .is_moved = job != nullptr, .stop_transfer = transfer_stop(context.stop, timer.start())};
    export_mesh(backend, work, rules, mesh, surface, report);
  });
  report.tets_after = std::ssize(mesh.tets);
  return report;
}

}  // namespace tetune
