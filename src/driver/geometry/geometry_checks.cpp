// SPDX-License-Identifier: Apache-2.0
#include "driver/geometry/geometry_checks.hpp"

#include <algorithm>
#include <cstdio>

#include "boundary/constraints.hpp"
#include "tetune/error.hpp"
#include "tetune/option_table.hpp"

namespace tetune {
namespace {

/// Throws OptionError for options that have no meaning on a geometry.
void refuse_options(const TetMesh& mesh, const Options& options) {
  const auto refuse = [](const std::string& text) { throw OptionError("on a geometry, " + text); };
  if (options.boundary != Boundary::slide) refuse("the surface slides: use boundary=slide");
  if (options.max_deviation > 0) refuse("max_deviation has no use: the surface ends on the geometry; leave it 0");
  if (!options.only_below.empty()) refuse("the whole mesh is optimized: leave only_below empty");
  if (options.untangle) refuse("every volume must be positive: untangle the mesh first, in a run of its own");
  if (options.data != DataTransfer::carry) refuse("data of vertices are carried: use data=carry");
  if (options.surface_vertices == SurfaceVertices::edit)
    refuse("vertices of the surface stay: use surface_vertices=keep");
  if (!mesh.periodic.empty()) refuse("periodic vertices cannot slide: take the links out of the mesh");
  if (!mesh.curved_edges.empty())
    refuse("elements are straight: convert the mesh to order 1 first (tetune convert IN OUT --order 1)");
}

/// The tags of surface triangles that must be frozen exist in the caller's list. Throws OptionError.
void check_frozen_patches(const TetMesh& mesh, const Options& options) {
  for (const int tag : options.frozen_patches) {
    if (std::find(mesh.triangle_tags.begin(), mesh.triangle_tags.end(), tag) == mesh.triangle_tags.end()) {
      throw OptionError("frozen_patches: no listed triangle has the tag " + std::to_string(tag));
    }
  }
}

}  // namespace

void check_geometry_options(const TetMesh& mesh, const Options& options) {
  refuse_options(mesh, options);
  check_options(options);
  check_frozen_patches(mesh, options);
  check_frozen_vertices(mesh, options);
}

std::string warning_of_left_off(const GeometryReport& report) {
  char distance[32];
  std::snprintf(distance, sizeof distance, "%.3g", report.largest_left_off);
  return std::to_string(report.vertices_left_off) + " vertices stay off the geometry, by up to " + distance +
         ": required entities, frozen parts or elements of other kinds hold them";
}

}  // namespace tetune
