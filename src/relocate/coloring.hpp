// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/motion.hpp"
#include "core/work_mesh.hpp"
#include "energy/ring.hpp"
#include "surface/reference.hpp"

namespace tetune {

/// The triangles of the mesh's surface, the corners of each vertex, and the neighbours on lines: these need not share a
/// tetrahedron.
struct SurfaceStars {
  Span<const SurfaceTriangle> triangles;
  RowsView vertex2corner;
  Span<const LineVertex> line;
};

/// Independent sets of vertices: no two of one colour share a tetrahedron (Sect. 4.1). Vertices that cannot move
/// have no colour.
template <class Backend>
struct Coloring {
  typename Backend::template Buffer<std::uint8_t> color;
  /// The movable vertices, by colour, then by id.
  typename Backend::template Buffer<Index> vertices;
  /// Colour c owns vertices[first[c]] .. vertices[first[c + 1] - 1].
  std::vector<Size> first;
  int colors() const { return static_cast<int>(first.size()) - 1; }
};

/// Colours a mesh. Colours that are there already are kept where they do not conflict, so that after a few flips there
/// is little to do. Does not depend on the number of threads. With `stars`, vertices of one colour are also three edges
/// of the surface apart or more, as the bound on its deviation asks for positions two edges away; those for which there
/// is no such colour stay where they are. Colours that are there already were made with the same `stars`.
template <class Backend>
void color_vertices(const Backend& par, const RingsView& rings, Span<const Mobility> mobility,
                    Coloring<Backend>& coloring, const SurfaceStars& stars = {});

}  // namespace tetune
