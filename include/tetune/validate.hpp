// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Maximum number of vertices, and of entries of any list except that of the tetrahedra (kMaxTets): ids have 32 bits,
/// of which some remain for inserted vertices.
inline constexpr Index kMaxEntries = 2'000'000'000;

/// A kind of defect of a mesh.
enum class Defect {
  index_out_of_range,
  bad_array_length,  ///< of tags or data, or more entries than kMaxTets or kMaxEntries
  not_finite,        ///< a coordinate is infinite or not a number
  repeated_vertex,   ///< within a tetrahedron
  inverted_tet,      ///< negative volume
  flat_tet,          ///< volume 0
  tiny_tet,          ///< its determinant has terms below 1e-255 of the cube of the largest coordinate, which underflow
  duplicate_tet,     ///< the same four vertices
  face_on_three_tets,  ///< or on more: the mesh is not a manifold there
  same_side_of_face,   ///< two tetrahedra overlap: they lie on the same side of their common face
  bad_curved_edge,     ///< not in order, listed twice, or not an edge of a tetrahedron, listed triangle or listed edge
};

/// In words, for example "flat tetrahedra".
TETUNE_API const char* to_string(Defect defect);

/// An index outside a list.
struct BadIndex {
  std::int64_t index = 0;  ///< zero-based, as the limits
  std::int64_t entries = 0;
  std::string list;  ///< "vertices", "triangles", ...
  /// Whether all indices of the array seem to start from 1: the largest is `entries`, and none is 0.
  bool from_one = false;
};

/// A vertex and its coordinate of the largest size.
struct LargestCoordinate {
  Index vertex = 0;
  double value = 0;
};

/// One kind of defect, with the number of offenders and the first of them.
struct Finding {
  Defect defect;
  std::int64_t count = 0;
  /// Zero-based ids of the first (at most 5) offenders, in increasing order: tetrahedra, or vertices where
  /// the defect is one of vertices (not_finite).
  std::vector<Index> first;
  /// The array that the ids refer to: "tetrahedra", "vertices", "triangles", ...
  std::string where;
  /// Centroid of the first of them, if they are tetrahedra with finite coordinates.
  std::optional<Point3> place = std::nullopt;
  /// Of an array of the wrong length, whose length is `count`: the right one, or -1 if none is.
  std::int64_t expected = 0;
  std::optional<BadIndex> bad_index = std::nullopt;  ///< the first one
  /// Of tetrahedra that are too small for it (tiny_tet).
  std::optional<LargestCoordinate> largest = std::nullopt;
};

struct TETUNE_API ValidationReport {
  /// The advice to callers of the library.
  static constexpr const char* kUntangle = "untangle them (untangle=true)";

  std::vector<Finding> findings;
  bool ok() const { return findings.empty(); }
  /// One sentence and line per finding, with ids that start from 1 (as in MEDIT files) or from 0. `advice` for a mesh
  /// that untangling makes valid stands before ", or repair the mesh".
  std::string message(bool one_based, const std::string& advice = kUntangle) const;
};

/// Checks whether optimize() accepts a mesh.
///
/// Checked: array lengths (kMaxTets, kMaxEntries), indices, finite coordinates, four distinct vertices per
/// tetrahedron, the sign of each volume (by exact arithmetic where rounding errors could change it), no determinant
/// whose terms are below 1e-255 of the cube of the largest coordinate, no tetrahedron listed twice, each face on one or
/// two tetrahedra that lie on opposite sides. The boundary is then closed: the faces on one tetrahedron are the
/// boundary (modulo 2) of all tetrahedra together, and a boundary has no boundary. `threads` 0 means all. Safe to call
/// concurrently. Throws only std::bad_alloc.
TETUNE_API ValidationReport validate(const TetMesh& mesh, int threads = 0);

/// Reverses tetrahedra that are listed inside out, by exchanging their last two vertices, so that neighbors have the
/// same orientation and the total volume of each connected part is positive; returns their number. If it is all of
/// them, as some programs list them, it sets `mesh.listed_inside_out`. A tetrahedron that is inverted geometrically,
/// although its neighbors have the same orientation, stays so: see Options::untangle. `threads` 0 means all.
TETUNE_API std::int64_t orient_uniformly(TetMesh& mesh, int threads = 0);

}  // namespace tetune
