// SPDX-License-Identifier: Apache-2.0
#include "energy/ring_simd.hpp"
#include "par/cpu.hpp"

namespace tetune {
using Instance = par::Cpu;
using InstanceRing = SimdRing;
}  // namespace tetune

#include "relocate/instantiate.inl"
