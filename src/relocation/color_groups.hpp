// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "backend/buffer.hpp"
#include "energy/ring.hpp"

/// The colored vertices of a mesh, listed by color.
namespace tetune {

/// Independent sets of vertices: no two of one color share a tetrahedron (Sect. 4.1). Vertices that cannot move, and
/// those for which there is no color, have none.
template <class Backend>
struct Coloring {
  BufferOf<Backend, std::uint8_t> color;
  /// The movable vertices, by color, then by id; on a device, by color, by size of the ring, and then by id.
  BufferOf<Backend, Index> vertices;
  /// The vertices of color c are vertices[first[c]] .. vertices[first[c + 1] - 1].
  std::vector<Size> first;
  int colors() const { return first.empty() ? 0 : static_cast<int>(first.size()) - 1; }
  Span<const Index> vertices_of(int c) const {
    const Size begin = span_of(first)[c];
    return {vertices.span().data() + begin, span_of(first)[c + 1] - begin};
  }
};

namespace coloring_detail {

inline constexpr std::uint8_t kUncolored = 255;
/// The vertex gets no color.
inline constexpr std::uint8_t kExcluded = 254;
inline constexpr int kMaxColors = 128;

/// Bits of the keys by which vertices are listed: of the color, then of the size of the ring. On a device teams of a
/// warp evaluate several vertices at a time, and all of them wait for the largest ring; large rings come first, so that
/// no warp begins with one last.
template <class Backend>
inline constexpr int kSizeBits = Backend::kIsAsynchronous ? 3 : 0;
inline constexpr int kColorBits = 8;

struct ListColor {
  Span<const std::uint8_t> color;
  RingsView rings;
  int size_bits;
  Span<std::uint16_t> keys;
  Span<Index> vertices;
  TETUNE_HD void operator()(Size v) const {
    keys[v] = std::uint16_t(color[v] << size_bits | descending_size(v));
    vertices[v] = to_index(v);
  }

 private:
  /// 0 for the largest rings.
  TETUNE_HD int descending_size(Size v) const {
    constexpr int kFaces = 4;     // that a team evaluates at a time
    constexpr int kSmallest = 2;  // the lowest of the numbers of steps that are distinguished
    const int largest = (1 << size_bits) - 1;
    const int size = to_index((rings.offsets[v + 1] - rings.offsets[v]) / kFaces) - kSmallest;
    return size < 0 ? largest : size < largest ? largest - size : 0;
  }
};

/// Finds for each color the first of the sorted keys that is not below those of the color; the last entry is that of
/// kUncolored.
struct FindFirst {
  static constexpr Size kCount = kMaxColors + 2;
  Span<const std::uint16_t> keys;
  int size_bits;
  Span<Index> first;
  TETUNE_HD void operator()(Size i) const {
    const Size color = i + 1 < kCount ? i : kUncolored;
    first[i] = to_index(lower_bound(keys, color << size_bits));
  }
};

/// Lists the colored vertices by color. Returns the number of uncolored vertices.
template <class Backend>
Size group_by_color(const Backend& backend, const RingsView& rings, Coloring<Backend>& coloring) {
  const Size n = coloring.color.size();
  coloring.vertices.resize(backend, n);
  BufferOf<Backend, std::uint16_t> keys(backend, n);
  backend.for_each(n, ListColor{coloring.color, rings, kSizeBits<Backend>, keys, coloring.vertices});
  backend.sort_by_key(keys, coloring.vertices, kColorBits + kSizeBits<Backend>);
  BufferOf<Backend, Index> first(backend, FindFirst::kCount);
  backend.for_each(FindFirst::kCount, FindFirst{keys, kSizeBits<Backend>, first});
  const std::vector<Index> begin = first.download();
  coloring.first.clear();
  for (int c = 0; c < kMaxColors; ++c) {
    if (span_of(begin)[c] < span_of(begin)[c + 1]) coloring.first.push_back(span_of(begin)[c]);
  }
  coloring.first.push_back(span_of(begin)[kMaxColors]);
  coloring.vertices.resize(backend, coloring.first.back());
  return n - begin.back();
}

}  // namespace coloring_detail

}  // namespace tetune
