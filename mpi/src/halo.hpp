// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "distribute.hpp"
#include "star_forest.hpp"

namespace tetune::mpi {

/// The tetrahedra with held_vertices() of a part, including those of other parts: all that decides how these vertices
/// are constrained. kShared marks the vertices that other parts have.
Part halo_of(MPI_Comm comm, const Part& part, const Totals& totals, const std::vector<int>& frozen_regions);

/// The vertices that several parts have: a subset of those with kShared, which all have at first.
class Shared {
 public:
  Shared(MPI_Comm comm, const Part& part, const Totals& totals);
  /// Clears kShared of vertices that only one part has.
  void mark(Part& part) const;
  /// Replaces the value of each by the minimum over the parts.
  void minimize(std::vector<int>& values) const;

 private:
  std::vector<std::size_t> vertices_;
  StarForest star_;
};

}  // namespace tetune::mpi
