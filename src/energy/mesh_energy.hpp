// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/criterion.hpp"
#include "energy/harmonic.hpp"

/// The energies of the tetrahedra of a mesh: one per slot, 0 for a free slot.
namespace tetune {

template <class Backend>
using Energies = typename Backend::template Buffer<double>;

TETUNE_HD inline TetEnergy slot_energy(const RatedMesh& mesh, const Tet& t) {
  return tet_energy(mesh.objective, vec(mesh.points[t[0]]), vec(mesh.points[t[1]]), vec(mesh.points[t[2]]),
                    vec(mesh.points[t[3]]));
}

/// Computes the energy of each slot from the positions, and returns the sum.
template <class Backend>
double refresh_energy(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                      Energies<Backend>& energies);

/// refresh_energy() for the listed slots, without the sum.
template <class Backend>
void refresh_energy_of(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                       Energies<Backend>& energies, Span<const Index> slots);

/// The sum of the stored energies.
template <class Backend>
double sum_energy(const Backend& backend, Energies<Backend>& energies);

}  // namespace tetune
