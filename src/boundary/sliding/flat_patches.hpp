// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "boundary/sliding/reference_surface.hpp"

namespace tetune {

/// The patches of the reference surface that lie in a plane; a patch is what feature edges bound. Motion and flips in a
/// plane leave such a patch the same set of points while its outline stays, so that a bound on the deviation needs no
/// test there (docs/method.md, "The bound on the deviation").
class FlatPatches {
 public:
  FlatPatches() = default;
  /// A patch is flat if all its vertices are within `tolerance` of a plane, and it does not fold back.
  FlatPatches(const ReferenceSurfaceOnHost& reference, double tolerance);

  /// Whether a triangle of the reference surface is in a flat patch.
  bool contains(Index triangle) const { return patch_of(triangle) >= 0; }
  /// Lets the vertices inside flat patches move in their plane, and those between two of them along the line in which
  /// the planes meet, instead of on the reference surface. `dof` and `axis` have an entry per vertex of the reference.
  void restrict_vertices(const ReferenceSurfaceOnHost& reference, std::vector<VertexDof>& dof,
                         std::vector<Vec3>& axis) const;

 private:
  /// The flat patch of a triangle, or -1.
  Index patch_of(Index triangle) const { return span_of(triangle2patch_)[triangle]; }
  /// The plane of a vertex inside a flat patch, or the line of one between flat patches, of those that slide over the
  /// surface or along a curve (`dof`); VertexDof::fixed where there is none.
  MotionSpace space_of(const ReferenceSurfaceOnHost& reference, Index v, VertexDof dof) const;
  MotionSpace line_of(const ReferenceSurfaceOnHost& reference, Index v, const std::vector<Index>& patches) const;

  double tolerance_ = 0;
  std::vector<Index> triangle2patch_;
  std::vector<Vec3> normals_;  ///< unit normals, per flat patch
};

}  // namespace tetune
