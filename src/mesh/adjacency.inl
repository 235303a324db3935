// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "mesh/connect.hpp"
#include "mesh/corners.hpp"

/// Adjacency of tetrahedra across faces, and locked faces.
namespace tetune {
namespace adjacency_detail {

struct LowestVertexOfFace {
  Span<const Tet> tets;
  TETUNE_HD Size operator()(Size item) const {
    const auto half_face = static_cast<HalfFace>(item);
    const Tet tet = tets[tet_of(half_face)];
    return tet[0] == kFreeSlot ? -1 : face_key(tet, face_of(half_face)).low;
  }
};

/// Matches the half-faces in the row of one vertex: those whose lowest vertex it is.
struct MatchFaces {
  Span<const Tet> tets;
  Span<const std::uint32_t> offsets;
  Span<HalfFace> items;
  Span<FaceAdjacency> tet2tet;

  struct FaceLess {
    Span<const Tet> tets;
    TETUNE_HD std::uint64_t key(HalfFace item) const { return face_key(tets[tet_of(item)], face_of(item)).pair(); }
    TETUNE_HD bool operator()(HalfFace a, HalfFace b) const {
      const std::uint64_t key_a = key(a);
      const std::uint64_t key_b = key(b);
      return key_a != key_b ? key_a < key_b : a < b;
    }
  };

  TETUNE_HD AdjacencyReport operator()(Size vertex) const {
    const Size begin = offsets[vertex];
    const Size n = offsets[vertex + 1] - begin;
    HalfFace* row = items.data() + begin;
    constexpr Size kMaxCompared = 96;
    return n <= kMaxCompared ? match_by_comparison<kMaxCompared>(row, static_cast<int>(n)) : match_by_sorting(row, n);
  }

 private:
  /// Compares all pairs in vector code: for short rows faster than sorting.
  template <Size kMaxRow>
  TETUNE_HD AdjacencyReport match_by_comparison(const HalfFace* row, int n) const {
    std::uint64_t keys[kMaxRow];
    bool odd[kMaxRow];
    for (int i = 0; i < n; ++i) {
      const FaceKey k = face_key(tets[tet_of(row[i])], face_of(row[i]));
      keys[i] = k.pair();
      odd[i] = k.odd;
    }
    AdjacencyReport report;
    for (int i = 0; i < n; ++i) {
      int equal_count = 0;
      int other = 0;  // sum of the positions of equal keys, minus i: the position of the other one if there are two
      for (int j = 0; j < n; ++j) {
        const int equal = keys[j] == keys[i] ? 1 : 0;
        equal_count += equal;
        other += equal * j;
      }
      other -= i;
      if (equal_count == 2 && odd[i] != odd[other]) {
        across(row[i]) = row[other];
      } else {
        across(row[i]) = kNoHalfFace;
        if (equal_count == 2 && i < other) ++report.misoriented_faces;
        if (equal_count > 2) ++report.non_manifold_faces;
      }
    }
    return report;
  }

  TETUNE_HD AdjacencyReport match_by_sorting(HalfFace* row, Size n) const {
    const FaceLess less{tets};
    sort_small(row, n, less);
    AdjacencyReport report;
    for (Size i = 0; i < n;) {
      Size end = i + 1;
      while (end < n && less.key(row[end]) == less.key(row[i])) ++end;
      if (end - i == 2 && is_odd(row[i]) != is_odd(row[i + 1])) {
        across(row[i]) = row[i + 1];
        across(row[i + 1]) = row[i];
      } else {
        for (Size j = i; j < end; ++j) across(row[j]) = kNoHalfFace;
        if (end - i == 2) ++report.misoriented_faces;
        if (end - i > 2) report.non_manifold_faces += end - i;
      }
      i = end;
    }
    return report;
  }

  TETUNE_HD bool is_odd(HalfFace item) const { return face_key(tets[tet_of(item)], face_of(item)).odd; }
  TETUNE_HD HalfFace& across(HalfFace item) const { return tet2tet[tet_of(item)][face_of(item)]; }
};

struct TagRange {
  int min = std::numeric_limits<int>::max();
  int max = std::numeric_limits<int>::min();
  TETUNE_HD void merge(const TagRange& other) {
    min = other.min < min ? other.min : min;
    max = other.max > max ? other.max : max;
  }
};
struct FindTagRange {
  Span<const int> tags;
  TETUNE_HD TagRange operator()(Size t) const { return {tags[t], tags[t]}; }
};

struct GatherTags {
  Span<const int> tags;
  Span<const Index> tet2original;
  Span<int> slot_tags;
  TETUNE_HD void operator()(Size t) const { slot_tags[t] = tags[tet2original[t]]; }
};

struct LockInterface {
  MeshView mesh;
  Span<const int> slot_tags;
  TETUNE_HD void operator()(Size t) const {
    for (int f = 0; f < 4; ++f) {
      HalfFace& across = mesh.tet2tet[t][f];
      if (across != kNoHalfFace && slot_tags[tet_of(across)] != slot_tags[t]) across |= kLocked;
    }
  }
};

}  // namespace adjacency_detail

template <class Backend>
AdjacencyReport build_adjacency(const Backend& backend, WorkMesh<Backend>& mesh) {
  using namespace adjacency_detail;
  mesh.tet2tet.resize(backend, mesh.slots(), mesh.room());
  Csr<Backend> rows;
  build_csr(backend, mesh.vertices(), 4 * mesh.slots(), LowestVertexOfFace{mesh.tet2vertex.span()}, rows);
  return backend.template reduce<AdjacencyReport>(
      mesh.vertices(), MatchFaces{mesh.tet2vertex.span(), rows.offsets.span(), rows.items.span(), mesh.tet2tet.span()});
}

template <class Backend>
void build_vertex2tet(const Backend& backend, WorkMesh<Backend>& mesh, Csr<Backend>& vertex2tet) {
  build_csr(backend, mesh.vertices(), 4 * mesh.slots(), VertexOfCorner{mesh.tet2vertex.span()}, vertex2tet);
}

template <class Backend>
void lock_interfaces(const Backend& backend, WorkMesh<Backend>& mesh, Span<const int> tags) {
  using namespace adjacency_detail;
  const auto range = backend.template reduce<TagRange>(tags.size(), FindTagRange{tags});
  if (range.min >= range.max) return;
  typename Backend::template Buffer<int> slot_tags(backend, mesh.slots());
  backend.for_each(mesh.slots(), GatherTags{tags, mesh.tet2original.span(), slot_tags.span()});
  backend.for_each(mesh.slots(), LockInterface{mesh.view(), slot_tags.span()});
}

}  // namespace tetune
