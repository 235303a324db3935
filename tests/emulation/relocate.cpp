// SPDX-License-Identifier: Apache-2.0
#include "emulation/emulation.hpp"
#include "energy/ring.hpp"

namespace tetune {
using Instance = par::Emulation;
using InstanceRing = PlainRing;
}  // namespace tetune

#include "relocate/instantiate.inl"
