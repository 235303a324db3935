// SPDX-License-Identifier: Apache-2.0
#include "driver/alternate.inl"
#include "par/cpu.hpp"

namespace tetune {
template Report optimize_on(const par::Cpu&, TetMesh&, const Options&, const Context&);
}  // namespace tetune
