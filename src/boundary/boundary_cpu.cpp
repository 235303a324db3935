// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

namespace tetune {
using Instance = backend::Cpu;
}

#include "boundary/instantiate.inl"
