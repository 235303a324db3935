// SPDX-License-Identifier: Apache-2.0
#include "tetune/optimize.hpp"

#include <chrono>
#include <string>

#include "core/first_ids.hpp"
#include "driver/alternate.hpp"
#include "driver/devices.hpp"
#include "driver/slide_on.hpp"
#include "driver/targets.hpp"
#include "flips/flip.hpp"
#include "par/cpu.hpp"
#include "tetune/error.hpp"

namespace tetune {

const char* to_string(StopReason reason) {
  switch (reason) {
    case StopReason::converged:
      return "converged";
    case StopReason::gradient_small:
      return "gradient small (C1)";
    case StopReason::gradient_stationary:
      return "gradient stationary (C2)";
    case StopReason::no_flips:
      return "no more flips (C3)";
    case StopReason::iteration_limit:
      return "iteration limit";
    case StopReason::cancelled:
      return "cancelled";
  }
  return "unknown";
}

namespace {

std::string untangle_message(std::int64_t tangled, const std::vector<Index>& left, UntangleError::Reason reason,
                             bool one_based) {
  if (reason == UntangleError::Reason::stopped) {
    return "stopped before all of " + std::to_string(tangled) +
           " inverted or flat tetrahedra were made positive: " + std::to_string(left.size()) + " are left" +
           first_ids(left, one_based);
  }
  const bool slides = reason == UntangleError::Reason::no_room_though_sliding;
  return "of " + std::to_string(tangled) +
         " inverted or flat tetrahedra some could not be made positive, or not without folding the surface: " +
         std::to_string(left.size()) + " tetrahedra there" + first_ids(left, one_based) +
         "\n  their vertices have no room: " + (slides ? "" : "let the boundary slide (--boundary slide), ") +
         "free what is frozen there, or repair the surface.";
}

std::string overlap_message(const std::vector<Index>& tets, bool one_based) {
  return "the mesh overlaps itself: flips would make faces that three or more tetrahedra share, near tetrahedra" +
         first_ids(tets, one_based) +
         "\n  repair it in the program that made it, or leave its connectivity as it is (--no-flips --keep-vertices).";
}

}  // namespace

UntangleError::UntangleError(std::int64_t all, std::vector<Index> rest, Reason why)
    : MeshError(untangle_message(all, rest, why, false)), tangled(all), left(std::move(rest)), reason(why) {}

std::string UntangleError::message(bool one_based) const { return untangle_message(tangled, left, reason, one_based); }

OverlapError::OverlapError(std::vector<Index> there)
    : MeshError(overlap_message(there, false)), tets(std::move(there)) {}

std::string OverlapError::message(bool one_based) const { return overlap_message(tets, one_based); }

namespace {

/// `surface`: what to slide on, if not what the mesh comes with.
Report run(TetMesh& mesh, const Options& options, const Context& context, SlideSurface* surface) {
  if (options.max_iterations < 0) {
    throw OptionError("max_iterations is " + std::to_string(options.max_iterations) + "; it must be 0 or more");
  }
  if (options.max_ring < 3 || options.max_ring > kMaxRing) {
    throw OptionError("max_ring is " + std::to_string(options.max_ring) + "; it must be 3 to " +
                      std::to_string(kMaxRing));
  }
  if (!options.flips && options.max_iterations == 0) {
    throw OptionError("without flips and with max_iterations 0 there is nothing to do; allow one of them");
  }
  if (options.threads < 0) {
    throw OptionError("threads is " + std::to_string(options.threads) + "; it must be 0 (all) or more");
  }
  if (!(options.feature_angle > 0 && options.feature_angle <= 180)) {
    throw OptionError("feature_angle is " + std::to_string(options.feature_angle) +
                      " degrees; it must be above 0 and at most 180");
  }
  if (!(options.max_deviation >= 0)) {
    throw OptionError("max_deviation is " + std::to_string(options.max_deviation) + "; it must be 0 (none) or more");
  }
  if (options.max_deviation > 0 && options.boundary != Boundary::slide) {
    throw OptionError("max_deviation has no effect unless the boundary slides; drop it, or set boundary to slide");
  }
  for (const Target& target : options.targets) check_target(target);
  // Who asks to stop need not go on asking: what was left undone then is no result to go on from.
  bool stopped = false;
  Context until_stopped;
  until_stopped.stop = [&] { return stopped = stopped || (context.stop && context.stop()); };
  if (context.progress) {
    until_stopped.progress = [&](const Progress& p) { return !(stopped = stopped || !context.progress(p)); };
  }
  const auto start = std::chrono::steady_clock::now();
  DeviceChoice choice{options.device, ""};
  if (options.device == Device::automatic) choice = choose_device(mesh, options);
  Report report;
  if (choice.device == Device::cuda) {
    report = optimize_on_cuda(mesh, options, until_stopped, surface);
  } else {
    const par::Cpu cpu(options.threads, until_stopped.stop);
    report = optimize_on(cpu, mesh, options, until_stopped, surface);
    report.device = "CPU";
    report.threads = cpu.threads();
  }
  report.device_reason.swap(choice.reason);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace

Report optimize(TetMesh& mesh, const Options& options, const Context& context) {
  return run(mesh, options, context, nullptr);
}

Report optimize(TetMesh& mesh, const Options& options, const Context& context, SlideSurface& surface) {
  return run(mesh, options, context, &surface);
}

}  // namespace tetune
