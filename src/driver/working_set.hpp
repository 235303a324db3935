// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/classify.hpp"
#include "boundary/features.hpp"
#include "core/connect.hpp"
#include "flips/boundary_flips.hpp"
#include "flips/flip_pass.hpp"
#include "relocate/coloring.hpp"
#include "relocate/sweep.hpp"
#include "surface/slide_surface.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// All that one optimisation has in a backend's memory.
template <class Backend>
struct WorkingSet {
  WorkMesh<Backend> mesh;
  FlipState<Backend> flips;
  /// Empty where no boundary edge may be flipped.
  BoundaryTriangles<Backend> boundary;
  Mobilities<Backend> mobilities;
  Rings<Backend> rings;
  Coloring<Backend> coloring;
  /// With Options::untangle: how many volumes are not positive.
  Size tangled = 0;
  /// Coordinates inside are the caller's times this power of two: see unit_scale().
  double scale = 1;
  /// kMovable, kFrozen or kCorner for each work vertex.
  std::vector<std::uint8_t> frozen;
  /// Work slot of each of the caller's required tetrahedra.
  std::vector<Index> required_slots;
  /// For each of the caller's triangles.
  std::vector<Listed> listed_triangles;
};

/// Takes a mesh in: checks it, renumbers it, finds its surface and what each vertex may do.
/// `slides_on`: the surface for Boundary::slide, null for the mesh's own. Throws MeshError.
template <class Backend>
void load(const Backend& par, const TetMesh& mesh, const Options& options, const SlideSurface* slides_on,
          WorkingSet<Backend>& work, Report& report);

/// Gives the result back to the caller's mesh, under the caller's vertex ids, and tells the surface where the vertices
/// are on it.
template <class Backend>
void store(const Backend& par, WorkingSet<Backend>& work, const Options& options, TetMesh& mesh,
           SlideSurface* slides_on, Report& report);

}  // namespace tetune
