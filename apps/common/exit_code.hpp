// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tetune::cli {

/// Exit codes, the same as Mmg's.
enum ExitCode : int {
  kDone = 0,            ///< success
  kStoppedEarly = 1,    ///< the run was stopped early, a target was missed, a criterion failed, or the report, trace or
                        ///< map could not be written, and a valid mesh was written. `info` and `compare`: the mesh is
                        ///< not valid, or not of the required quality
  kNothingWritten = 2,  ///< for at least one of several meshes
};

}  // namespace tetune::cli
