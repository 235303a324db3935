// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tuple>

#include "tetune/report.hpp"

namespace tetune {

/// The numbers of vertices of a report by their degrees of freedom, as references.
inline auto dof_counts(Report& r) {
  return std::tie(r.free_vertices, r.plane_vertices, r.line_vertices, r.fixed_vertices, r.surface_vertices,
                  r.curve_vertices);
}

}  // namespace tetune
