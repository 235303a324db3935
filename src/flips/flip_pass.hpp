// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/work_mesh.hpp"
#include "flips/flip.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// A flip must lower the energy of its cavity by this part: above round-off, and so that no flip is undone by another.
inline constexpr double kMinRelativeGain = 1e-9;

/// A tetrahedron is examined again when it has drifted by the least part by which one of its flips would have raised
/// the energy, or by this. Drift is kDriftRate times the longest move of a vertex over the height of the tetrahedron:
/// docs/method.md, "Flips".
inline constexpr double kMaxSlack = 0.2;
inline constexpr double kDriftRate = 0.35;
/// The same for an energy of other powers than eta = 1.5 q / w.
TETUNE_HD inline double drift_rate(const EnergyLaw& law) { return kDriftRate * (law.gu - law.gv) / 3; }

/// Candidates of one tetrahedron: four faces, six edges.
inline constexpr int kCandidates = 10;
/// Most slots of a mesh: flip ids, slot * kCandidates + candidate, have 32 bits.
inline constexpr Size kMaxSlots = (Size{1} << 32) / kCandidates;
static_assert(4 * kMaxSlots <= Size{kLocked}, "links must be able to address all slots");

/// Throws MeshError when flips would need more slots than there can be.
inline void check_slots(Size needed) {
  if (needed <= kMaxSlots) return;
  throw MeshError("flips would need room for " + std::to_string(needed) + " tetrahedra; there can be at most " +
                  std::to_string(kMaxSlots) + ". Use a smaller mesh, or flips that add fewer (max_ring 3).");
}

/// What the flip passes keep between them, in a backend's memory.
template <class Backend>
struct FlipState {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;
  /// Energy of each slot under the law of the mesh; 0 for a free one.
  Buffer<double> energies;
  /// The best flip proposed for each slot: gain in the high half, flip id in the low one. 0: none.
  Buffer<std::uint64_t> proposal;
  /// The slots to examine, and what each slot has to do with the next of them: 0, kWanted or kWantedIfWorth.
  Buffer<Index> active;
  Buffer<std::uint8_t> wanted;
  /// Edges inside a region that must stay.
  Buffer<std::uint64_t> constrained_keys;
  Buffer<std::uint8_t> constrained_vertex;
  /// For each slot, how far the flips of its tetrahedron are from being worth it: the least part by which one would
  /// raise the energy, kMaxSlack at most, less what the tetrahedron has drifted since.
  Buffer<float> slack;
  /// The positions that drift is measured from.
  Buffer<Point> seen;
  /// Tetrahedra look for flips while their energy is above this.
  double least = 0;
  /// Largest ring of an edge removal, 3 to kMaxRing.
  int max_ring = kMaxRing;

  ConstrainedEdges constrained() { return {constrained_keys.span(), constrained_vertex.span()}; }
};

/// Computes the energy of each slot from the positions, and returns the sum.
template <class Backend>
double refresh_energy(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state);

/// The same of some slots alone.
template <class Backend>
void refresh_energy_of(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, Span<const Index> slots);

/// Sums up the energies as they are.
template <class Backend>
double sum_energy(const Backend& par, FlipState<Backend>& state);

/// Makes every tetrahedron active whose energy is above `least`, and lets no others look for flips until tetrahedra are
/// made active again.
template <class Backend>
void activate_all(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, double least = 0);

/// After vertices have moved: computes the energy of each slot again, and makes the tetrahedra active that have drifted
/// so far that a flip around them may have become worth it, and whose energy is above `least`. Returns their sum.
template <class Backend>
double activate_drifted(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, double least = 0);

/// Makes the tetrahedra active that have an edge between flagged vertices.
template <class Backend>
void activate_around(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                     Span<const std::uint8_t> flags);

/// One pass of Alg. 5 over the active set: every active tetrahedron proposes its flips, a flip is carried out when it
/// is the best one of all its tetrahedra, and the next active set is what changed, what is beside it, and what was
/// refused. In place: a 2-3 flip takes a slot, a 3-2 flip frees one, an edge removal with n > 4 tetrahedra takes n - 4,
/// and the links are kept up to date. `awake`, when given, is set for the vertices whose ring changed. Throws
/// MeshError, before anything is changed, when there can be no such number of slots.
template <class Backend>
FlipReport flip_pass(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state, Span<std::uint8_t> awake);

/// Far above what any mesh needs: each pass lowers the energy, so this bounds a run in which rounding says otherwise.
inline constexpr int kMaxFlipPasses = 1000;

/// Passes until one makes no flip; the flips of all.
template <class Backend>
FlipReport flip_until_none(const Backend& par, WorkMesh<Backend>& mesh, FlipState<Backend>& state,
                           Span<std::uint8_t> awake) {
  FlipReport all;
  for (int pass = 0; pass < kMaxFlipPasses && state.active.size() > 0; ++pass) {
    const FlipReport f = flip_pass(par, mesh, state, awake);
    if (f.flips() == 0) break;
    all.flips23 += f.flips23;
    all.flips32 += f.flips32;
    all.edge_removals += f.edge_removals;
  }
  return all;
}

}  // namespace tetune
