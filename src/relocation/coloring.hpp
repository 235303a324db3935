// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "backend/buffer.hpp"
#include "boundary/sliding/reference_surface.hpp"
#include "relocation/color_groups.hpp"

/// Speculative coloring (Gebremedhin & Manne, "Scalable parallel graph coloring algorithms", 2000): in each round all
/// uncolored vertices take tentative colors at the same time, and of two neighbors with the same tentative color the
/// one of lower random priority (Jones & Plassmann 1993) tries again in the next round.
namespace tetune {

namespace coloring_detail {

/// A tentative color is chosen at random among the free ones of the first kWindow colors: this takes fewer rounds than
/// always choosing the first free color.
inline constexpr int kWindow = 8;
/// Rounds before the host reads the number of uncolored vertices. A device colors few vertices in one launch.
template <class Backend>
std::uint32_t rounds_per_batch(Size uncolored) {
  constexpr Size kSmall = 1024;
  return !Backend::kIsAsynchronous ? 1 : uncolored > kSmall ? 4 : 16;
}

/// A fixed pseudo-random order of the vertices (a bijection on 32 bits).
TETUNE_HD inline std::uint32_t priority(std::uint32_t vertex) {
  std::uint32_t h = vertex;
  h = (h ^ (h >> 16)) * 0x7feb352dU;
  h = (h ^ (h >> 15)) * 0x846ca68bU;
  return h ^ (h >> 16);
}
TETUNE_HD inline std::uint32_t priority(Index vertex) { return priority(static_cast<std::uint32_t>(vertex)); }

struct InitializeColor {
  Span<const VertexDof> dof;
  ReferenceView surface;
  Span<std::uint8_t> color;
  TETUNE_HD void operator()(Size v) const {
    color[v] = dof[v] == VertexDof::fixed || is_beside_high_valence(v) ? kExcluded : kUncolored;
  }

 private:
  static constexpr Size kMaxTriangles = 256;
  /// Whether a vertex of more than kMaxTriangles triangles is in a triangle at v: all its neighbors conflict with each
  /// other, which takes quadratic time and more colors than there are.
  TETUNE_HD bool is_beside_high_valence(Size v) const {
    const CsrView& corners = surface.vertex2corner;
    if (v + 1 >= corners.offsets.size()) return false;
    for (Size c = corners.begin(v); c < corners.end(v); ++c) {
      for (const Index near : surface.triangles[corners.items[c] / 3].v) {
        if (corners.size(near) > kMaxTriangles) return true;
      }
    }
    return false;
  }
};

/// The neighbors on the surface that a corner of a surface triangle lists for its vertex: of the two triangles at an
/// edge within a patch, only the one in which the neighbor follows the vertex lists it.
struct CornerNeighbors {
  Index next;
  Index previous;  ///< -1: listed by the triangle on the other side of the edge
};

TETUNE_HD inline CornerNeighbors corner_neighbors(const ReferenceView& surface, std::uint32_t corner) {
  const std::uint32_t after = corner % 3 == 2 ? corner - 2 : corner + 1;
  const std::uint32_t before = corner % 3 == 0 ? corner + 2 : corner - 1;
  const SurfaceTriangle t = surface.triangles[corner / 3];
  const Index opposite = surface.across[after];
  const bool follows_there =
      opposite != kFeatureEdge && surface.triangles[opposite / 3].v[(opposite + 1) % 3] == t.v[corner % 3];
  return {t.v[after % 3], follows_there ? -1 : t.v[before % 3]};
}

struct ListCornerNeighbors {
  ReferenceView surface;
  Span<CornerNeighbors> neighbors;
  TETUNE_HD void operator()(Size i) const { neighbors[i] = corner_neighbors(surface, surface.vertex2corner.items[i]); }
};

/// The vertices whose color must differ from that of a vertex.
struct ConflictNeighbors {
  RingsView rings;
  ReferenceView surface;
  /// corner_neighbors() of the corners in the order of surface.vertex2corner; empty where few vertices are visited.
  Span<const CornerNeighbors> on_surface;

  TETUNE_INLINE void prefetch(Span<const Index> vertices, Size i) const {
    constexpr Size kAhead = 8;
    if (i + kAhead < vertices.size()) rings.prefetch(vertices[i + kAhead]);
  }
  /// Calls `visitor` with each neighbor, with some of them repeatedly, until it returns false; returns whether it never
  /// did.
  template <class Visitor>
  TETUNE_HD TETUNE_INLINE bool visit(Index v, const Visitor& visitor) const {
    if (!visit_ring(v, visitor)) return false;
    const CsrView& corners = surface.vertex2corner;
    if (Size{v} + 1 >= corners.offsets.size()) return true;  // no surface was given, or the vertex was inserted
    for (const Index next : surface.line[v].next) {
      if (next >= 0 && !visitor(next)) return false;
    }
    return visit_surface(v, [&](Index near) {
      return visitor(near) && visit_surface(near, [&](Index far) { return far == v || visitor(far); });
    });
  }
  /// visit() for the vertices of the ring alone.
  template <class Visitor>
  TETUNE_HD TETUNE_INLINE bool visit_ring(Index v, const Visitor& visitor) const {
    for (Size i = rings.offsets[v]; i < rings.offsets[v + 1]; ++i) {
      const LinkFace f = rings.faces[i];
      for (int k = 0; k < 3; ++k) {
        if (!visitor(f.v[k])) return false;
      }
    }
    return true;
  }

