// SPDX-License-Identifier: Apache-2.0
#include "energy/ring_simd.hpp"
#include "energy/soft_ring.hpp"
#include "par/cpu.hpp"
#include "relocate/coloring.inl"
#include "relocate/sweep.inl"

namespace tetune {

template <class Backend, class Step>
SweepSum sweep(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings, const Coloring<Backend>& coloring,
               Mobilities<Backend>& mobilities, const Step& step) {
  return sweep_with<SimdRing>(par, mesh, rings, coloring, mobilities, step);
}

template <class Backend, class Step>
SweepSum soft_sweep(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings,
                    const Coloring<Backend>& coloring, Mobilities<Backend>& mobilities, const Step& step) {
  return sweep_with<SoftRing>(par, mesh, rings, coloring, mobilities, step);
}

template void color_vertices(const par::Cpu&, const RingsView&, Span<const Mobility>, Coloring<par::Cpu>&);
template void build_rings(const par::Cpu&, WorkMesh<par::Cpu>&, Rings<par::Cpu>&);
template void build_rings_of(const par::Cpu&, WorkMesh<par::Cpu>&, Span<const Index>, Span<const std::uint8_t>,
                             Rings<par::Cpu>&);
template SweepSum sweep(const par::Cpu&, WorkMesh<par::Cpu>&, const RingsView&, const Coloring<par::Cpu>&,
                        Mobilities<par::Cpu>&, const NewtonStep&);
template SweepSum sweep(const par::Cpu&, WorkMesh<par::Cpu>&, const RingsView&, const Coloring<par::Cpu>&,
                        Mobilities<par::Cpu>&, const GradientStep&);
template SweepSum soft_sweep(const par::Cpu&, WorkMesh<par::Cpu>&, const RingsView&, const Coloring<par::Cpu>&,
                             Mobilities<par::Cpu>&, const NewtonStep&);

}  // namespace tetune
