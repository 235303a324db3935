// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "mesh/work_mesh.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// How the vertices of a work mesh are numbered in the result. Extended ids are those of the caller's vertices,
/// followed by those of the inserted vertices.
class VertexNumbering {
 public:
  /// `vertex2original` as of WorkMesh; `originals` is the number of the caller's vertices.
  VertexNumbering(std::vector<Index> vertex2original, std::size_t originals);

  std::size_t originals() const { return originals_; }
  std::size_t extended() const { return extended2new.size(); }
  bool has_removed() const { return has_removed_; }
  /// The id of each work vertex in the result, or kRemoved.
  std::vector<Index> work2new() const;

  std::vector<Index> work2extended;  ///< or kRemoved
  std::vector<Index> extended2new;   ///< -1 for removed vertices
  std::vector<Index> new2original;   ///< -1 for inserted vertices; empty if the caller's vertices were all kept

 private:
  std::size_t originals_;
  bool has_removed_;
};

/// The positions of all vertices by extended id, in the caller's unit. Vertices that did not move keep the bits of
/// their coordinates; removed ones keep their last position.
std::vector<Point3> extended_points(const std::vector<Point3>& before, const std::vector<Point>& work_points,
                                    const VertexNumbering& numbering, double scale);

}  // namespace tetune
