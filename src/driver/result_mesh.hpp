// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "boundary/boundary_triangles.hpp"
#include "mesh/work_mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// How the vertices of a work mesh are numbered in the result. Extended ids are those of the caller's vertices,
/// followed by those of the inserted vertices.
struct VertexNumbering {
  std::vector<Index> work2extended;  ///< or kRemoved
  std::vector<Index> extended2new;   ///< -1 for removed vertices
  std::vector<Index> new2original;   ///< -1 for inserted vertices; empty if the caller's vertices were all kept
  bool has_removed = false;

  /// The id of each work vertex in the result, or kRemoved.
  std::vector<Index> work2new() const;
};

/// `vertex2original` as of WorkMesh; `originals` is the number of the caller's vertices.
VertexNumbering number_vertices(std::vector<Index> vertex2original, std::size_t originals);

/// The optimized mesh on the host, and the parts of WorkingSet that relate it to the caller's.
struct HostResult {
  VertexNumbering numbering;
  std::vector<Point> points;               ///< per work vertex
  std::vector<std::array<Index, 4>> tets;  ///< in extended ids
  std::vector<Index> tet2original;
  std::vector<Index> slot_of_tet;  ///< before compaction; increasing
  std::vector<BoundaryTriangle> boundary;
  std::vector<Index> listed_boundary;  ///< the entries of the caller's list that were on the boundary before
  std::vector<Index> required_slots;
  std::vector<Listed> listed_triangles;
  double scale = 1;
  bool is_manifold = true;
};

/// How the caller's mesh becomes the result.
struct ExportRules {
  const Options& options;
  bool is_moved = false;  ///< the vertices followed targets
  /// All threads call it. A conservative transfer that it ends leaves a warning and interpolated data.
  std::function<bool()> stop_transfer;
};

/// Returns the tags of tetrahedra by the caller's tetrahedra that they descend from.
std::vector<int> regions_of(const std::vector<Index>& tet2original, const TetMesh& mesh);

/// Replaces the caller's mesh by the result, and reports which of its entities were kept. When it throws, the mesh is
/// as before. Throws OverlapError where flips have made faces of three or more tetrahedra, and MeshError for incomplete
/// data arrays.
void replace_mesh(TetMesh& mesh, HostResult result, const ExportRules& rules, Report& report);

}  // namespace tetune
