// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "boundary/vertex_dof.hpp"
#include "tetune/mesh.hpp"
#include "tetune/options.hpp"

namespace tetune {

/// The constraints by the caller's lists and options, in the caller's ids.
struct Constraints {
  /// Per vertex. Required entities, periodic links and elements of other kinds freeze their vertices; ends and
  /// junctions of named groups of edges are corners, as are listed ones.
  std::vector<VertexConstraint> vertices;
  /// `vertices` as they would be without periodic links; empty if there are none.
  std::vector<VertexConstraint> vertices_without_links;
  /// 1 per listed triangle that must not change: a required one, or one of periodic vertices; empty if there is none.
  std::vector<std::uint8_t> required_triangles;
  /// Tetrahedra that must not change: required ones, then those of frozen regions.
  std::vector<Index> locked_tets;
  /// Listed edges that remain edges: tagged, ridges or required. Each once, as a pair in ascending order; ridges and
  /// required edges come first.
  std::vector<std::array<Index, 2>> edges;
  /// The number of ridges and required edges, which are feature edges whatever else the list contains.
  std::size_t ridges = 0;
};

/// Throws OptionError unless Options::frozen_vertices is empty or has an entry for each vertex.
void check_frozen_vertices(const TetMesh& mesh, const Options& options);

/// Throws OptionError where the options name tags or vertices that the mesh does not have.
Constraints find_constraints(const TetMesh& mesh, const Options& options);

/// The elements of other kinds by vertex.
class OtherElements {
 public:
  explicit OtherElements(const TetMesh& mesh);
  /// Whether an element has all of these vertices, so that their triangle or edge is a side of it.
  bool have(std::span<const Index> vertices) const { return !vertex2element_.empty() && any_has(vertices); }

 private:
  bool any_has(std::span<const Index> vertices) const;
  std::span<const std::pair<Index, std::size_t>> of(Index vertex) const;
  std::vector<std::pair<Index, std::size_t>> vertex2element_;  ///< sorted
};

/// 1 per listed edge that remains: it has a tag, is a ridge or required, or is an edge of one of `tets` or of `others`.
std::vector<std::uint8_t> lasting_edges(const TetMesh& mesh, const std::vector<std::array<Index, 4>>& tets,
                                        const OtherElements& others);

}  // namespace tetune
