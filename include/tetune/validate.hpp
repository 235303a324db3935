// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// Most vertices, and most entries of any list but that of the tetrahedra (kMaxTets): ids have 32 bits, and some are
/// left for vertices that are inserted.
inline constexpr Index kMaxEntries = 2'000'000'000;

/// What can be wrong with a mesh.
enum class Defect {
  index_out_of_range,
  bad_array_length,
  not_finite,
  repeated_vertex,
  inverted_tet,
  flat_tet,
  tiny_tet,
  duplicate_tet,
  face_on_three_tets,
  same_side_of_face,
};

/// A short name in plain words, for example "flat tetrahedra".
const char* to_string(Defect defect);

/// One kind of defect: how many, and the first few places.
struct Finding {
  Defect defect;
  std::int64_t count = 0;
  /// Zero-based ids of the first (at most 5) offenders, in increasing order: tetrahedra, or vertices where
  /// the defect is one of vertices (not_finite).
  std::vector<Index> first;
  /// What the ids count: "tetrahedra", "vertices", "triangles", ...
  std::string where;
  /// Centre of the first of them, where they are tetrahedra of finite coordinates.
  std::optional<Point3> place = std::nullopt;
};

struct ValidationReport {
  std::vector<Finding> findings;
  bool ok() const { return findings.empty(); }
  /// One line per finding; ids are one-based when `one_based` (as MEDIT counts), else zero-based.
  std::string message(bool one_based) const;
};

/// Checks that a mesh is one that the optimiser accepts.
///
/// Checked: array lengths (kMaxTets, kMaxEntries), indices, finite coordinates, four distinct vertices a tetrahedron,
/// each volume exactly positive (decided in exact arithmetic where rounding leaves doubt) and not below 1e-255 of the
/// cube of the largest coordinate, where arithmetic underflows, no tetrahedron listed twice, each face on one or two
/// tetrahedra which lie on opposite sides. The boundary is then closed: the faces on one tetrahedron are the boundary
/// (modulo 2) of all tetrahedra together, and a boundary has no boundary. `threads` 0 means all. Safe to call
/// concurrently. Throws nothing but std::bad_alloc.
ValidationReport validate(const TetMesh& mesh, int threads = 0);

/// Turns tetrahedra that are listed inside out, by exchanging their last two vertices, so that neighbours agree and
/// each connected part has a positive volume in all; returns how many. When that is all of them, as some programs list
/// them, it is noted in `mesh.listed_inside_out`. What is inverted beside neighbours that agree stays so: see
/// Options::untangle. `threads` 0 means all.
std::int64_t orient_uniformly(TetMesh& mesh, int threads = 0);

}  // namespace tetune
