// SPDX-License-Identifier: Apache-2.0
#include "driver/alternate.inl"
#include "emulation/emulation.hpp"

namespace tetune {
template Report optimize_on(const par::Emulation&, TetMesh&, const Options&, const Context&, SlideSurface*);
}  // namespace tetune
