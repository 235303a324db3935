// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "curved/relaxation.hpp"

namespace tetune {

/// The elements and vertices that those of a mesh with inserted ones descend from.
struct Origins {
  std::vector<Index> tets;      ///< per tetrahedron
  std::vector<Index> vertices;  ///< per vertex; -1 for an inserted one
};

/// Returns the identity.
Origins own_origins(const TetMesh& mesh);

/// Splits the longest edge that is not held of each listed tetrahedron at its midpoint, with all tetrahedra around
/// it, unless one of these is split already, in the order of the list. Where the surface alone makes a determinant
/// negative, because an element has two faces on it, the new vertex gives each part a face of its own: relax_curved()
/// moves it inward. An edge stays whose split would make more than `max_tets` tetrahedra. New vertices and tetrahedra
/// are behind all others; tags, data of tetrahedra and `origins` follow, data of vertices do not. Returns the
/// tetrahedra around new vertices.
std::vector<Index> split_edges(TetMesh& mesh, const HeldNodes& held, const std::vector<Index>& tets, double max_tets,
                               Origins& origins);

}  // namespace tetune
