// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "backend/span.hpp"
#include "mesh/tet.hpp"

/// Layers of tetrahedra around marked ones. A mark is 1 or 0, per vertex or tetrahedron; a list of tetrahedra may have
/// free slots.
namespace tetune {
namespace vertex_layers_detail {

inline std::span<const Index> vertices(const std::array<Index, 4>& tet) { return tet; }
inline std::span<const Index> vertices(const Tet& tet) {
  return std::span<const Index>(tet.v).first(tet[0] == kFreeSlot ? 0 : 4);
}

template <class AnyTet>
bool has_marked(const AnyTet& tet, Span<const std::uint8_t> marks) {
  const std::span<const Index> v = vertices(tet);
  return std::any_of(v.begin(), v.end(), [marks](Index i) { return marks[i] != 0; });
}

template <class AnyTet>
void mark_vertices(const AnyTet& tet, std::vector<std::uint8_t>& marks) {
  for (const Index v : vertices(tet)) span_of(marks)[v] = 1;
}

}  // namespace vertex_layers_detail

/// Marks the vertices of the marked tetrahedra. `count`: the number of vertices.
template <class AnyTet>
std::vector<std::uint8_t> vertices_of(const std::vector<AnyTet>& tets, const std::vector<std::uint8_t>& tet_marks,
                                      std::size_t count) {
  std::vector<std::uint8_t> marks(count, 0);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    if (tet_marks[t] != 0) vertex_layers_detail::mark_vertices(tets[t], marks);
  }
  return marks;
}

/// Marks the vertices of the tetrahedra that are not marked. `count`: the number of vertices.
template <class AnyTet>
std::vector<std::uint8_t> vertices_of_others(const std::vector<AnyTet>& tets,
                                             const std::vector<std::uint8_t>& tet_marks, std::size_t count) {
  std::vector<std::uint8_t> marks(count, 0);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    if (tet_marks[t] == 0) vertex_layers_detail::mark_vertices(tets[t], marks);
  }
  return marks;
}

/// Marks the tetrahedra that have a marked vertex.
template <class AnyTet>
std::vector<std::uint8_t> tets_at(const std::vector<AnyTet>& tets, const std::vector<std::uint8_t>& vertex_marks) {
  std::vector<std::uint8_t> marks;
  marks.reserve(tets.size());
  for (const AnyTet& tet : tets) {
    marks.push_back(vertex_layers_detail::has_marked(tet, span_of(vertex_marks)) ? 1 : 0);
  }
  return marks;
}

/// Marks also the other vertices of the tetrahedra that have a marked vertex.
template <class AnyTet>
void add_layer(const std::vector<AnyTet>& tets, std::vector<std::uint8_t>& vertex_marks) {
  const std::vector<std::uint8_t> before = vertex_marks;
  for (const AnyTet& tet : tets) {
    if (vertex_layers_detail::has_marked(tet, span_of(before))) vertex_layers_detail::mark_vertices(tet, vertex_marks);
  }
}

}  // namespace tetune
