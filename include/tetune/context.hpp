// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace tetune {

/// The state of a run, for the progress callback.
struct Progress {
  /// The step that was completed: "load" (once, the mesh is checked and loaded; or "untangling" first), "flips",
  /// "sweep", "worst" (a round for the mean energy or the worst elements), "angles" (a round on the extreme dihedral
  /// angles, or a final sweep) or "restarts" (a round of them).
  const char* phase;
  int iteration;         ///< number of relocation sweeps so far
  double energy;         ///< now; the sum that Options::energy names
  double energy_before;  ///< at the start
  double worst_angle;    ///< smallest dihedral angle, degrees; possibly of some passes ago, because it is measured only
                         ///< while that costs less than 1 % of the time
  double fraction;       ///< of the run that is done, 0 to 1, never decreasing: an estimate
  double seconds;        ///< since optimize() was called
  double seconds_left;   ///< an estimate; negative while there is none
};

/// Hooks of the caller, both called on the calling thread. They cannot change the result except by stopping.
///
/// If one of them requests a stop, optimize() returns at the next safe point, with StopReason::cancelled: the mesh is
/// the best so far, and as valid as any result. Once the mesh is loaded there are several safe points per second, on
/// large meshes too. Only DataTransfer::conserve may take as long again, see Report::transfer_stopped, and a run with
/// Options::only_below that has removed more vertices than inserted: it is repeated with the same vertices, until flips
/// and sweeps have converged.
struct Context {
  /// Called between passes; returns false to stop.
  std::function<bool(const Progress&)> progress;
  /// Called at each safe point; returns true to stop.
  std::function<bool()> stop;
};

}  // namespace tetune