 private:
  /// visit() for the neighbors on the surface.
  template <class Visitor>
  TETUNE_HD TETUNE_INLINE bool visit_surface(Index v, const Visitor& visitor) const {
    const CsrView& corners = surface.vertex2corner;
    for (Size i = corners.begin(v); i < corners.end(v); ++i) {
      const CornerNeighbors near = on_surface.size() > 0 ? on_surface[i] : corner_neighbors(surface, corners.items[i]);
      if (!visitor(near.next) || (near.previous >= 0 && !visitor(near.previous))) return false;
    }
    return true;
  }
};

/// A visitor that returns whether a vertex keeps its color beside a neighbor: the neighbor has another color, or a
/// lower priority.
struct KeepsColor {
  Span<const std::uint8_t> color;
  std::uint8_t own_color;
  std::uint32_t own_priority;
  TETUNE_HD bool operator()(Index other) const { return color[other] != own_color || priority(other) <= own_priority; }
};

/// Flags the vertices that have no color or that of a neighbor of higher priority. Rings alone are examined, as only
/// they change from one coloring to the next.
struct FindConflict {
  ConflictNeighbors neighbors;
  Span<const std::uint8_t> color;
  Span<std::uint8_t> conflicts;
  TETUNE_HD void operator()(Size v) const {
    const Index vertex = to_index(v);
    const bool conflict =
        color[v] < kMaxColors && !neighbors.visit_ring(vertex, KeepsColor{color, color[v], priority(vertex)});
    conflicts[v] = conflict || color[v] == kUncolored ? 1 : 0;
  }
};

/// Whether a vertex is flagged; such a vertex loses its color.
struct ResetConflicting {
  Span<const std::uint8_t> conflicts;
  Span<std::uint8_t> color;
  Span<std::uint8_t> tentative_color;
  TETUNE_HD bool operator()(Size v) const {
    if (conflicts[v] != 0) color[v] = kUncolored;
    tentative_color[v] = kUncolored;
    return conflicts[v] != 0;
  }
};

/// The vertices that have a color already.
enum class Colored : std::uint8_t { none, some };

/// Each uncolored vertex takes a tentative color that no colored neighbor has.
struct ChooseTentativeColor {
  ConflictNeighbors neighbors;
  Span<const Index> uncolored;
  Span<const std::uint8_t> color;
  Span<std::uint8_t> tentative_color;
  std::uint32_t round;
  Colored colored;

  /// The set of colors of the neighbors, in two registers: an array in memory would serialize the updates.
  struct UsedColors {
    static_assert(kMaxColors == 128);
    std::uint64_t low = 0;
    std::uint64_t high = 0;
    TETUNE_HD bool is_free(int c) const { return (((c < 64 ? low : high) >> (c & 63)) & 1) == 0; }
  };
  struct Visitor {
    Span<const std::uint8_t> color;
    UsedColors& used;
    TETUNE_HD bool operator()(Index other) const {
      const std::uint8_t c = color[other];
      const std::uint64_t bit = std::uint64_t{1} << (c & 63);
      used.low |= c < 64 ? bit : 0;
      used.high |= c >= 64 && c < kMaxColors ? bit : 0;
      return true;
    }
  };

  TETUNE_INLINE void prefetch(Size i, Size) const { neighbors.prefetch(uncolored, i); }
  TETUNE_HD void operator()(Size i) const {
    const Index v = uncolored[i];
    if (color[v] != kUncolored) return;
    UsedColors used;
    if (colored != Colored::none) neighbors.visit(v, Visitor{color, used});
    std::uint32_t free_in_window = 0;
    for (int c = 0; c < kWindow; ++c) free_in_window += used.is_free(c) ? 1 : 0;
    std::uint32_t skip = free_in_window > 0 ? priority(priority(v) + round) % free_in_window : 0;
    tentative_color[v] = kUncolored;
    for (std::uint8_t c = 0; c < kMaxColors; ++c) {
      if (used.is_free(c) && skip-- == 0) {
        tentative_color[v] = c;
        return;
      }
    }
  }
};

/// Makes a tentative color final unless a neighbor of higher priority has the same. The tentative colors of vertices
/// that got theirs in an earlier round cannot be the same: these were no longer free.
struct ResolveConflicts {
  ConflictNeighbors neighbors;
  Span<const Index> uncolored;
  Span<const std::uint8_t> tentative_color;
  Span<std::uint8_t> color;

