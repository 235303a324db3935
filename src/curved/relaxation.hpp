// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "math/vec3.hpp"
#include "tetune/mesh.hpp"

/// Makes curved elements valid, or better, by moving inner vertices and inner mid-side nodes around them.
namespace tetune {

/// Nodes that keep the bits of their positions.
struct HeldNodes {
  std::vector<std::uint8_t> vertices;       ///< 1 per held vertex
  std::vector<std::array<Index, 2>> edges;  ///< with held mid-side nodes; sorted
  bool has_edge(Index a, Index b) const;
};

/// The smallest dihedral angle of a straight tetrahedron, in degrees; negative for an inverted one.
double min_dihedral(const std::array<Vec3, 4>& corners);

/// The goals of relaxation.
struct RelaxationGoal {
  /// The smallest dihedral angle, in degrees, that a straight element may get; or less where it has less.
  double min_dihedral = 0;
  bool moves_vertices = true;  ///< if false, only mid-side nodes move
  bool only_valid = false;     ///< the work on a patch ends once all of its elements are proved valid
  int threads = 0;
  std::function<bool()> stop{};  ///< if set and true, ends the relaxation early; called by all threads
};

/// Relaxes patches: connected groups of the listed tetrahedra and two rings around them. A new state of a patch is
/// accepted if its number of elements that are not proved valid falls, or is 0 and its smallest scaled Jacobian rises.
/// Entries of `curved_edges` are added where inner edges become curved. Deterministic: the result does not depend on
/// the number of threads.
void relax_curved(TetMesh& mesh, const HeldNodes& held, const std::vector<Index>& tets, const RelaxationGoal& goal);

}  // namespace tetune
