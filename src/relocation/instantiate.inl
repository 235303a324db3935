// SPDX-License-Identifier: Apache-2.0
// Included once per backend, by a file that defines Instance.
#include "relocation/sweep.inl"

namespace tetune {

template ResultOf<Instance, SweepSum> sweep<SweepRing<Instance>>(const Instance&, WorkMesh<Instance>&, const Criterion&,
                                                                 const MovableVertices<Instance>&, const NewtonStep&,
                                                                 SweepScope);
template ResultOf<Instance, SweepSum> sweep<SweepRing<Instance>>(const Instance&, WorkMesh<Instance>&, const Criterion&,
                                                                 const MovableVertices<Instance>&, const GradientStep&,
                                                                 SweepScope);
template ResultOf<Instance, SweepSum> sweep<RegularizedRing>(const Instance&, WorkMesh<Instance>&, const Criterion&,
                                                             const MovableVertices<Instance>&, const NewtonStep&,
                                                             SweepScope);
}  // namespace tetune
