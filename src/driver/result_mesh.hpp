// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "boundary/boundary_triangles.hpp"
#include "driver/vertex_numbering.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// The optimized mesh on the host.
struct HostResult {
  std::optional<VertexNumbering> numbering;
  std::vector<Point> points;               ///< per work vertex
  std::vector<std::array<Index, 4>> tets;  ///< in extended ids
  std::vector<Index> tet2original;
  std::vector<Index> slot_of_tet;  ///< before compaction; increasing
  std::vector<BoundaryTriangle> boundary;
  std::vector<Index> listed_boundary;  ///< the entries of the caller's list that were on the boundary before
  bool has_duplicate_faces = false;    ///< possibly: must be checked
};

/// Returns the tags of the tetrahedra that these of the caller's have become.
std::vector<int> regions_of(const std::vector<Index>& tet2original, const TetMesh& mesh);

/// Replaces the caller's mesh by the result, and reports which of its entities were kept. `required_slots` and
/// `listed_triangles`: as of WorkingSet. When it throws, the mesh is as before. Throws OverlapError where flips have
/// made faces of three or more tetrahedra, and MeshError for incomplete data arrays.
void replace_mesh(TetMesh& mesh, HostResult result, const std::vector<Index>& required_slots,
                  const std::vector<Listed>& listed_triangles, double scale, int threads, Report& report);

}  // namespace tetune
