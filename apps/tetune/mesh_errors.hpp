// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tetune/tetune.hpp"

/// Errors of a mesh in the words of the command line: ids start from 1 as in MEDIT files, and options are flags.
namespace tetune::cli {

/// The tetrahedra that --untangle left, and the position of the first.
std::string untangle_message(const UntangleError& error, const TetMesh& mesh);

/// An error of optimize() and the like. Where validate() finds defects, these.
std::string mesh_message(const MeshError& error, const TetMesh& mesh, int threads);

/// The defects of a mesh. If it is curved, --untangle helps its straight tetrahedra only.
std::string validity_message(const ValidationReport& report, bool is_curved);

}  // namespace tetune::cli
