// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "io/plugin/plugin_call.hpp"
#include "tetune/geometry.hpp"

namespace tetune {

struct ProjectSettings {
  double unit = 1;  ///< in mm
  int threads = 1;
  /// Points may be off along their surface by this part of their distance, so that the distance is off by its square.
  double precision = 0;
};

/// Geometry::project() by a request to the plugin.
std::vector<Point3> request_projections(PluginSession& session, const ProjectSettings& settings,
                                        const std::vector<Point3>& points, const std::vector<GeometryEntity>& entities,
                                        const std::vector<double>& radii);

}  // namespace tetune
