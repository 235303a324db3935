// SPDX-License-Identifier: Apache-2.0
#include "energy/soft_ring.hpp"
#include "par/cuda.cuh"
#include "relocate/coloring.inl"
#include "relocate/sweep.inl"

namespace tetune {

template <class Backend, class Step>
SweepSum sweep(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings, const Coloring<Backend>& coloring,
               Mobilities<Backend>& mobilities, const Step& step) {
  return sweep_with<PlainRing>(par, mesh, rings, coloring, mobilities, step);
}

template <class Backend, class Step>
SweepSum soft_sweep(const Backend& par, WorkMesh<Backend>& mesh, const RingsView& rings,
                    const Coloring<Backend>& coloring, Mobilities<Backend>& mobilities, const Step& step) {
  return sweep_with<SoftRing>(par, mesh, rings, coloring, mobilities, step);
}

template void color_vertices(const par::Cuda&, const RingsView&, Span<const Mobility>, Coloring<par::Cuda>&);
template void build_rings(const par::Cuda&, WorkMesh<par::Cuda>&, Rings<par::Cuda>&);
template void build_rings_of(const par::Cuda&, WorkMesh<par::Cuda>&, Span<const Index>, Span<const std::uint8_t>,
                             Rings<par::Cuda>&);
template SweepSum sweep(const par::Cuda&, WorkMesh<par::Cuda>&, const RingsView&, const Coloring<par::Cuda>&,
                        Mobilities<par::Cuda>&, const NewtonStep&);
template SweepSum sweep(const par::Cuda&, WorkMesh<par::Cuda>&, const RingsView&, const Coloring<par::Cuda>&,
                        Mobilities<par::Cuda>&, const GradientStep&);
template SweepSum soft_sweep(const par::Cuda&, WorkMesh<par::Cuda>&, const RingsView&, const Coloring<par::Cuda>&,
                             Mobilities<par::Cuda>&, const NewtonStep&);

}  // namespace tetune
