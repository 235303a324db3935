// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "core/connect.hpp"
#include "core/hilbert.hpp"

namespace tetune {
namespace connect_detail {

struct Box {
  double lo[3] = {std::numeric_limits<double>::max(), std::numeric_limits<double>::max(),
                  std::numeric_limits<double>::max()};
  double hi[3] = {std::numeric_limits<double>::lowest(), std::numeric_limits<double>::lowest(),
                  std::numeric_limits<double>::lowest()};
  TETUNE_HD void merge(const Box& other) {
    for (int k = 0; k < 3; ++k) {
      if (other.lo[k] < lo[k]) lo[k] = other.lo[k];
      if (other.hi[k] > hi[k]) hi[k] = other.hi[k];
    }
  }
};

struct PointBox {
  Span<const Point> points;
  TETUNE_HD Box operator()(Size i) const {
    const Point p = points[i];
    Box box;
    box.lo[0] = box.hi[0] = p.x;
    box.lo[1] = box.hi[1] = p.y;
    box.lo[2] = box.hi[2] = p.z;
    return box;
  }
};

struct CurveKey {
  Span<const Point> points;
  Box box;
  Span<std::uint64_t> keys;
  Span<Index> ids;
  TETUNE_HD void operator()(Size i) const {
    const Point p = points[i];
    double side = box.hi[0] - box.lo[0];
    if (box.hi[1] - box.lo[1] > side) side = box.hi[1] - box.lo[1];
    if (box.hi[2] - box.lo[2] > side) side = box.hi[2] - box.lo[2];
    // The odd factor and offset keep round fractions of the box, where meshes like to put vertices, away from
    // cell borders: the order then does not hang on the last bit, and a rescaled mesh gets the same one.
    const double scale = side > 0 ? 0.98765432109876 * kHilbertCells / side : 0;
    const std::uint32_t cell[3] = {static_cast<std::uint32_t>((p.x - box.lo[0]) * scale + 0.31830988618379),
                                   static_cast<std::uint32_t>((p.y - box.lo[1]) * scale + 0.31830988618379),
                                   static_cast<std::uint32_t>((p.z - box.lo[2]) * scale + 0.31830988618379)};
    keys[i] = hilbert_index(cell[0], cell[1], cell[2]);
    ids[i] = static_cast<Index>(i);
  }
};

struct PermutePoints {
  Span<const Point> from;
  Span<const Index> order;
  Span<Point> to;
  Span<Index> original2vertex;
  TETUNE_HD void operator()(Size i) const {
    const Index old = order[i];
    to[i] = from[old];
    original2vertex[old] = static_cast<Index>(i);
  }
};

struct RelabelTet {
  Span<Tet> tets;
  Span<const Index> original2vertex;
  Span<std::uint32_t> keys;
  Span<Index> ids;
  TETUNE_HD void operator()(Size t) const {
    Tet tet = tets[t];
    for (int k = 0; k < 4; ++k) tet[k] = original2vertex[tet[k]];
    Index lowest = tet[0];
    for (int k = 1; k < 4; ++k) lowest = tet[k] < lowest ? tet[k] : lowest;
    tets[t] = tet;
    keys[t] = static_cast<std::uint32_t>(lowest);
    ids[t] = static_cast<Index>(t);
  }
};

struct GatherTets {
  Span<const Tet> from;
  Span<const Index> from_original;
  Span<const Index> order;
  Span<Tet> to;
  Span<Index> to_original;
  TETUNE_HD void operator()(Size t) const {
    const Index old = order[t];
    to[t] = from[old];
    to_original[t] = from_original[old];
  }
};

struct FaceKey {
  Index low, middle, high;
  bool odd;  ///< parity of the permutation that sorted the vertices

