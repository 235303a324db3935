// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "input_surface.hpp"
#include "part.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune::mpi {

/// The options for a part, which may lack tags that the whole mesh has.
Options options_for(const Options& options, const TetMesh& mesh);

/// The form of messages about a mesh: for callers of the library, or users of a program.
struct MessageForm {
  bool one_based = false;                            ///< ids start from 1
  const char* advice = ValidationReport::kUntangle;  ///< as of ValidationReport::message()
};

/// The message of validate() about a part, in the ids of the whole mesh; that of `error` where the part is valid. Ids
/// beyond 32 bits are left out.
std::string defects_of(const Part& part, int threads, const MessageForm& form, const MeshError& error);

/// The message about the parts of all ranks, on all of them, where their only defects are inverted or flat tetrahedra;
/// else that of `error`. Collective.
std::string defects_of_all(MPI_Comm comm, const Part& part, int threads, const MessageForm& form,
                           const MeshError& error);

/// Optimizes one part, of which the vertices with `frozen` 1 stay: on `surface`, if it is given, for Boundary::slide.
/// Inserted vertices get the id -1. Throws as optimize() does, in the ids of the whole mesh, as defects_of().
Report optimize_part(Part& part, Marks frozen, const Options& options, const Context& context, InputSurface* surface,
                     const MessageForm& form = {});

}  // namespace tetune::mpi
