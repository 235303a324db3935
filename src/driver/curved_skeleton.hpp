// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "curved/relaxation.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// The vertices and edges of the boundary, of interfaces, of listed entities and of what the options freeze.
HeldNodes find_held(const TetMesh& mesh, const Options& options);

/// Those of the listed tetrahedra that have a flat, folded face on the surface: its own Jacobian determinant is not
/// positive at a corner. That of the element is then 0 somewhere on the face, wherever the inner nodes are.
std::vector<Index> with_folded_face(const TetMesh& mesh, const std::vector<Index>& tets);

/// The straight tetrahedra of a curved mesh, constrained for their optimization: triangles of the surface with a curved
/// edge are required, as are listed edges that are curved, and the tetrahedra that are locked.
class CurvedSkeleton {
 public:
  /// `whole` is a valid mesh with curved edges; it is referred to.
  CurvedSkeleton(const TetMesh& whole, const HeldNodes& held, const std::vector<Index>& locked_tets);

  /// The mesh to optimize.
  TetMesh mesh;
  /// Makes the optimized `mesh` one with curved edges again, and takes the additional constraints away. Curved edges
  /// are those of the surface and of locked tetrahedra; other inner ones are straight. `report` is that of the
  /// optimization.
  void restore(Report& report);

 private:
  void require_triangles();
  void keep_edges(const std::vector<Index>& locked_tets);
  void restore_triangles(Report& report);
  void restore_lists(const Report& report);
  void restore_curved_edges(const Report& report);

  const TetMesh& whole_;
  const HeldNodes& held_;
  std::vector<CurvedEdge> kept_;     ///< curved edges that stay edges
  std::vector<CurvedEdge> rounded_;  ///< of the surface, straight up to rounding: kept where both ends stay
};

}  // namespace tetune
