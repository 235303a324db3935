// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// Element quality of a whole mesh. Angles in degrees.
struct Quality {
  std::int64_t tets = 0;
  /// Over all six dihedral angles of all tetrahedra; percentiles to 0.005 degrees, extremes exact.
  double dihedral_min = 0, dihedral_1 = 0, dihedral_5 = 0, dihedral_mean = 0, dihedral_max = 0;
  /// Tetrahedron with the smallest dihedral angle (the first, where several share it).
  Index worst_tet = -1;
  /// Harmonic index eta = (sum of squared face areas) / volume; Stroeter et al. 2022, Eq. 5. Unit: length.
  double eta_max = 0, eta_95 = 0, eta_sum = 0;
  /// Sum of the shape energy (eta / eta_r)^(3/2), where eta_r is that of the regular tetrahedron of the same volume:
  /// the number of tetrahedra if all were regular.
  double shape_sum = 0;
  /// Mean ratio 12 (3 V)^(2/3) / sum of squared edge lengths: 1 for a regular tetrahedron, 0 for a flat one.
  double mean_ratio = 0, mean_ratio_min = 0;
  double volume = 0;
  /// Share of dihedral angles in each of 18 bins of 10 degrees.
  std::array<double, 18> histogram{};
};

/// Measures a mesh of positive volumes. The result is the same for any number of threads.
/// `threads` 0 means all. Returns zeros for a mesh without tetrahedra. Throws MeshError when an index is out of range,
/// an array of the wrong length or a coordinate not finite.
Quality quality(const TetMesh& mesh, int threads = 0);

/// What became of the listed triangles of one tag.
struct PatchChange {
  int tag = 0;
  double area_before = 0;
  double area_change = 0;  ///< relative
};

/// How far one mesh lies from another of the same shape.
struct Comparison {
  /// Relative changes, new against old.
  double volume_change = 0, area_change = 0;
  /// Distances between the old and the new surface, boundary and interfaces between regions, divided by the old
  /// boundary's mean edge length: the largest from a vertex of the new one to the old one, and the largest from any of
  /// vertices, edge middles and triangle centres of one to the other.
  double vertices_to_old = 0, new_to_old = 0, old_to_new = 0;
  std::int64_t old_vertices = 0, new_vertices = 0, old_tets = 0, new_tets = 0;
  /// The set of tags (and for regions, patches and lines each one's presence) is the same.
  bool vertex_tags_kept = false, tet_tags_kept = false, triangle_tags_kept = false, edge_tags_kept = false;
  /// Largest relative change of a region's volume, and of a tagged patch's area.
  double region_volume_change = 0, patch_area_change = 0;
  /// Each tag of listed triangles but 0, in increasing order.
  std::vector<PatchChange> patches;
  /// Vertices listed as required, and as corners, that are not where they were to the last bit.
  std::int64_t required_moved = 0, corners_moved = 0;
};

/// Compares two meshes. `threads` 0 means all. Throws MeshError as quality() does.
Comparison compare(const TetMesh& before, const TetMesh& after, int threads = 0);

}  // namespace tetune