  TETUNE_HD std::uint64_t pair() const {
    return (static_cast<std::uint64_t>(middle) << 32) | static_cast<std::uint32_t>(high);
  }
};

TETUNE_HD inline FaceKey face_key(const Tet& tet, int face) {
  const Index a = tet[face_vertex(face, 0)];
  const Index b = tet[face_vertex(face, 1)];
  const Index c = tet[face_vertex(face, 2)];
  const bool ab = b < a;
  const bool bc = c < b;
  const bool ac = c < a;
  const Index low_ab = ab ? b : a;
  const Index high_ab = ab ? a : b;
  const Index low = c < low_ab ? c : low_ab;
  const Index high = high_ab < c ? c : high_ab;
  return {low, a ^ b ^ c ^ low ^ high, high, (ab ^ bc ^ ac) != 0};
}

/// Notes each face once, in a set with open addressing. Where a face is looked for follows its lowest vertex, so that
/// what is near in the mesh is near there; where a vertex has too many, they go anywhere.
struct NoteFaces {
  struct Found {
    Size again = 0;
    TETUNE_HD void merge(const Found& other) { again += other.again; }
  };
  Span<const Tet> tets;
  Span<const Links> links;
  Span<std::uint32_t> notes;
  Size places;  ///< for each vertex
  static constexpr int kNear = 32;

  TETUNE_HD Found operator()(Size t) const {
    Found found;
    if (tets[t][0] == kFreeSlot) return found;
    for (int face = 0; face < 4; ++face) {
      const Link across = links[t][face];
      if (across != kNoLink && link_tet(across) < t) continue;
      const FaceKey key = face_key(tets[t], face);
      std::uint64_t hash =
          (key.pair() + 0x9e3779b97f4a7c15U * static_cast<std::uint64_t>(key.low + 1)) ^ key.pair() >> 29;
      hash *= 0xbf58476d1ce4e5b9U;
      hash ^= hash >> 31;
      const auto note = static_cast<std::uint32_t>(hash >> 32) | 1U;
      Size at = key.low * places + static_cast<Size>((hash & 0xffffffffU) * static_cast<std::uint64_t>(places) >> 32);
      for (int looks = 1;; ++looks) {
        const std::uint32_t there = par::atomic_compare_exchange(notes[at], 0, note);
        if (there == note) ++found.again;
        if (there == note || there == 0) break;
        if (looks % kNear != 0) {
          at = at + 1 < notes.size() ? at + 1 : 0;
        } else {
          hash = (hash ^ hash >> 29) * 0xbf58476d1ce4e5b9U + 0x9e3779b97f4a7c15U;
          at = static_cast<Size>((hash >> 32) * static_cast<std::uint64_t>(notes.size()) >> 32);
        }
      }
    }
    return found;
  }
};

struct LowestVertexOfFace {
  Span<const Tet> tets;
  TETUNE_HD Size operator()(Size item) const {
    const Tet tet = tets[item >> 2];
    return tet[0] == kFreeSlot ? -1 : face_key(tet, static_cast<int>(item & 3)).low;
  }
};

/// Matches the faces that share their lowest vertex.
struct MatchFaces {
  Span<const Tet> tets;
  Span<const std::uint32_t> offsets;
  Span<std::uint32_t> items;
  Span<Links> tet2tet;

  struct Less {
    Span<const Tet> tets;
    TETUNE_HD std::uint64_t key(std::uint32_t item) const {
      return face_key(tets[item >> 2], static_cast<int>(item & 3)).pair();
    }
    TETUNE_HD bool operator()(std::uint32_t a, std::uint32_t b) const {
      const std::uint64_t ka = key(a);
      const std::uint64_t kb = key(b);
      return ka != kb ? ka < kb : a < b;
    }
  };

  struct Found {
    Size boundary = 0, crowded = 0, same_side = 0;
    TETUNE_HD void merge(const Found& other) {
      boundary += other.boundary;
      crowded += other.crowded;
      same_side += other.same_side;
    }
  };

  TETUNE_HD Found operator()(Size vertex) const {
    const Size begin = offsets[vertex];
    const Size n = offsets[vertex + 1] - begin;
    std::uint32_t* row = items.data() + begin;
    constexpr Size kFew = 96;
    return n <= kFew ? match_few<kFew>(row, static_cast<int>(n)) : match_many(row, n);
  }

