// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "boundary/boundary_triangles.hpp"
#include "boundary/vertex_dofs.hpp"
#include "operators/engine/flip_state.hpp"
#include "relocation/coloring.hpp"
#include "relocation/movable_vertices.hpp"
#include "relocation/periodic_set.hpp"
#include "relocation/rings.hpp"

namespace tetune {

/// The data of one optimization in a backend's memory.
template <class Backend>
struct WorkingSet {
  WorkMesh<Backend> mesh;
  FlipState<Backend> flips;
  /// Empty where no boundary edge may be flipped.
  BoundaryTriangles<Backend> boundary;
  VertexDofs<Backend> dofs;
  Rings<Backend> rings;
  Coloring<Backend> coloring;
  /// The linked vertices that move together; empty where none does.
  PeriodicSet<Backend> periodic;
  /// The number of tetrahedra whose volume is not positive; above 0 with Options::untangle only.
  Size tangled = 0;
  bool is_neighborhood = false;  ///< of a larger mesh
  Size outside = 0;              ///< the number of tetrahedra of that mesh outside it
  /// The number of vertices that may be removed beyond those inserted; at first more than any mesh has.
  Size removable = std::numeric_limits<Index>::max();
  /// The power of two by which the caller's coordinates are multiplied: see unit_scale().
  double scale = 1;
  std::vector<VertexConstraint> vertex_constraints;
  /// The slot of each of the caller's required tetrahedra.
  std::vector<Index> required_slots;
  /// One entry for each of the caller's triangles.
  std::vector<Listed> listed_triangles;
  /// The entries of the caller's list that are on the boundary at the start, if vertices are inserted and removed
  /// there.
  std::vector<Index> listed_boundary;

  MovableVertices<Backend> movable_vertices() { return {rings.view(), coloring, dofs}; }
  MovableClasses<Backend> movable_classes() { return {rings.view(), periodic, dofs}; }
};

}  // namespace tetune
