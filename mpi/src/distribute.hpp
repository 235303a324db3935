// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "communicate.hpp"
#include "part.hpp"

namespace tetune::mpi {

/// The numbers of entities of a whole mesh; ids are below them.
struct Totals {
  Id vertices = 0, cells = 0, sides = 0, lines = 0;
};

/// Gives each rank one part of a mesh whose entities are on any ranks, each on one. Recursive bisection by planes makes
/// parts of contiguous tetrahedra and of equal size. Throws MeshError, on all ranks, when an element has a vertex that
/// does not exist, a coordinate is not finite, or constraining listed triangles or edges belong to no tetrahedron.
Part distribute(MPI_Comm comm, Pieces pieces, const Totals& totals);

/// Returns the entities of all parts: vertices, sides and lines once, on their owner ranks, cells on the ranks of their
/// parts, all numbered without gaps in the order of their ids. Updates `totals`, and the vertices of `others`, which a
/// part must have.
Pieces collect(MPI_Comm comm, Part part, Totals& totals, std::vector<ElementBlock>& others);

/// Numbers the vertices without gaps, in the order of their ids. Returns the new id of each vertex of this rank's block
/// of the old ones, or -1 where no part has it.
std::vector<Id> close_gaps(MPI_Comm comm, Part& part, Totals& totals);

/// Sends vertices to their owner ranks, each once.
std::vector<Vertex> vertices_at_owner(MPI_Comm comm, const std::vector<Vertex>& vertices, const Totals& totals);

/// Sends the entities to their ranks.
Pieces send(MPI_Comm comm, Addressed addressed);

}  // namespace tetune::mpi
