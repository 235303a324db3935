// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "phases/improve_around.hpp"

namespace tetune {
namespace lower_mean_energy_detail {

/// A number other than 0 for a tetrahedron of these vertices; another one for almost all others.
TETUNE_HD inline std::uint32_t fingerprint(const Tet& tet) {
  constexpr std::uint32_t kMultiplier = 0x9e3779b1;
  std::uint32_t hash = 0;
  for (int k = 0; k < 4; ++k) hash = (hash ^ std::uint32_t(tet[k])) * kMultiplier;
  return hash | 1;
}

/// Flags the vertices of the tetrahedra that have another fingerprint than before.
struct FlagVerticesOfNew {
  MeshView mesh;
  Span<std::uint32_t> fingerprints;
  Span<std::uint8_t> flags;
  TETUNE_HD void operator()(Size t) const {
    if (!mesh.alive(t)) return;
    const Tet tet = mesh.tet2vertex[t];
    if (fingerprints[t] == fingerprint(tet)) return;
    fingerprints[t] = fingerprint(tet);
    for (int k = 0; k < 4; ++k) backend::store_shared(flags[tet[k]], std::uint8_t{1});
  }
};

struct IsAboveWithFlag {
  IsAbove is_above;
  HasFlaggedVertex has_flagged;
  TETUNE_HD bool operator()(Size t) const { return is_above(t) && has_flagged(t); }
};

/// Finds the tetrahedra whose neighborhood has other tetrahedra than at the last call: where nothing but positions has
/// changed, almost all proposals would fail again.
template <class Backend>
class NewNeighborhoods {
 public:
  /// Returns those of the tetrahedra above a bound on the energy; all of them at the first call.
  BufferOf<Backend, Index> find_above(Optimizer<Backend>& optimizer, double bound) {
    const Backend& backend = optimizer.backend;
    WorkMesh<Backend>& mesh = optimizer.work.mesh;
    grow_filled(backend, fingerprints_, mesh.slots(), std::uint32_t{0});
    VertexMask<Backend> flags(backend, mesh.vertices());
    backend.fill(flags.span(), std::uint8_t{0});
    backend.for_each(mesh.slots(), FlagVerticesOfNew{mesh.view(), fingerprints_.span(), flags.span()});
    return find_tets(backend, mesh,
                     IsAboveWithFlag{IsAbove{optimizer.slot_energies(), bound}, {mesh.view(), flags.span()}});
  }

 private:
  BufferOf<Backend, std::uint32_t> fingerprints_;  ///< per slot; 0: none
};

/// One round, on at most `max_fraction` of the tetrahedra. `energy`: its sum over the mesh, before and after. Returns
/// (E0 - E1) / (E0 - 1), where E0 and E1 are the means before and after.
template <class Backend>
double lower_once(Optimizer<Backend>& optimizer, const Criterion& criterion, double max_fraction,
                  RetriangulationLimits limits, NewNeighborhoods<Backend>& neighborhoods, double& energy,
                  WorstReport& r) {
  const Backend& backend = optimizer.backend;
  WorkingSet<Backend>& work = optimizer.work;
  const auto mean_energy = [&] { return energy / static_cast<double>(work.mesh.tets()); };
  limits.mean_energy = mean_energy();
  const double max_above = max_fraction * static_cast<double>(work.mesh.tets());
  const double bound = upper_quantile(backend, optimizer.slot_energies(), max_above);
  const auto worst = tets_above(backend, work.mesh, optimizer.slot_energies(), bound);
  const auto proposers = neighborhoods.find_above(optimizer, bound);
  r.worst = worst.size();
  const auto improved = improve_around(optimizer, criterion, worst.span(), proposers.span(), limits, r);
  energy = sum_energy(backend, work.flips.energies);
  r.moved = improved.swept.get().moved;
  return (limits.mean_energy - mean_energy()) / (limits.mean_energy - 1);
}

}  // namespace lower_mean_energy_detail

/// The objective whose mean describes the present mesh: the shape energy, or a root of it where a few tetrahedra that
/// nothing improves make up the mean energy, as around layers much thinner than the elements are wide. Below such a
/// mean even a poor new tetrahedron would be a gain.
template <class Backend>
Objective mean_objective(const Optimizer<Backend>& optimizer) {
  const double mean = optimizer.energy() / double(optimizer.work.mesh.tets());
  return mean > MeanParameters::kMaxMean ? shape_objective(MeanParameters::kLog2Root) : kShapeObjective;
}

/// Inserts and removes vertices where that lowers the mean of the criterion's objective over the mesh, in rounds around
/// its tetrahedra of the largest energies. Reports Report::worst_rounds. Returns false when the caller cancels.
template <class Backend>
bool lower_mean_energy(Optimizer<Backend>& optimizer, const MeanParameters& p, const Criterion& criterion) {
  if (!edits_vertices(optimizer.options)) return true;
  RetriangulationLimits limits = retriangulation_limits(optimizer, kInfeasible, p.growth_fraction);
  limits.min_gain = p.min_gain;
  limits.is_selective = p.is_selective;
  double energy = 0;
  optimizer.timer.measure(Phase::worst, [&] { energy = optimizer.sum_energy(criterion.objective); });
  lower_mean_energy_detail::NewNeighborhoods<Backend> neighborhoods;
  double fall = 1;
  for (int round = 1; round <= p.max_rounds && fall > p.min_fall; ++round) {
    WorstReport r;
    r.work = "mean energy";
    r.round = round;
    r.seconds = optimizer.timer.measure(Phase::worst, [&] {
      fall =
          lower_mean_energy_detail::lower_once(optimizer, criterion, p.max_fraction, limits, neighborhoods, energy, r);
    });
    if (criterion.objective.log2_power == 0) optimizer.set_energy(energy);
    r.dihedral_min = optimizer.traced_angle();
    optimizer.report.worst_rounds.push_back(r);
    if (!optimizer.proceed(Phase::worst, optimizer.iteration())) return false;
  }
  return true;
}

}  // namespace tetune
