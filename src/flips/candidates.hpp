// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/harmonic.hpp"
#include "flips/flip_pass.hpp"
#include "flips/least_after.hpp"
#include "flips/offer.hpp"
#include "par/beside_host.hpp"
#include "par/prefetch.hpp"

/// What may be flipped: the faces and edges of each tetrahedron, and which tetrahedron answers for them.
namespace tetune {

/// Proposals between two looks whether a stop is requested: about a tenth of a second of one core, or of a GPU.
template <class Backend>
inline constexpr Size kProposeAtOnce = Size{1} << (par::kBesideHost<Backend> ? 26 : 16);

namespace flip_detail {

/// A tetrahedron that looks for flips in the next pass, and one that does if it is worth a look.
inline constexpr std::uint8_t kWanted = 1;
inline constexpr std::uint8_t kWantedIfWorth = 2;
/// Slack of a tetrahedron that has not looked since it was made or a flip was made beside it: it is due when it is
/// worth a look.
inline constexpr float kNeverSeen = -1;

TETUNE_HD inline std::uint32_t flip_id(Index t, int candidate) {
  return static_cast<std::uint32_t>(t) * kCandidates + static_cast<std::uint32_t>(candidate);
}
TETUNE_HD inline Index id_tet(std::uint32_t id) { return static_cast<Index>(id / kCandidates); }

/// What flips are found in.
struct Candidates {
  MeshView mesh;
  ConstrainedEdges constrained;
  int max_ring;

  /// Candidates 0 to 3 of a tetrahedron are its faces, 4 to 9 its edges.
  TETUNE_HD Cavity cavity(Index t, int candidate) const {
    return candidate < 4 ? face_cavity(mesh, t, candidate)
                         : edge_cavity(edge_star(mesh, max_ring, t, candidate - 4, Never{}), constrained);
  }
  TETUNE_HD Cavity offered(std::uint64_t proposal) const {
    const std::uint32_t id = offer_id(proposal);
    return cavity(id_tet(id), static_cast<int>(id % kCandidates));
  }
  /// The faces of a tetrahedron that a candidate needs to be free, as bits.
  TETUNE_HD static unsigned faces(int candidate) { return candidate < 4 ? 1U << candidate : edge_faces(candidate - 4); }

  struct Never {
    TETUNE_HD bool operator()(Index) const { return false; }
  };
};

TETUNE_HD inline TetEnergy slot_energy(const MeshView& mesh, const Tet& t) {
  return tet_energy(mesh.law, vec(mesh.points[t[0]]), vec(mesh.points[t[1]]), vec(mesh.points[t[2]]),
                    vec(mesh.points[t[3]]));
}

TETUNE_HD inline double energy_before(const Cavity& c, Span<const double> energies) {
  double sum = 0;
  for (int k = 0; k < c.size(); ++k) sum += energies[c.tets[k]];
  return sum;
}

struct EvaluatedSum {
  Size evaluated = 0;
  TETUNE_HD void merge(const EvaluatedSum& other) { evaluated += other.evaluated; }
};

/// Has the active tetrahedra propose by what `propose` makes for a part of them. False where a stop was requested.
template <class Backend, class Make>
bool propose_all(const Backend& par, Span<const Index> active, const Make& propose, FlipReport& report) {
  for (Size first = 0; first < active.size(); first += kProposeAtOnce<Backend>) {
    if (par.stop_requested()) return false;
    const Span<const Index> part(active.data() + first, std::min(kProposeAtOnce<Backend>, active.size() - first));
    report.evaluated += par.template reduce<EvaluatedSum>(part.size(), propose(part)).evaluated;
  }
  return true;
}

/// The order that decides which tetrahedron of a cavity evaluates its flip: the worst, the lowest of equals.
struct Worse {
  Span<const double> energies;
  Index t;
  double energy_t;
  TETUNE_HD bool operator()(Index other) const {
    const double there = energies[other];
    return (there > energy_t) | ((there == energy_t) & (other < t));
  }
};

/// Whether a tetrahedron looks for flips at all. Free slots, of energy 0, do not.
struct IsWorthALook {
  LeastAfter bound;
  Span<const double> energies;
  double least;
  TETUNE_HD bool operator()(Size t) const { return bound.worth_a_look(energies[t]) && energies[t] > least; }
};

/// All of a tetrahedron that flips read and write.
TETUNE_INLINE void fetch_tet(const MeshView& mesh, Span<const double> energies, Index t) {
  par::prefetch(&mesh.tet2tet[t]);
  par::prefetch(&mesh.tet2vertex[t]);
  par::prefetch(&energies[t]);
}

/// What the loop over the active tetrahedra needs soon: those, their neighbours, and the neighbours of these.
struct FetchAhead {
  MeshView mesh;
  Span<const double> energies;
  Span<const Index> active;

  TETUNE_INLINE void operator()(Size i) const {
    constexpr Size kTetsAhead = 24;
    constexpr Size kNeighboursAhead = 12;
    constexpr Size kFartherAhead = 5;
    if (i + kTetsAhead >= active.size()) return;
    fetch_tet(mesh, energies, active[i + kTetsAhead]);
    fetch_neighbours(active[i + kNeighboursAhead]);
    for_neighbours(active[i + kFartherAhead], [this](Index other) { fetch_neighbours(other); });
  }

 private:
  /// Reads what lies across the faces of t itself.
  TETUNE_INLINE void fetch_neighbours(Index t) const {
    for_neighbours(t, [this](Index other) { fetch_tet(mesh, energies, other); });
  }
  template <class F>
  TETUNE_INLINE void for_neighbours(Index t, const F& f) const {
    const Links links = mesh.tet2tet[t];
    for (int face = 0; face < 4; ++face) f(is_locked(links[face]) ? t : link_tet(links[face]));
  }
};

}  // namespace flip_detail
}  // namespace tetune
