// SPDX-License-Identifier: Apache-2.0
#include "energy/ring.hpp"
#include "par/cuda.cuh"

namespace tetune {
using Instance = par::Cuda;
using InstanceRing = PlainRing;
}  // namespace tetune

#include "relocate/instantiate.inl"
