// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/move.hpp"
#include "tetune/options.hpp"

namespace tetune {

/// The number of vertices that the options freeze although a target moves them; `moves`: 1 per vertex that moves.
std::int64_t count_frozen_moved(const TetMesh& mesh, const Options& options, const std::vector<std::uint8_t>& moves);

/// The warning about frozen vertices that move.
std::string frozen_text(std::int64_t frozen_moved);

/// The warnings of a motion of the whole mesh. The constructor, which is called before the mesh changes, allocates the
/// memory of all of them.
class MoveWarnings {
 public:
  /// `moves`: 1 per vertex that a target moves.
  MoveWarnings(const TetMesh& mesh, const Options& options, const std::vector<std::uint8_t>& moves);
  /// Sets MoveReport::frozen_moved and inverted_others, and appends to Report::warnings.
  void add_to(const TetMesh& result, MoveReport& report);

 private:
  std::int64_t frozen_moved_;
  std::string frozen_text_;
  std::vector<InvertedOthers> others_;           ///< elements with a vertex that moves and one sign at all corners
  std::vector<std::vector<std::int8_t>> signs_;  ///< of these
  std::vector<std::string> texts_;               ///< per block of these: empty, with room for a warning
};

}  // namespace tetune
