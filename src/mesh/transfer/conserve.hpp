// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "backend/cpu.hpp"
#include "tetune/data.hpp"

namespace tetune {

/// conserve_data(), but nothing once cpu.stop_requested(), which all threads call.
std::optional<ConservedData> conserve_data_until_stopped(const backend::Cpu& cpu, const TetMesh& input,
                                                         const std::vector<std::array<Index, 4>>& tets,
                                                         const std::vector<Index>& tet2original,
                                                         const std::vector<MeshPlace>& places);

}  // namespace tetune