  TETUNE_INLINE void prefetch(Size i, Size) const { neighbors.prefetch(uncolored, i); }
  TETUNE_HD void operator()(Size i) const {
    const Index v = uncolored[i];
    if (color[v] != kUncolored) return;
    const bool wins = neighbors.visit(v, KeepsColor{tentative_color, tentative_color[v], priority(v)});
    if (wins) color[v] = tentative_color[v];
  }
};

/// Rounds of coloring: in each a step that chooses, and one that resolves conflicts.
struct ColorInSteps {
  ChooseTentativeColor choose;  ///< in the first round
  ResolveConflicts resolve;

  TETUNE_INLINE void prefetch(Size i, Size end) const { resolve.prefetch(i, end); }
  TETUNE_HD void operator()(Size step, Size i) const {
    if (step % 2 != 0) return resolve(i);
    ChooseTentativeColor in_round = choose;
    in_round.round += static_cast<std::uint32_t>(step / 2);
    if (step > 0) in_round.colored = Colored::some;
    in_round(i);
  }
};

struct Exclude {
  Span<const Index> vertices;
  Span<std::uint8_t> color;
  TETUNE_HD void operator()(Size i) const { color[vertices[i]] = kExcluded; }
};

struct IsUncolored {
  Span<const Index> vertices;
  Span<const std::uint8_t> color;
  TETUNE_HD bool operator()(Size i) const { return color[vertices[i]] == kUncolored; }
};

struct Gather {
  Span<const Index> from;
  Span<const Index> positions;
  Span<Index> to;
  TETUNE_HD void operator()(Size i) const { to[i] = from[positions[i]]; }
};

/// Colors the uncolored vertices, round by round. Returns whether the colored ones are listed already.
template <class Backend>
bool color_uncolored(const Backend& backend, const ConflictNeighbors& neighbors, BufferOf<Backend, Index>& uncolored,
                     Span<std::uint8_t> tentative_color, Colored colored, Coloring<Backend>& coloring) {
  const Span<std::uint8_t> color = coloring.color;
  BufferOf<Backend, Index> remaining(backend, uncolored.size());
  BufferOf<Backend, Index> positions(backend, uncolored.size());
  Size count = uncolored.size();
  for (std::uint32_t round = 0; count > 0;) {
    const Span<const Index> vertices(uncolored.span().data(), count);
    const std::uint32_t rounds = rounds_per_batch<Backend>(count);
    backend.for_each_step(
        2 * rounds, count,
        ColorInSteps{{neighbors, vertices, color, tentative_color, round, round == 0 ? colored : Colored::some},
                     {neighbors, vertices, tentative_color, color}});
    round += rounds;
    // After many rounds a vertex is left only if it has too many neighbors.
    constexpr std::uint32_t kMany = 16;
    if (rounds >= kMany && group_by_color(backend, neighbors.rings, coloring) == 0) return true;
    const Size left = backend.compact(count, IsUncolored{vertices, color}, positions.span());
    if (left == count) {
      backend.for_each(count, Exclude{vertices, color});
      break;
    }
    backend.for_each(left, Gather{vertices, positions, remaining});
    uncolored.swap(remaining);
    count = left;
  }
  return false;
}

}  // namespace coloring_detail

/// Colors the vertices of a mesh. Existing colors remain where they do not conflict, so that few vertices change color
/// after a few flips. The result does not depend on the number of threads.
/// With `surface`, vertices of one color are also at least three edges of that surface apart, as the bound on its
/// deviation reads positions two edges away; inserted vertices are not on it. Existing colors must have been made with
/// the same `surface`. Vertices for which there is no color, as more than kMaxColors are all neighbors of each other,
/// get none, and do not move.
template <class Backend>
void color_vertices(const Backend& backend, const RingsView& rings, Span<const VertexDof> dof,
                    Coloring<Backend>& coloring, const ReferenceView& surface = {}) {
  using namespace coloring_detail;
  const Size n = dof.size();
  const Colored colored = coloring.color.size() == n ? Colored::some : Colored::none;
  if (colored == Colored::none) {
    coloring.color.resize(backend, n);
    backend.for_each(n, InitializeColor{dof, surface, coloring.color});
  }
  const Span<std::uint8_t> color = coloring.color;
  BufferOf<Backend, CornerNeighbors> on_surface;
  if (colored == Colored::none && surface.triangles.size() > 0) {
    on_surface.resize(backend, surface.vertex2corner.items.size());
    backend.for_each(on_surface.size(), ListCornerNeighbors{surface, on_surface.span()});
  }
  const ConflictNeighbors neighbors{rings, surface, std::as_const(on_surface).span()};
  BufferOf<Backend, std::uint8_t> conflicts(backend, n);
  BufferOf<Backend, std::uint8_t> tentative_color(backend, n);
  backend.for_each(n, FindConflict{neighbors, color, conflicts});
  BufferOf<Backend, Index> uncolored(backend, n);
  const ResetConflicting reset{conflicts, color, tentative_color};
  uncolored.resize(backend, backend.compact(n, reset, uncolored.span()));
  if (uncolored.size() == 0 && colored == Colored::some) return;
  if (!color_uncolored(backend, neighbors, uncolored, tentative_color.span(), colored, coloring)) {
    group_by_color(backend, rings, coloring);
  }
}

}  // namespace tetune