 private:
  /// Compares all with all, in vector code, instead of sorting.
  template <Size kMost>
  TETUNE_HD Found match_few(const std::uint32_t* row, int n) const {
    std::uint64_t keys[kMost];
    bool odd[kMost];
    for (int i = 0; i < n; ++i) {
      const FaceKey k = face_key(tets[row[i] >> 2], static_cast<int>(row[i] & 3));
      keys[i] = k.pair();
      odd[i] = k.odd;
    }
    Found found;
    for (int i = 0; i < n; ++i) {
      int same = 0;
      int other = 0;  // sum of the places: the place itself where there is one
      for (int j = 0; j < n; ++j) {
        const int equal = keys[j] == keys[i] ? 1 : 0;
        same += equal;
        other += equal * j;
      }
      other -= i;
      if (same == 2 && odd[i] != odd[other]) {
        connect(row[i], row[other]);
      } else {
        tet2tet[row[i] >> 2][static_cast<int>(row[i] & 3)] = kNoLink;
        if (same == 1) ++found.boundary;
        if (same == 2 && i < other) ++found.same_side;
        if (same > 2) ++found.crowded;
      }
    }
    return found;
  }

  TETUNE_HD Found match_many(std::uint32_t* row, Size n) const {
    const Less less{tets};
    sort_small(row, n, less);
    Found found;
    for (Size i = 0; i < n;) {
      Size end = i + 1;
      while (end < n && less.key(row[end]) == less.key(row[i])) ++end;
      if (end - i == 2 && parity(row[i]) != parity(row[i + 1])) {
        connect(row[i], row[i + 1]);
        connect(row[i + 1], row[i]);
      } else {
        for (Size j = i; j < end; ++j) tet2tet[row[j] >> 2][static_cast<int>(row[j] & 3)] = kNoLink;
        if (end - i == 1) ++found.boundary;
        if (end - i == 2) ++found.same_side;
        if (end - i > 2) found.crowded += end - i;
      }
      i = end;
    }
    return found;
  }

