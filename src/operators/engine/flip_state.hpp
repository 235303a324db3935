// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "energy/mesh_energy.hpp"
#include "mesh/constrained_edges.hpp"
#include "mesh/edge_star.hpp"
#include "operators/engine/bid.hpp"
#include "tetune/flip_counts.hpp"

namespace tetune {

/// A flip must lower the energy of its cavity by this fraction: above round-off, and so that no flip undoes another.
inline constexpr double kMinRelativeGain = 1e-9;
/// A limit far above the number of passes that any mesh needs: in exact arithmetic each lowers the energy, and passes
/// end.
inline constexpr int kMaxFlipPasses = 1000;

/// A tetrahedron is evaluated again once it has drifted by its slack: the smallest relative amount by which one of its
/// flips would have raised the energy, at most kMaxSlack. Drift is kDriftRate times the longest move of a vertex over
/// the height of the tetrahedron (docs/method.md, "Which candidates are evaluated").
inline constexpr double kMaxSlack = 0.2;
inline constexpr double kDriftRate = 0.35;
/// kDriftRate is the rate for eta = 1.5 q / w; for another objective it grows with the exponents of q and w.
TETUNE_HD inline double drift_rate(const Objective& objective) {
  return kDriftRate * (objective.gu - objective.gv) / 3;
}

/// The mark of a slot whose tetrahedron is evaluated in the next pass.
inline constexpr std::uint8_t kActive = 1;
/// The mark of a slot whose tetrahedron is evaluated if its energy admits a gain (FlipEnergyLowerBound).
inline constexpr std::uint8_t kActiveIfPromising = 2;
/// Slack of a new tetrahedron, or one with a changed neighbor: it is evaluated again if it may gain.
inline constexpr float kUnknownSlack = -1;

/// The result of one pass of an operator.
struct PassResult {
  FlipCounts counts;
  double decrease = 0;  ///< of the energy
  Size active = 0;      ///< proposals
  Size evaluated = 0;   ///< candidates
};

/// The state that operators keep between passes, in a backend's memory.
template <class Backend>
struct FlipState {
  template <class T>
  using Buffer = BufferOf<Backend, T>;
  /// Energy of each slot; 0 for a free one.
  Buffer<double> energies;
  /// The highest bid on each slot: gain in the high half, id in the low one. Scratch of a pass.
  Buffer<std::uint64_t> tet2bid;
  /// The highest bid on each slot that stands for edges (slot_of_edge()). Scratch of a pass.
  Buffer<std::uint64_t> edge2bid;
  /// Whether an activation has set the bids of all slots to 0.
  bool bids_are_clear = false;
  /// The slots to evaluate, and for each slot 0, kActive or kActiveIfPromising.
  Buffer<Index> active;
  Buffer<std::uint8_t> marks;
  /// Edges inside a region that must stay.
  Buffer<std::uint64_t> constrained_keys;
  Buffer<std::uint8_t> constrained_vertex;
  /// For each slot, the smallest part by which a flip of its tetrahedron would raise the energy, at most kMaxSlack,
  /// less what the tetrahedron has drifted since.
  Buffer<float> slack;
  /// The positions that drift is measured from.
  Buffer<Point> drift_origin;
  /// Tetrahedra are evaluated while their energy is above this.
  double min_energy = 0;
  /// The largest ring of an edge removal, 3 to kMaxRing; 0: no flips.
  int max_ring = kMaxRing;

  /// Frees the memory of the sets that the next activation makes again.
  void release_active() {
    active = {};
    tet2bid = {};
    edge2bid = {};
    bids_are_clear = false;
  }

  Bids highest() { return {tet2bid.span(), edge2bid.span()}; }
  ConstrainedEdges constrained() { return {constrained_keys.span(), constrained_vertex.span()}; }

  /// Called before a pass, whose bids are not clear afterwards. The number of slots may have changed since the last
  /// activation.
  void start_pass(const Backend& backend, const WorkMesh<Backend>& mesh, Size edge_slots) {
    grow_filled(backend, marks, mesh.slots(), std::uint8_t{0});
    if (!bids_are_clear || tet2bid.size() != mesh.slots()) {
      tet2bid.resize(backend, mesh.slots(), mesh.room());
      backend.fill(tet2bid.span(), std::uint64_t{0});
    }
    bids_are_clear = false;
    edge2bid.resize(backend, edge_slots);
    if (edge_slots > 0) backend.fill(edge2bid.span(), std::uint64_t{0});
  }

  void make_room(const Backend& backend, Size slots) {
    energies.grow(backend, slots);
    tet2bid.grow(backend, slots);
    grow_filled(backend, marks, slots, std::uint8_t{0});
    grow_filled(backend, slack, slots, kUnknownSlack);
  }
};

}  // namespace tetune
