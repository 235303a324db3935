// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "communicate.hpp"
#include "part.hpp"
#include "tetune/quality.hpp"

namespace tetune::mpi {

/// The quality of the mesh of all parts, without percentiles and worst_tet, which do not follow from those of the
/// parts.
Quality quality_of_all(MPI_Comm comm, const TetMesh& part, int threads);

/// The tetrahedra with a vertex that was on an interface in the first round.
TetMesh at_first_cut(const Part& part);

/// Reverses the tetrahedra of a mesh that lists all of them inside out; returns whether it did.
bool orient_all(MPI_Comm comm, Part& part);

}  // namespace tetune::mpi
