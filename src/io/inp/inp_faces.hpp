// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "io/inp/inp_format.hpp"
#include "io/inp/inp_match.hpp"

namespace tetune {

/// A face by the number of its element, and 1 to 4 as Abaqus counts.
struct InpLabeledFace {
  std::int64_t element;
  int face;
  auto operator<=>(const InpLabeledFace&) const = default;
};

/// The faces of each face group of a deck in a mesh, ascending. Throws FileError where some are lost.
std::vector<std::vector<InpLabeledFace>> find_inp_faces(const InpModel& model, const TetMesh& mesh,
                                                        const InpMatch& match);

}  // namespace tetune
