// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "boundary/sliding/reference_surface.hpp"
#include "energy/ring.hpp"

namespace tetune {

/// Independent sets of vertices: no two of one color share a tetrahedron (Sect. 4.1). Vertices that cannot move have no
/// color.
template <class Backend>
struct Coloring {
  BufferOf<Backend, std::uint8_t> color;
  /// The movable vertices, by color, then by id.
  BufferOf<Backend, Index> vertices;
  /// The vertices of color c are vertices[first[c]] .. vertices[first[c + 1] - 1].
  std::vector<Size> first;
  int colors() const { return first.empty() ? 0 : static_cast<int>(first.size()) - 1; }
  Span<const Index> vertices_of(int c) const {
    const Size begin = span_of(first)[c];
    return {vertices.span().data() + begin, span_of(first)[c + 1] - begin};
  }
};

/// Colors the vertices of a mesh. Existing colors remain where they do not conflict, so that few vertices change color
/// after a few flips. The result does not depend on the number of threads.
/// With `surface`, vertices of one color are also at least three edges of the surface apart, as the bound on its
/// deviation reads positions two edges away; vertices for which there is no such color do not move. Existing colors
/// must have been made with the same `surface`. Throws MeshError where a vertex has too many neighbors.
template <class Backend>
void color_vertices(const Backend& backend, const RingsView& rings, Span<const VertexDof> dof,
                    Coloring<Backend>& coloring, const SurfaceAdjacency& surface = {});

}  // namespace tetune
