// SPDX-License-Identifier: Apache-2.0
#include "driver/optimize_on.inl"
#include "emulation/emulation.hpp"

namespace tetune {
template Report optimize_on(const backend::Emulation&, TetMesh&, const Options&, const Context&, SlideSurface*,
                            MoveJob*);
}  // namespace tetune
