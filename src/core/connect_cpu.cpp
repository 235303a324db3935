// SPDX-License-Identifier: Apache-2.0
#include "par/cpu.hpp"

namespace tetune {
using Instance = par::Cpu;
}

#include "core/instantiate.inl"
