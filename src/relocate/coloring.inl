// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "par/beside_host.hpp"
#include "relocate/coloring.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace coloring_detail {

inline constexpr std::uint8_t kUncolored = 255;
inline constexpr std::uint8_t kNotMovable = 254;
inline constexpr int kMaxColors = 128;
/// Free colours are taken at random among the lowest so many: fewer rounds than always the lowest.
inline constexpr int kWindow = 8;
/// Rounds before the host learns how many are left.
template <class Backend>
inline constexpr std::uint32_t kRoundsAtOnce = par::kBesideHost<Backend> ? 4 : 1;

/// A fixed pseudo-random order of the vertices (a bijection on 32 bits).
TETUNE_HD inline std::uint32_t priority(Index vertex) {
  auto h = static_cast<std::uint32_t>(vertex);
  h = (h ^ (h >> 16)) * 0x7feb352dU;
  h = (h ^ (h >> 15)) * 0x846ca68bU;
  return h ^ (h >> 16);
}

struct Start {
  Span<const Mobility> mobility;
  SurfaceStars stars;
  Span<std::uint8_t> color;
  TETUNE_HD void operator()(Size v) const {
    color[v] = mobility[v] == Mobility::fixed || is_crowded(v) ? kNotMovable : kUncolored;
  }

 private:
  static constexpr Size kMostTriangles = 256;
  /// Whether a vertex with too many triangles is in a triangle at v: those around it would all be apart from each
  /// other, which takes squared time, and there are not so many colours.
  TETUNE_HD bool is_crowded(Size v) const {
    const RowsView& rows = stars.vertex2corner;
    if (v + 1 >= rows.offsets.size()) return false;
    for (Size c = rows.begin(v); c < rows.end(v); ++c) {
      for (const Index near : stars.triangles[rows.items[c] / 3].v) {
        if (rows.size(near) > kMostTriangles) return true;
      }
    }
    return false;
  }
};

/// The vertices that may not have the colour of another one.
struct Apart {
  RingsView rings;
  SurfaceStars stars;

  TETUNE_INLINE void prefetch(Span<const Index> vertices, Size i) const {
    constexpr Size kAhead = 8;
    if (i + kAhead < vertices.size()) rings.prefetch(vertices[i + kAhead]);
  }
  /// Hands them to `go_on`, some of them again, until that is false.
  template <class GoOn>
  TETUNE_HD TETUNE_INLINE void visit(Index v, const GoOn& go_on) const {
    if (!visit_ring(v, go_on)) return;
    const RowsView& rows = stars.vertex2corner;
    if (Size{v} + 1 >= rows.offsets.size()) return;  // none were asked for, or the vertex was inserted
    for (const Index next : stars.line[v].next) {
      if (next >= 0 && !go_on(next)) return;
    }
    for (Size c = rows.begin(v); c < rows.end(v); ++c) {
      for (const Index near : stars.triangles[rows.items[c] / 3].v) {
        if (near == v) continue;
        for (Size d = rows.begin(near); d < rows.end(near); ++d) {
          for (const Index far : stars.triangles[rows.items[d] / 3].v) {
            if (far != v && !go_on(far)) return;
          }
        }
      }
    }
  }
  /// Those of its ring alone; returns whether to go on.
  template <class GoOn>
  TETUNE_HD TETUNE_INLINE bool visit_ring(Index v, const GoOn& go_on) const {
    for (Size i = rings.offsets[v]; i < rings.offsets[v + 1]; ++i) {
      const LinkFace f = rings.faces[i];
      for (int k = 0; k < 3; ++k) {
        if (!go_on(f.v[k])) return false;
      }
    }
    return true;
  }
};

/// Finds vertices that have the colour of a neighbour of higher priority. Only rings change from one colouring to the
/// next.
struct FindConflict {
  Apart apart;
  Span<const std::uint8_t> color;
  Span<std::uint8_t> lost;
  TETUNE_HD void operator()(Size v) const {
    bool conflict = false;
    if (color[v] < kMaxColors) {
      const std::uint32_t mine = priority(static_cast<Index>(v));
      apart.visit_ring(static_cast<Index>(v), [&](Index other) {
        conflict = color[other] == color[v] && priority(other) > mine;
        return !conflict;
      });
    }
    lost[v] = conflict || color[v] == kUncolored ? 1 : 0;
  }
};

struct TakeAway {
  Span<const std::uint8_t> lost;
  Span<std::uint8_t> color;
  Span<std::uint8_t> wish;
  TETUNE_HD void operator()(Size v) const {
    if (lost[v] != 0) color[v] = kUncolored;
    wish[v] = kUncolored;
  }
};

struct IsLost {
  Span<const std::uint8_t> lost;
  TETUNE_HD bool operator()(Size v) const { return lost[v] != 0; }
};

