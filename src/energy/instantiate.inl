// SPDX-License-Identifier: Apache-2.0
// Included once per backend, by a file that defines Instance.
#include "energy/mesh_energy.inl"

namespace tetune {
template double refresh_energy(const Instance&, WorkMesh<Instance>&, const Criterion&, Energies<Instance>&);
template void refresh_energy_of(const Instance&, WorkMesh<Instance>&, const Criterion&, Energies<Instance>&,
                                Span<const Index>);
template double sum_energy(const Instance&, Energies<Instance>&);
}  // namespace tetune
