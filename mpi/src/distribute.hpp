// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "communicate.hpp"
#include "part.hpp"

namespace tetune::mpi {

/// Numbers of a whole mesh: every id is below its.
struct Totals {
  Id vertices = 0, cells = 0, sides = 0, lines = 0;
};

/// Cuts a list into one block of ids a rank, its *home*: where all copies of an entity are asked for.
class Blocks {
 public:
  Blocks(Id count, int ranks) : count_(count), each_(std::max<Id>(1, (count + ranks - 1) / ranks)) {}
  int home(Id id) const { return static_cast<int>(id / each_); }
  Id begin(int rank) const { return std::min(count_, rank * each_); }

 private:
  Id count_, each_;
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

/// A value for each vertex, the same in all parts that have it.
class Shared {
 public:
  Shared(MPI_Comm comm, const Part& part);
  /// Replaces each value by the smallest of those that the parts have for the vertex.
  void least(std::vector<int>& values) const;
  /// Whether several parts have the vertex.
  const std::vector<std::uint8_t>& shared() const { return shared_; }

 private:
  Route route_;
  std::vector<std::size_t> slot_;  ///< of each that arrived, among the different ones
  std::size_t slots_ = 0;
  std::vector<std::uint8_t> shared_;
};

}  // namespace tetune::mpi