  TETUNE_HD bool parity(std::uint32_t item) const { return face_key(tets[item >> 2], static_cast<int>(item & 3)).odd; }
  TETUNE_HD void connect(std::uint32_t from, std::uint32_t to) const {
    tet2tet[from >> 2][static_cast<int>(from & 3)] = to;  // item and link have the same bits
  }
};

struct VertexOfCorner {
  Span<const Tet> tets;
  TETUNE_HD Size operator()(Size item) const {
    const Tet& tet = tets[item >> 2];
    return tet[0] == kFreeSlot ? -1 : tet[static_cast<int>(item & 3)];
  }
};

struct TagRange {
  int lowest = std::numeric_limits<int>::max();
  int highest = std::numeric_limits<int>::min();
  TETUNE_HD void merge(const TagRange& o) {
    lowest = o.lowest < lowest ? o.lowest : lowest;
    highest = o.highest > highest ? o.highest : highest;
  }
};
struct RangeOfTag {
  Span<const int> tags;
  TETUNE_HD TagRange operator()(Size t) const { return {tags[t], tags[t]}; }
};

/// Tags of slots.
struct GatherTags {
  Span<const int> tags;
  Span<const Index> tet2original;
  Span<int> to;
  TETUNE_HD void operator()(Size t) const { to[t] = tags[tet2original[t]]; }
};

struct LockInterface {
  MeshView mesh;
  Span<const int> tags;
  TETUNE_HD void operator()(Size t) const {
    for (int f = 0; f < 4; ++f) {
      Link& link = mesh.tet2tet[t][f];
      if (link != kNoLink && tags[link_tet(link)] != tags[t]) link |= kLocked;
    }
  }
};

struct IsAlive {
  Span<const Tet> tets;
  TETUNE_HD bool operator()(Size t) const { return tets[t].v[0] != kFreeSlot; }
};

}  // namespace connect_detail

template <class Backend>
void sort_mesh(const Backend& par, WorkMesh<Backend>& mesh) {
  using namespace connect_detail;
  const Size vertices = mesh.vertices();
  const Size tets = mesh.slots();

  const Box box = par.template reduce<Box>(vertices, PointBox{mesh.points.span()});
  typename Backend::template Buffer<std::uint64_t> curve(vertices);
  mesh.vertex2original.resize(vertices);
  par.for_each(vertices, CurveKey{mesh.points.span(), box, curve.span(), mesh.vertex2original.span()});
  par.sort_by_key(curve, mesh.vertex2original, kHilbertBits);
  typename Backend::template Buffer<Point> points(vertices);
  typename Backend::template Buffer<Index> original2vertex(vertices);
  par.for_each(vertices,
               PermutePoints{mesh.points.span(), mesh.vertex2original.span(), points.span(), original2vertex.span()});
  mesh.points.swap(points);

  typename Backend::template Buffer<std::uint32_t> lowest(tets);
  typename Backend::template Buffer<Index> order(tets);
  par.for_each(tets, RelabelTet{mesh.tet2vertex.span(), original2vertex.span(), lowest.span(), order.span()});
  int bits = 1;
  while ((Size{1} << bits) < vertices) ++bits;
  par.sort_by_key(lowest, order, bits);
  typename Backend::template Buffer<Tet> sorted;
  typename Backend::template Buffer<Index> originals;
  sorted.resize(tets, mesh.room());
  originals.resize(tets, mesh.room());
  par.for_each(tets, GatherTets{mesh.tet2vertex.span(), mesh.tet2original.span(), order.span(), sorted.span(),
                                originals.span()});
  mesh.tet2vertex.swap(sorted);
  mesh.tet2original.swap(originals);
  mesh.free_count = 0;
}

template <class Backend>
AdjacencyReport build_adjacency(const Backend& par, WorkMesh<Backend>& mesh) {
  using namespace connect_detail;
  mesh.tet2tet.resize(mesh.slots(), mesh.room());
  Rows<Backend> rows;
  build_rows(par, mesh.vertices(), 4 * mesh.slots(), LowestVertexOfFace{mesh.tet2vertex.span()}, rows);
  const auto found = par.template reduce<MatchFaces::Found>(
      mesh.vertices(), MatchFaces{mesh.tet2vertex.span(), rows.offsets.span(), rows.items.span(), mesh.tet2tet.span()});
  return {found.boundary, found.crowded, found.same_side};
}

template <class Backend>
Size count_doubled_faces(const Backend& par, WorkMesh<Backend>& mesh) {
  using namespace connect_detail;
  if (mesh.vertices() == 0) return 0;
  // No tetrahedron notes more than four faces, so that there is room; most note two, so that half of it stays free.
  const Size places = 1 + 4 * mesh.slots() / mesh.vertices();
  typename Backend::template Buffer<std::uint32_t> notes(mesh.vertices() * places);
  par.fill(notes.span(), std::uint32_t{0});
  const NoteFaces note{mesh.tet2vertex.span(), mesh.tet2tet.span(), notes.span(), places};
  return par.template reduce<NoteFaces::Found>(mesh.slots(), note).again;
}

template <class Backend>
void build_vertex2tet(const Backend& par, WorkMesh<Backend>& mesh, Rows<Backend>& vertex2tet) {
  build_rows(par, mesh.vertices(), 4 * mesh.slots(), connect_detail::VertexOfCorner{mesh.tet2vertex.span()},
             vertex2tet);
}

template <class Backend>
void lock_interfaces(const Backend& par, WorkMesh<Backend>& mesh, Span<const int> tags) {
  using namespace connect_detail;
  const auto range = par.template reduce<TagRange>(tags.size(), RangeOfTag{tags});
  if (range.lowest >= range.highest) return;
  typename Backend::template Buffer<int> of_slot(mesh.slots());
  par.for_each(mesh.slots(), GatherTags{tags, mesh.tet2original.span(), of_slot.span()});
  par.for_each(mesh.slots(), LockInterface{mesh.view(), of_slot.span()});
}

template <class Backend>
typename Backend::template Buffer<Index> compact_slots(const Backend& par, WorkMesh<Backend>& mesh) {
  using namespace connect_detail;
  typename Backend::template Buffer<Index> slots(mesh.slots());
  const Size alive = par.compact(mesh.slots(), IsAlive{mesh.tet2vertex.span()}, slots.span());
  slots.resize(alive);
  typename Backend::template Buffer<Tet> tets(alive);
  typename Backend::template Buffer<Index> originals(alive);
  par.for_each(
      alive, GatherTets{mesh.tet2vertex.span(), mesh.tet2original.span(), slots.span(), tets.span(), originals.span()});
  mesh.tet2vertex.swap(tets);
  mesh.tet2original.swap(originals);
  mesh.tet2tet.resize(0);
  mesh.free_count = 0;
  return slots;
}

}  // namespace tetune
