// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "curved/relaxation.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

class CurvedSlide;

/// The vertices and edges of the boundary, of interfaces, of listed entities and of what the options freeze.
HeldNodes find_held(const TetMesh& mesh, const Options& options);

/// The listed tetrahedra that have a flat, folded face on the surface: its own Jacobian determinant is not positive at
/// a corner. That of the element is then 0 somewhere on the face, wherever the inner nodes are.
std::vector<Index> with_folded_face(const TetMesh& mesh, const std::vector<Index>& tets);

/// The elements that are not valid, except those with a folded face.
std::vector<Index> find_unfolded(const TetMesh& mesh, int threads);

/// The tetrahedra whose straight volume is not certified positive, or with a smaller dihedral angle, in degrees.
std::vector<Index> flatter_than(const TetMesh& mesh, double dihedral, int threads);

/// Inserts the tetrahedra within `rings` around the marked vertices into the sorted list `locked`. If that adds none,
/// further rings follow until one does.
void lock_around(const TetMesh& mesh, std::vector<std::uint8_t> is_marked, int rings, std::vector<Index>& locked);

/// The straight tetrahedra of a curved mesh, constrained for their optimization: triangles of the surface with a curved
/// edge are required, unless they slide, as are listed edges that are curved, and the tetrahedra that are locked.
class CurvedSkeleton {
 public:
  /// `whole` is a valid mesh with curved edges. It must outlive the skeleton, as must `slide`, which is null where the
  /// surface stays.
  CurvedSkeleton(const TetMesh& whole, const HeldNodes& held, const std::vector<Index>& locked_tets,
                 const CurvedSlide* slide = nullptr);

  /// The mesh to optimize.
  TetMesh mesh;
  /// Gives the optimized `mesh` its curved edges again, and takes the additional constraints away. Curved edges
  /// are those of the surface, unless an end has moved, and of locked tetrahedra; other inner ones are straight.
  /// `report` is that of the optimization.
  void restore(Report& report);

 private:
  void require_triangles();
  void keep_edges(const HeldNodes& held, const std::vector<Index>& locked_tets);
  void restore_triangles(Report& report);
  void restore_edges(Report& report);
  void restore_lists(const Report& report);
  void restore_curved_edges(const Report& report);

  const TetMesh& whole_;
  const CurvedSlide* slide_;
  std::vector<CurvedEdge> kept_;  ///< curved edges that stay edges
  /// Curved edges of the surface that slides, or straight up to rounding: they are kept where both ends stay.
  std::vector<CurvedEdge> kept_unmoved_;
};

}  // namespace tetune
