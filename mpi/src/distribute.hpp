// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "communicate.hpp"
#include "part.hpp"
#include "star.hpp"

namespace tetune::mpi {

/// Numbers of a whole mesh: every id is below its.
struct Totals {
  Id vertices = 0, cells = 0, sides = 0, lines = 0;
};

/// Gives each rank one part of a mesh whose pieces are anywhere, each on one rank. The cuts are planes of recursive
/// bisection: the tetrahedra of a part lie together, and are as many as those of any other.
/// Throws MeshError, on all ranks, when an element names a vertex that is not there, a coordinate is not finite, or
/// listed triangles or edges that constrain are none of the mesh.
Part distribute(MPI_Comm comm, Pieces pieces, const Totals& totals);

/// The mesh that the parts make together: vertices, sides and lines at home, each once, cells where their part is, all
/// numbered without gaps in the order of their ids. `totals` becomes their numbers.
Pieces collect(MPI_Comm comm, Part part, Totals& totals);

/// Numbers the vertices without gaps, in the order of their ids.
void close_gaps(MPI_Comm comm, Part& part, Totals& totals);

/// Each vertex once, at home.
std::vector<Vertex> vertices_at_home(MPI_Comm comm, const std::vector<Vertex>& vertices, const Totals& totals);

/// Sends pieces to their ranks.
Pieces send(MPI_Comm comm, Addressed addressed);

/// The tetrahedra around the held_vertices() of a part, those of other parts too: enough to tell what is held, and how.
/// kShared says which vertices other parts have.
Part shell_of(MPI_Comm comm, const Part& part, const Totals& totals, const std::vector<int>& frozen_regions);

/// The vertices that several parts have: among those of kShared, which is all at first.
class Shared {
 public:
  Shared(MPI_Comm comm, const Part& part, const Totals& totals);
  /// Leaves kShared to those that several parts have.
  void mark(Part& part) const;
  /// Replaces the value of each by the smallest of those that the parts have for it.
  void least(std::vector<int>& values) const;

 private:
  std::vector<std::size_t> vertices_;
  Star star_;
};

}  // namespace tetune::mpi
