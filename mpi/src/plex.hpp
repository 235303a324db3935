// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <petscdmplex.h>

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "distribute.hpp"

namespace tetune::mpi {

/// The labels of a DMPlex. An entity with values of several labels has one tag, which stands for all of them.
struct Labels {
  /// Position in `names`, and value.
  using Values = std::vector<std::pair<int, int>>;
  std::vector<std::string> names;
  std::vector<int> completed;  ///< per label: 1 where it holds the closure of its points
  std::vector<int> defaults;   ///< per label: DMLabelGetDefaultValue()
  /// For vertices, edges, faces and cells: the values that each tag stands for.
  std::array<std::map<int, Values>, 4> tag2values;
  bool interpolated = true;
};

/// The labels that hold the tags of files.
inline constexpr std::array<const char*, 4> kSets{"Vertex Sets", "Edge Sets", "Face Sets", "Cell Sets"};

/// Labels for the tags of a mesh from a file.
Labels labels_of(MPI_Comm comm, const Part& part);

/// The part of a DMPlex that a rank has. Throws MeshError, on all ranks, where it does not consist of tetrahedra in
/// space.
Part part_of(DM dm, Totals& totals, Labels& labels);

/// Makes a DMPlex of parts.
DM plex_of(MPI_Comm comm, Part part, Totals& totals, const Labels& labels);

}  // namespace tetune::mpi
