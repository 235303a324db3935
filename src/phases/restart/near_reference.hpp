// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "boundary/sliding/reference_surface.hpp"

namespace tetune {

/// The vertices and triangles of the reference surface that are near some of its triangles.
class NearReference {
 public:
  explicit NearReference(const ReferenceSurfaceOnHost& reference)
      : is_near(reference.points.size(), 0), reference_(reference) {}

  std::vector<std::uint8_t> is_near;  ///< per vertex
  std::vector<Index> vertices;        ///< those that are near, in the order of their addition

  void add_triangle(Index t) {
    if (t < 0) return;
    for (const Index v : span_of(reference_.triangles)[t].v) add_vertex(v);
  }
  void add(const SurfacePoint& on) {
    switch (on.kind) {
      case SurfacePointKind::none:
        break;
      case SurfacePointKind::vertex:
        add_vertex(on.item);
        break;
      case SurfacePointKind::edge:
        add_triangle(on.item / 3);
        break;
      case SurfacePointKind::triangle:
        add_triangle(on.item);
        break;
      case SurfacePointKind::segment:
        add_vertex(on.item / 2);
        add_vertex(span_of(reference_.line)[on.item / 2].next[on.item % 2]);
        break;
    }
  }
  /// Adds the neighbors of all vertices.
  void add_ring() {
    const std::size_t end = vertices.size();
    for (std::size_t i = 0; i < end; ++i) {
      const Index v = vertices[i];
      for (const std::uint32_t corner : reference_.corners_at(v)) add_triangle(to_index(corner / 3));
      if (span_of(reference_.dof)[v] != VertexDof::curve) continue;
      for (const Index next : span_of(reference_.line)[v].next) add_vertex(next);
    }
  }

 private:
  void add_vertex(Index v) {
    if (v < 0 || std::exchange(span_of(is_near)[v], std::uint8_t{1}) != 0) return;
    vertices.push_back(v);
  }

  const ReferenceSurfaceOnHost& reference_;
};

}  // namespace tetune
