// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/mesh_energy.hpp"
#include "energy/slot_pack.hpp"

namespace tetune {
namespace mesh_energy_detail {

template <class Pack>
struct RefreshEnergy {
  RatedMesh mesh;
  Span<double> energies;
  TETUNE_HD backend::Sum<double> operator()(Size pack) const {
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
  TETUNE_HD backend::Sum<double> operator()(Size t) const { return {energies[t]}; }
};

}  // namespace mesh_energy_detail

template <class Backend>
double refresh_energy(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                      Energies<Backend>& energies) {
  using namespace mesh_energy_detail;
  using Pack = typename Backend::Pack;
  energies.resize(backend, mesh.slots(), mesh.room());
  const RefreshEnergy<Pack> refresh{rated(mesh, criterion), energies.span()};
  return backend.template reduce<backend::Sum<double>>(SlotPack<Pack>::pack_count(mesh.slots()), refresh).value;
}

template <class Backend>
void refresh_energy_of(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                       Energies<Backend>& energies, Span<const Index> slots) {
  using namespace mesh_energy_detail;
  backend.for_each(slots.size(), RefreshEnergyOf{rated(mesh, criterion), energies.span(), slots});
}

template <class Backend>
double sum_energy(const Backend& backend, Energies<Backend>& energies) {
  using namespace mesh_energy_detail;
  return backend.template reduce<backend::Sum<double>>(energies.size(), EnergyOf{energies.span()}).value;
}

}  // namespace tetune
