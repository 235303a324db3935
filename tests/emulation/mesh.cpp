// SPDX-License-Identifier: Apache-2.0
#include "emulation/emulation.hpp"

namespace tetune {
using Instance = backend::Emulation;
}

#include "mesh/instantiate.inl"
