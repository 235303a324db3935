// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/context.hpp"
#include "tetune/export.hpp"
#include "tetune/geometry.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// The account of a run of optimize_on_geometry().
struct GeometryReport {
  Report optimization;   ///< of the whole run: its maps are from the result to the input
  GeometryMatch before;  ///< of the input
  GeometryMatch after;   ///< of the result
  /// Empty without GeometryOptions::measures.
  GeometryDeviation deviation_before, deviation_after;
  /// The part of the way onto the geometry that the vertices of the input were moved first: below 1 where a further
  /// step would invert elements, 0 where they were not to be moved.
  double snapped = 1;
  std::int64_t vertices_snapped = 0;  ///< number of vertices that were not on the geometry
  int rounds = 0;                     ///< number of rounds of sliding whose result was taken
  /// Number of vertices that stayed where they were on the geometry, because elements would be inverted otherwise, or
  /// worse than the worst of the input.
  std::int64_t vertices_held = 0;
  /// Number of vertices that were not moved onto the geometry, because required entities, frozen parts or elements of
  /// other kinds than of one vertex hold them, and the largest of their distances.
  std::int64_t vertices_left_off = 0;
  double largest_left_off = 0;
};

struct GeometryOptions {
  bool snap = true;      ///< whether vertices that are off the geometry are moved onto it first
  bool measures = true;  ///< whether the surface's distance from the geometry is measured before and after
};

/// Improves a mesh as optimize() does with Boundary::slide, with the vertices of its surface on the surface of a CAD
/// model: those on its faces end on these, those on its edges on these, and those at its vertices stay, all to
/// rounding. Vertices of the surface whose entity is not clear stay (GeometryMatch::without_entity).
///
/// With GeometryOptions::snap, the vertices are first moved onto the geometry, as move() does; those of elements of one
/// vertex too, which stay otherwise, but none that the caller or the mesh holds besides. Then the surface slides
/// on its own triangles, with the faces of the model as patches, its vertices are moved to the nearest points of their
/// faces and edges, and the mesh is optimized with that surface; a round is taken if no element is inverted, and the
/// smallest dihedral angle is not below that before the round. Without `snap`, vertices that do not move in the rounds
/// stay off the geometry. Vertices of the surface are neither inserted nor removed.
///
/// The result is bit for bit the same for any number of threads. Tags, triangles and edges are the caller's. Throws as
/// optimize() and Geometry::match() do, and OptionError for another boundary than slide, max_deviation, only_below,
/// untangle, data other than carry, surface_vertices=edit, periodic and curved meshes; the mesh is then unchanged.
TETUNE_API GeometryReport optimize_on_geometry(TetMesh& mesh, const Geometry& geometry, const Options& options,
                                               const GeometryOptions& on_geometry = {}, const Context& context = {});

}  // namespace tetune
