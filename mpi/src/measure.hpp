// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "communicate.hpp"
#include "part.hpp"
#include "tetune/quality.hpp"

namespace tetune::mpi {

/// Quality of the mesh that the parts make; without what cannot be put together from parts: percentiles, worst_tet.
Quality quality_of_all(MPI_Comm comm, const TetMesh& part, int threads);

/// The tetrahedra with a vertex that was on a cut in the first round.
TetMesh at_first_cut(const Part& part);

/// Turns the tetrahedra of a mesh that lists all of them inside out. Returns whether it did.
bool orient_all(MPI_Comm comm, Part& part);

}  // namespace tetune::mpi