/// Each uncoloured vertex wishes for a colour that no coloured neighbour has.
struct Wish {
  Apart apart;
  Span<const Index> todo;
  Span<const std::uint8_t> color;
  Span<std::uint8_t> wish;
  std::uint32_t round;
  bool none_colored;
  TETUNE_INLINE void prefetch(Size i, Size) const { apart.prefetch(todo, i); }
  TETUNE_HD void operator()(Size i) const {
    const Index v = todo[i];
    if (color[v] != kUncolored) return;
    // Colours that are taken, in two registers: places in memory would wait for each other.
    static_assert(kMaxColors == 128);
    std::uint64_t low = 0;
    std::uint64_t high = 0;
    const auto take = [&](Index other) {
      const std::uint8_t c = color[other];
      const std::uint64_t bit = std::uint64_t{1} << (c & 63);
      low |= c < 64 ? bit : 0;
      high |= c >= 64 && c < kMaxColors ? bit : 0;
      return true;
    };
    if (!none_colored) apart.visit(v, take);
    const auto is_free = [low, high](int c) { return (((c < 64 ? low : high) >> (c & 63)) & 1) == 0; };
    int free_in_window = 0;
    for (int c = 0; c < kWindow; ++c) free_in_window += is_free(c) ? 1 : 0;
    int skip = free_in_window > 0 ? static_cast<int>(priority(static_cast<Index>(priority(v) + round)) %
                                                     static_cast<std::uint32_t>(free_in_window))
                                  : 0;
    for (int c = 0; c < kMaxColors; ++c) {
      if (is_free(c) && skip-- == 0) {
        wish[v] = static_cast<std::uint8_t>(c);
        return;
      }
    }
    wish[v] = kUncolored;
  }
};

/// A wish is granted unless a neighbour of higher priority has the same. What was granted before is no such wish: it is
/// a colour by now.
struct Grant {
  Apart apart;
  Span<const Index> todo;
  Span<const std::uint8_t> wish;
  Span<std::uint8_t> color;
  TETUNE_INLINE void prefetch(Size i, Size) const { apart.prefetch(todo, i); }
  TETUNE_HD void operator()(Size i) const {
    const Index v = todo[i];
    if (color[v] != kUncolored) return;
    const std::uint8_t mine = wish[v];
    bool granted = true;
    apart.visit(v, [&](Index other) {
      granted = wish[other] != mine || priority(other) <= priority(v);
      return granted;
    });
    if (granted) color[v] = mine;
  }
};

struct GiveUp {
  Span<const Index> todo;
  Span<std::uint8_t> color;
  TETUNE_HD void operator()(Size i) const { color[todo[i]] = kNotMovable; }
};

struct StillUncolored {
  Span<const Index> todo;
  Span<const std::uint8_t> color;
  TETUNE_HD bool operator()(Size i) const { return color[todo[i]] == kUncolored; }
};

struct Pick {
  Span<const Index> from;
  Span<const Index> positions;
  Span<Index> to;
  TETUNE_HD void operator()(Size i) const { to[i] = from[positions[i]]; }
};

struct IsMovable {
  Span<const std::uint8_t> color;
  TETUNE_HD bool operator()(Size v) const { return color[v] != kNotMovable; }
};

struct ColorOf {
  Span<const std::uint8_t> color;
  Span<const Index> vertices;
  Span<std::uint8_t> keys;
  TETUNE_HD void operator()(Size i) const { keys[i] = color[vertices[i]]; }
};

struct FindFirst {
  Span<const std::uint8_t> keys;
  Span<Index> first;
  TETUNE_HD void operator()(Size i) const {
    if (i == 0 || keys[i] != keys[i - 1]) first[keys[i]] = static_cast<Index>(i);
  }
};

}  // namespace coloring_detail

template <class Backend>
void color_vertices(const Backend& par, const RingsView& rings, Span<const Mobility> mobility,
                    Coloring<Backend>& coloring, const SurfaceStars& stars) {
  using namespace coloring_detail;
  using Bytes = typename Backend::template Buffer<std::uint8_t>;
  using Ids = typename Backend::template Buffer<Index>;
  const Size n = mobility.size();
  const bool first_time = coloring.color.size() != n;
  if (first_time) {
    coloring.color.resize(n);
    par.for_each(n, Start{mobility, stars, coloring.color.span()});
  }
  Bytes lost(n);
  Bytes wish(n);
  Ids todo(n);
  Ids rest(n);
  Ids positions(n);
  const Span<std::uint8_t> color = coloring.color.span();
  const Apart apart{rings, stars};
  par.for_each(n, FindConflict{apart, color, lost.span()});
  par.for_each(n, TakeAway{lost.span(), color, wish.span()});
  Size count = par.compact(n, IsLost{lost.span()}, todo.span());
  for (std::uint32_t round = 0; count > 0;) {
    const Span<const Index> uncolored(todo.span().data(), count);
    for (std::uint32_t turn = 0; turn < kRoundsAtOnce<Backend>; ++turn, ++round) {
      const bool none_colored = first_time && round == 0;
      par.for_each(count, Wish{apart, uncolored, color, wish.span(), round, none_colored});
      par.for_each(count, Grant{apart, uncolored, wish.span(), color});
    }
    const Size left = par.compact(count, StillUncolored{uncolored, color}, positions.span());
    if (left == count) {
      if (stars.triangles.size() == 0) throw MeshError("a vertex has too many neighbours to be coloured");
      par.for_each(count, GiveUp{uncolored, color});
      break;
    }
    par.for_each(left, Pick{uncolored, positions.span(), rest.span()});
    todo.swap(rest);
    count = left;
  }

  coloring.vertices.resize(n);
  const Size movable = par.compact(n, IsMovable{color}, coloring.vertices.span());
  coloring.vertices.resize(movable);
  Bytes keys(movable);
  par.for_each(movable, ColorOf{color, coloring.vertices.span(), keys.span()});
  par.sort_by_key(keys, coloring.vertices, 8);
  Ids first(kMaxColors);
  par.fill(first.span(), Index{-1});
  par.for_each(movable, FindFirst{keys.span(), first.span()});
  coloring.first.clear();
  for (const Index f : first.download()) {
    if (f >= 0) coloring.first.push_back(f);
  }
  coloring.first.push_back(movable);
}

}  // namespace tetune
