// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "operators/flips/boundary_flip.hpp"
#include "operators/flips/face_removal.hpp"
#include "operators/flips/flip_pass.hpp"
#include "phases/optimizer.hpp"

namespace tetune {

/// The flips between two sweeps: one pass over the edges of the boundary, one pass of face removals, then passes of
/// other flips until they gain little. They are exhaustive with Termination::paper and without sweeps: they end when no
/// tetrahedron has a flip that lowers the energy. A pass examines only what the last one changed and its neighbors;
/// hence, when it finds no flip, all tetrahedra around the changed vertices are examined once more.
template <class Backend>
class FlipUntilStable {
 public:
  FlipUntilStable(Optimizer<Backend>& optimizer, const Criterion& criterion)
      : optimizer_(optimizer),
        criterion_(criterion),
        exhaustive_(optimizer.options.termination == Termination::paper || optimizer.options.max_iterations == 0),
        examines_around_(exhaustive_ && optimizer.options.max_ring > kNeighborRing),
        flips_boundary_(optimizer.work.boundary.triangles.size() > 0 && flips_boundary(optimizer.options)) {}

  /// After a sweep, only tetrahedra above this energy propose flips.
  double min_energy() const {
    const bool all = exhaustive_ || optimizer_.options.energy != Energy::shape;
    return all ? 0 : optimizer_.tuning.alternation.flip_energy;
  }

  /// Flips from the active tetrahedra on, after sweep `iteration` (0: before the first). Activates the vertices whose
  /// ring changes. Returns the number of flips, or nothing when the caller cancels.
  std::optional<Size> run(int iteration) {
    iteration_ = iteration;
    pass_ = 0;
    flips_ = 0;
    if (!optimizer_.options.flips) return flips_;
    clear_changed();
    // Before the first sweep, neither boundary flips nor face removals: slivers must have been removed.
    if (iteration > 0 && !(flip_boundary() && remove_faces())) return {};
    while (has_active()) {
      const Pass pass = measure_pass(Phase::flips, [this] {
        return flip_pass(optimizer_.backend, optimizer_.work.mesh, criterion_, optimizer_.work.flips,
                         optimizer_.changed.output());
      });
      if (pass.cancelled) return {};
      const bool stable = exhaustive_ ? pass.flips == 0 && !reactivate_changed() : pass.gained_little;
      if (stable) break;
    }
    activate(optimizer_.backend, optimizer_.changed, optimizer_.work.dofs);
    return flips_;
  }

 private:
  struct Pass {
    Size flips;
    bool gained_little;
    bool cancelled;
  };

  /// Returns false when the caller cancels.
  bool flip_boundary() {
    if (!flips_boundary_) return true;
    // The pass examines the edges of the vertices that it is given: the active ones. If it flips, exhaustive flips
    // examine all of these again.
    optimizer_.changed.assign(optimizer_.backend, optimizer_.work.dofs.active);
    const Pass pass = measure_pass(Phase::boundary_flips, [this] {
      return boundary_flip_pass(optimizer_.backend, optimizer_.work.mesh, criterion_, optimizer_.work.flips,
                                optimizer_.work.boundary, optimizer_.work.dofs.checked.view(),
                                optimizer_.changed.output());
    });
    flips_boundary_ = !pass.gained_little;
    if (pass.flips == 0) clear_changed();
    return !pass.cancelled;
  }
  bool remove_faces() {
    if (!removes_faces_ || !has_active()) return true;
    const Pass pass = measure_pass(Phase::flips, [this] {
      return face_removal_pass(optimizer_.backend, optimizer_.work.mesh, criterion_, optimizer_.work.flips,
                               optimizer_.changed.output());
    });
    removes_faces_ = !pass.gained_little;
    return !pass.cancelled;
  }

  /// Runs a flip pass, and updates energy and report.
  template <class FlipPass>
  Pass measure_pass(Phase phase, const FlipPass& pass) {
    PassResult result;
    const double seconds = optimizer_.timer.measure(phase, [&] { result = pass(); });
    optimizer_.decrease_energy(result.decrease, criterion_.objective);
    const double min_decrease = optimizer_.tuning.alternation.min_pass_decrease * optimizer_.energy();
    const FlipReport r{result.counts, iteration_,       ++pass_,
                       result.active, result.evaluated, optimizer_.in_callers_unit(result.decrease),
                       seconds};
    optimizer_.record_flips(r);
    optimizer_.report.flip_passes.push_back(r);
    flips_ += r.flips();
    unexamined_flips_ = unexamined_flips_ || r.flips() > 0;
    if (iteration_ == 0) optimizer_.progress.estimate.finish_first_flips(pass_);
    return {r.flips(), result.decrease < min_decrease, !optimizer_.proceed(Phase::flips, iteration_)};
  }

  bool has_active() {
    return pass_ < kMaxFlipPasses && (optimizer_.work.flips.active.size() > 0 || reactivate_changed());
  }
  /// With exhaustive flips, activates all tetrahedra that may own a candidate with a tetrahedron made since the last
  /// call. Returns false if there are none, as where all tetrahedra of a candidate are neighbors: then those are active
  /// already.
  bool reactivate_changed() {
    if (!examines_around_ || !unexamined_flips_) return false;
    optimizer_.timer.measure(Phase::flips, [&] {
      activate_around(optimizer_.backend, optimizer_.work.mesh, optimizer_.work.flips, optimizer_.changed.flags());
    });
    clear_changed();
    return optimizer_.work.flips.active.size() > 0;
  }
  void clear_changed() {
    optimizer_.changed.clear(optimizer_.backend, optimizer_.work.mesh.vertices());
    unexamined_flips_ = false;
  }

  /// In a ring of this number of tetrahedra each two have a face in common.
  static constexpr int kNeighborRing = 3;

  Optimizer<Backend>& optimizer_;
  const Criterion criterion_;
  const bool exhaustive_;
  const bool examines_around_;
  int iteration_ = 0;
  int pass_ = 0;
  Size flips_ = 0;
  bool unexamined_flips_ = false;
  bool flips_boundary_;        ///< false for good once a pass of boundary flips has gained little
  bool removes_faces_ = true;  ///< likewise for face removals
};

}  // namespace tetune
