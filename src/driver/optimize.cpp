// SPDX-License-Identifier: Apache-2.0
#include "tetune/optimize.hpp"

#include <string>
#include <utility>

#include "backend/cpu.hpp"
#include "driver/curved/optimize_curved.hpp"
#include "driver/devices.hpp"
#include "driver/distributed_interface.hpp"
#include "driver/parts/optimize_active.hpp"
#include "driver/report/run_warnings.hpp"
#include "mesh/keep_entities.hpp"
#include "mesh/messages.hpp"
#include "phases/progress/latched_hooks.hpp"
#include "phases/progress/phase_timer.hpp"
#include "tetune/error.hpp"
#include "tetune/option_table.hpp"

namespace tetune {

const char* to_string(StopReason reason) {
  return name_of(reason, {"converged", "gradient small (C1)", "gradient stationary (C2)", "no more flips (C3)",
                          "iteration limit", "cancelled"});
}

Report run_on_device(TetMesh& mesh, const Options& options, const Context& context, SlideSurface* surface,
                     MoveJob* job) {
  check_options(options);
  if (!mesh.curved_edges.empty()) {
    throw MeshError("the mesh has " + std::to_string(mesh.curved_edges.size()) +
                    " curved edges of second-order elements, which are not supported here; convert it to straight ones "
                    "(order 1: an empty curved_edges)");
  }
  const LatchedHooks hooks(context);
  const Context& until_stopped = hooks.context();
  const auto start = PhaseTimer::SteadyClock::now();
  DeviceChoice choice{options.device, ""};
  if (options.device == Device::automatic) choice = choose_device(mesh, options, job);
  RunWarnings warnings(mesh, options);
  Report report;
  if (choice.device == Device::cuda) {
    report = optimize_on_cuda(mesh, options, until_stopped, surface, job);
  } else {
    const backend::Cpu cpu(options.threads, until_stopped.stop);
    report = optimize_on(cpu, mesh, options, until_stopped, surface, job);
    report.device = "CPU";
    report.threads = cpu.threads();
  }
  report.device_reason.swap(choice.reason);
  warnings.add_to(report, std::exchange(report.warnings, {}));
  report.seconds = PhaseTimer::seconds_since(start);
  return report;
}

Report optimize(TetMesh& mesh, const Options& options, const Context& context) {
  if (!mesh.curved_edges.empty()) return optimize_curved(mesh, options, context);
  if (!options.only_below.empty()) return optimize_active(mesh, options, context);
  return run_on_device(mesh, options, context, nullptr, nullptr);
}

Report optimize(TetMesh& mesh, const Options& options, const Context& context, SlideSurface& surface) {
  return run_on_device(mesh, options, context, &surface, nullptr);
}

void erase_vertices(TetMesh& mesh, const std::vector<std::uint8_t>& keep) {
  keep_vertices(mesh, positions_of_kept(keep));
}

}  // namespace tetune
