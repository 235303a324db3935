// SPDX-License-Identifier: Apache-2.0
// Included once for each backend, by a file that says which: Instance, and the ring of its sweeps: InstanceRing.
#include "energy/soft_ring.hpp"
#include "relocate/coloring.inl"
#include "relocate/sweep.inl"

namespace tetune {

template <class Backend, class Step>
SweepSum sweep(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings, const Coloring<Backend>& coloring,
               Mobilities<Backend>& mobilities, const Step& step) {
  return sweep_with<InstanceRing>(par, mesh, rings, coloring, mobilities, step);
}

template <class Backend, class Step>
SweepSum soft_sweep(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings,
                    const Coloring<Backend>& coloring, Mobilities<Backend>& mobilities, const Step& step) {
  return sweep_with<SoftRing>(par, mesh, rings, coloring, mobilities, step);
}

template void color_vertices(const Instance&, const RingsView&, Span<const Mobility>, Coloring<Instance>&,
                             const SurfaceStars&);
template void build_rings(const Instance&, WorkMesh<Instance>&, Rings<Instance>&);
template void build_rings_of(const Instance&, WorkMesh<Instance>&, Span<const Index>, Span<const std::uint8_t>,
                             Rings<Instance>&);
template SweepSum sweep(const Instance&, WorkMesh<Instance>&, const RingsView&, const Coloring<Instance>&,
                        Mobilities<Instance>&, const NewtonStep&);
template SweepSum sweep(const Instance&, WorkMesh<Instance>&, const RingsView&, const Coloring<Instance>&,
                        Mobilities<Instance>&, const GradientStep&);
template SweepSum soft_sweep(const Instance&, WorkMesh<Instance>&, const RingsView&, const Coloring<Instance>&,
                             Mobilities<Instance>&, const NewtonStep&);
}  // namespace tetune
