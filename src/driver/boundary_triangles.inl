// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "boundary/classify.inl"
#include "flips/boundary_flips.hpp"
#include "par/atomic.hpp"

/// The triangles of the boundary between the caller's list and the flips.
namespace tetune {
namespace boundary_triangles_detail {

/// Counts the listed triangles that name a face of the surface, and keeps the last one's position.
struct CountListed {
  Span<const Index> listed2triangle;
  Span<std::uint32_t> counts;
  Span<std::uint32_t> last;
  TETUNE_HD void operator()(Size i) const {
    const Index s = listed2triangle[i];
    if (s < 0) return;
    par::atomic_add(counts[s], 1);
    par::atomic_max(last[s], static_cast<std::uint32_t>(i));
  }
};

struct FillTriangle {
  Span<const SurfaceTriangle> surface;
  Span<const int> tags;
  ListedTriangles listed;
  Span<const std::uint32_t> counts;
  Span<const std::uint32_t> last;
  Span<const std::uint8_t> frozen;
  Span<BoundaryTriangle> triangles;
  TETUNE_HD void operator()(Size s) const {
    BoundaryTriangle t{};
    for (int k = 0; k < 3; ++k) t.v[k] = surface[s].v[k];
    t.tag = tags[s];
    t.listed = counts[s] == 0 ? -1 : static_cast<Index>(last[s]);
    if (t.listed >= 0) {
      const ListedTriangle mine = listed[t.listed];
      const Index* v = mine.v;
      const int at = v[0] == t.v[0] ? 0 : v[1] == t.v[0] ? 1 : 2;
      t.turned = v[(at + 1) % 3] == t.v[1] ? 0 : 1;
    }
    // Required and frozen triangles have no other vertices.
    const bool held = frozen[t.v[0]] == kFrozen && frozen[t.v[1]] == kFrozen && frozen[t.v[2]] == kFrozen;
    t.stays = held || counts[s] > 1 ? 1 : 0;
    triangles[s] = t;
  }
};

}  // namespace boundary_triangles_detail

template <class Backend>
void build_boundary(const Backend& par, const Surface<Backend>& surface, const ListedTriangles& listed,
                    Span<const std::uint8_t> frozen, BoundaryTriangles<Backend>& boundary) {
  using namespace boundary_triangles_detail;
  const Size faces = surface.triangles.size();
  typename Backend::template Buffer<std::uint32_t> counts(faces);
  typename Backend::template Buffer<std::uint32_t> last(faces);
  par.fill(counts.span(), std::uint32_t{0});
  par.fill(last.span(), std::uint32_t{0});
  par.for_each(listed.size(), CountListed{surface.listed2triangle.span(), counts.span(), last.span()});
  boundary.triangles.resize(faces);
  par.for_each(faces, FillTriangle{surface.triangles.span(), surface.tags.span(), listed, counts.span(), last.span(),
                                   frozen, boundary.triangles.span()});
  boundary.flat = kFlat;
}

/// Brings the caller's listed triangles to where flips have put them; each turns the way it did.
inline void follow_flips(const std::vector<BoundaryTriangle>& boundary, const std::vector<Index>& vertex2original,
                         std::vector<std::array<Index, 3>>& triangles) noexcept {
  for (const BoundaryTriangle& t : boundary) {
    if (t.listed < 0) continue;
    auto& mine = triangles[static_cast<std::size_t>(t.listed)];
    std::array<Index, 3> now{};
    for (std::size_t k = 0; k < 3; ++k) now[k] = vertex2original[static_cast<std::size_t>(t.v[k])];
    if (std::is_permutation(now.begin(), now.end(), mine.begin())) continue;
    if (t.turned != 0) std::swap(now[1], now[2]);
    mine = now;
  }
}

}  // namespace tetune
