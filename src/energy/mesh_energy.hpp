// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/criterion.hpp"
#include "energy/harmonic.hpp"
#include "energy/slot_pack.hpp"

/// The energies of the tetrahedra of a mesh: one per slot, 0 for a free slot.
namespace tetune {

template <class Backend>
using Energies = BufferOf<Backend, double>;

TETUNE_HD inline TetEnergy slot_energy(const RatedMesh& mesh, const Tet& t) {
  return tet_energy(mesh.objective, vec(mesh.points[t[0]]), vec(mesh.points[t[1]]), vec(mesh.points[t[2]]),
                    vec(mesh.points[t[3]]));
}

namespace mesh_energy_detail {

template <class Pack>
struct RefreshEnergy {
  RatedMesh mesh;
  Span<double> energies;
  TETUNE_HD Sum<double> operator()(Size pack) const {
    const SlotPack<Pack> slots(mesh, pack);
    return slots.store_and_sum(slots.energy().energy, energies);
  }
};

struct RefreshEnergyOf {
  RatedMesh mesh;
  Span<double> energies;
  Span<const Index> slots;
  TETUNE_HD void operator()(Size i) const {
    const Index t = slots[i];
    energies[t] = mesh.alive(t) ? slot_energy(mesh, mesh.tet2vertex[t]).energy : 0;
  }
};

struct EnergyOf {
  Span<const double> energies;
  TETUNE_HD Sum<double> operator()(Size t) const { return {energies[t]}; }
};

}  // namespace mesh_energy_detail

/// Computes the energy of each slot from the positions, and returns the sum.
template <class Backend>
double refresh_energy(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                      Energies<Backend>& energies) {
  using namespace mesh_energy_detail;
  using Pack = typename Backend::Pack;
  energies.resize(backend, mesh.slots(), mesh.room());
  const RefreshEnergy<Pack> refresh{rated(mesh, criterion), energies.span()};
  return backend.template reduce<Sum<double>>(SlotPack<Pack>::pack_count(mesh.slots()), refresh).value;
}

/// refresh_energy() for the listed slots, without the sum.
template <class Backend>
void refresh_energy_of(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                       Energies<Backend>& energies, Span<const Index> slots) {
  using namespace mesh_energy_detail;
  backend.for_each(slots.size(), RefreshEnergyOf{rated(mesh, criterion), energies, slots});
}

/// The sum of the stored energies.
template <class Backend>
double sum_energy(const Backend& backend, Energies<Backend>& energies) {
  using namespace mesh_energy_detail;
  return backend.template reduce<Sum<double>>(energies.size(), EnergyOf{energies}).value;
}

}  // namespace tetune
