// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/optimize.hpp"

namespace tetune {

/// What the caller's lists and options say must stay, in the caller's ids.
struct Constraints {
  /// kMovable, kFrozen or kCorner for each vertex. Required entities and elements of other kinds freeze theirs.
  std::vector<std::uint8_t> frozen;
  /// Tetrahedra that stay as they are: required ones and those of frozen regions.
  std::vector<Index> locked_tets;
  /// Listed edges that stay: tagged, ridges or required. Pairs, each once; those that are ridges or required come
  /// first.
  std::vector<std::array<Index, 2>> edges;
  /// How many of them are ridges or required: feature lines whatever else the list holds.
  std::size_t ridges = 0;
};

/// Throws OptionError where the options name what is not there.
Constraints find_constraints(const TetMesh& mesh, const Options& options);

/// Which elements of other kinds have which vertices.
class OtherElements {
 public:
  explicit OtherElements(const TetMesh& mesh);
  /// Whether one of them has all of these vertices, so that a triangle or edge of them is a side of it.
  bool have(std::span<const Index> vertices) const { return !vertex2element_.empty() && any_has(vertices); }

 private:
  bool any_has(std::span<const Index> vertices) const;
  std::span<const std::pair<Index, std::size_t>> of(Index vertex) const;
  std::vector<std::pair<Index, std::size_t>> vertex2element_;  ///< sorted
};

/// 1 for each listed edge that stays: it has a tag, is a ridge or required, or is an edge of one of `tets` or of the
/// `others`.
std::vector<std::uint8_t> lasting_edges(const TetMesh& mesh, const std::vector<std::array<Index, 4>>& tets,
                                        const OtherElements& others);

/// Where the entries of a list go when those with keep[i] 0 are dropped: their new positions, or -1.
std::vector<Index> positions_of_kept(const std::vector<std::uint8_t>& keep);

/// Moves the listed triangles or edges to their new positions, and renumbers what refers to them; returns the number
/// dropped.
std::int64_t keep_triangles(TetMesh& mesh, const std::vector<Index>& old2new) noexcept;
std::int64_t keep_edges(TetMesh& mesh, const std::vector<Index>& old2new) noexcept;

/// Moves the vertices to their new positions, and renumbers all that refers to them. Those without one are in no
/// element; as corners they are forgotten.
void keep_vertices(TetMesh& mesh, const std::vector<Index>& old2new) noexcept;

}  // namespace tetune
