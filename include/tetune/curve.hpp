// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"
#include "tetune/report.hpp"

namespace tetune {

class Geometry;

/// The options of curve().
struct CurveOptions {
  /// An edge where the surface turns by more than this many degrees, in (0, 180], is a feature: the surface is not
  /// smooth across it.
  double feature_angle = 45;
  /// Number of CPU threads, 0 to 4096; 0 means all. The result does not depend on it.
  int threads = 0;
  /// If not null, a finer mesh of the same part: tetrahedra, or triangles alone, linear or with curved edges. Mid-side
  /// nodes are on its surface (reconstructed likewise if it is straight), and on its feature lines where the edge is a
  /// feature. A node that would be farther from the midpoint than a quarter of its edge is placed as if this were null.
  const TetMesh* surface = nullptr;
  /// If not null, the CAD model of the part, instead of `surface` and `feature_angle`: mid-side nodes are the points of
  /// its edges and faces nearest to the midpoints.
  const Geometry* geometry = nullptr;
  /// If set and true, ends the relaxation early: more edges are straightened then.
  std::function<bool()> stop{};
};

/// The account of curve().
struct CurveReport {
  std::int64_t curved_edges = 0, curved_tets = 0;
  /// Of the straight tetrahedra with curved edges alone, those that are not valid.
  std::int64_t not_valid_before = 0;
  /// With CurveOptions::geometry: number of edges of the surface that stay straight because it is not clear what they
  /// are on, or because that is farther from the midpoint than a quarter of the edge.
  std::int64_t edges_off_geometry = 0;
  /// Number of inner vertices that moved to make elements valid.
  std::int64_t vertices_moved = 0;
  double min_scaled_jacobian = 1;
  /// Sorted by vertices. Empty where inner nodes alone made all elements valid.
  std::vector<StraightenedEdge> straightened;
};

/// Makes the elements of a straight mesh second-order ones with curved edges on the surface (boundary, interfaces,
/// tagged triangles), each proved valid. The surface is reconstructed from the triangles alone: between features it is
/// smooth, flat parts and straight lines stay so, and mid-side nodes are within O(h^3) of a smooth surface through the
/// vertices. Where an element would not be valid, inner mid-side nodes and inner vertices move; where that does not
/// suffice, the curvature of its edges on the surface is reduced in steps of a quarter. Vertices of the surface keep
/// their bits. The deck of an .inp file is dropped. Throws MeshError if the mesh is not valid, has curved edges or
/// elements other than tetrahedra, triangles, edges and points, if CurveOptions::surface has no triangles, or is
/// farther from a vertex of the surface than a tenth of its shortest edge on it, as Geometry::match() does, and
/// OptionError.
TETUNE_API CurveReport curve(TetMesh& mesh, const CurveOptions& options = {});

}  // namespace tetune
