// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Whether the Jacobian determinant of a ten-node tetrahedron is positive everywhere in it. Both of the first two are
/// proved, with rounding errors accounted for.
enum class CurvedValidity : std::uint8_t {
  valid,      ///< it is positive
  inverted,   ///< it is negative somewhere
  undecided,  ///< its minimum is 0 up to rounding, or subdivision reached its limit
};

/// In words: "valid", "inverted", "undecided".
TETUNE_API const char* to_string(CurvedValidity validity);

/// Measures of a second-order tetrahedron with a curved edge. Determinants are relative to that of the straight
/// tetrahedron with the same vertices, so that all are 1 for a straight one; they are infinite for a flat one.
struct CurvedTet {
  Index tet = -1;
  CurvedValidity validity = CurvedValidity::valid;
  /// Certified bounds of the determinant over the element by its Bezier coefficients (Johnen, Remacle, Geuzaine 2013):
  /// min_lower <= minimum <= min_upper, and likewise the maximum; up to the rounding of the division.
  double min_lower = 1, min_upper = 1, max_lower = 1, max_upper = 1;
  /// Largest determinant over smallest one at the four vertices; infinite unless all are positive.
  double corner_ratio = 1;
  /// Smallest determinant over largest one at the four integration points of Abaqus's and CalculiX's C3D10.
  double integration_ratio = 1;
  /// Largest distance of a mid-side node from the midpoint, relative to the length of the edge.
  double middle_offset = 0;
  /// Centroid of the vertices.
  Point3 centroid{};
  /// The smallest scaled Jacobian: the lower bound of the minimum.
  double scaled_jacobian() const { return min_lower; }
};

/// The second-order tetrahedra with curved edges of a mesh, as a summary.
struct CurvedQuality {
  std::int64_t curved_edges = 0;
  std::int64_t tets = 0;  ///< with a curved edge; all numbers below are of these
  std::int64_t valid = 0, inverted = 0, undecided = 0;
  /// Number of those whose determinant is not positive at one of the integration points, where solvers stop.
  std::int64_t bad_integration = 0;
  /// Over all tetrahedra of the mesh: at most 1.
  double min_scaled_jacobian = 1;
  double max_corner_ratio = 1, max_middle_offset = 0;
  /// Those of the smallest scaled Jacobian, the smallest first, then by id.
  std::vector<CurvedTet> worst;
  bool all_valid() const { return valid == tets; }
};

/// Measures the tetrahedra with a curved edge, in increasing order of their ids; other tetrahedra are straight, and
/// validate() checks them. The result is bit for bit the same for any number of threads; `threads` 0 means all. Throws
/// MeshError where validate() finds an array of the wrong length, an index out of range, a coordinate that is not
/// finite, or a wrong entry of `curved_edges`.
TETUNE_API std::vector<CurvedTet> measure_curved_each(const TetMesh& mesh, int threads = 0);

/// Summary of measure_curved_each(), with at most `worst` entries in CurvedQuality::worst.
TETUNE_API CurvedQuality measure_curved(const TetMesh& mesh, int threads = 0, int worst = 10);

}  // namespace tetune
