// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "boundary/edge_set.hpp"
#include "boundary/sliding/slide_surface.hpp"
#include "boundary/surface.hpp"
#include "boundary/vertex_dofs.hpp"
#include "mesh/work_mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// The input of find_dofs().
template <class Backend>
struct DofInput {
  const Options& options;
  const Surface<Backend>& surface;
  /// The constrained edges, as pairs of work vertices; the first `ridges` of them are ridges or required edges.
  const std::vector<Index>& edge_ends;
  std::size_t ridges;
  const EdgeSet<Backend>& edges;
  Span<const std::uint8_t> frozen;  ///< kMovable, kFrozen or kCorner per work vertex
  double scale;                     ///< coordinates of the work mesh per unit of the caller's
  const SlideSurface* slides_on;    ///< the surface for Boundary::slide; null: the mesh's own
  const std::vector<Index>& original2vertex;
};

/// Decides where each vertex may go, by Options::boundary, and makes all vertices active. The report receives the
/// numbers of vertices by degrees of freedom, and of listed corners and edges that are no features.
template <class Backend>
void find_dofs(const Backend& backend, WorkMesh<Backend>& mesh, const DofInput<Backend>& input,
               VertexDofs<Backend>& dofs, Report& report);

}  // namespace tetune
