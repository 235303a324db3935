// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mesh/csr.hpp"
#include "mesh/work_mesh.hpp"

/// Adjacency of tetrahedra across faces, and locked faces.
namespace tetune {

/// Maps corner 4 * tet + k to its vertex, or to -1 in a free slot: a row function for build_csr().
struct VertexOfTetCorner {
  Span<const Tet> tets;
  TETUNE_HD Size operator()(Size item) const {
    const auto corner = static_cast<HalfFace>(item);
    const Tet& tet = tets[tet_of(corner)];
    return tet[0] == kFreeSlot ? -1 : tet[face_of(corner)];
  }
};

/// Defects found by build_adjacency(); a valid mesh has none.
struct AdjacencyReport {
  Size non_manifold_faces = 0;  ///< half-faces of faces that three or more tetrahedra share
  Size misoriented_faces = 0;   ///< faces whose two tetrahedra lie on the same side

  bool ok() const { return non_manifold_faces + misoriented_faces == 0; }
  TETUNE_HD void merge(const AdjacencyReport& other) {
    non_manifold_faces += other.non_manifold_faces;
    misoriented_faces += other.misoriented_faces;
  }
};

namespace adjacency_detail {

struct LowestVertexOfFace {
  Span<const Tet> tets;
  TETUNE_HD Size operator()(Size item) const {
    const auto half_face = static_cast<HalfFace>(item);
    const Tet tet = tets[tet_of(half_face)];
    return tet[0] == kFreeSlot ? -1 : face_key(tet, face_of(half_face)).low;
  }
};

/// On a device each half-face is compared with all of its row. A hash of the other two vertices divides the half-faces
/// of a lowest vertex, so that rows are short.
struct BucketOfFace {
  static constexpr int kBucketBits = 3;
  static constexpr Size kBuckets = Size{1} << kBucketBits;
  Span<const Tet> tets;
  TETUNE_HD Size operator()(Size item) const {
    const HalfFace half_face{std::uint32_t(item)};
    const Tet tet = tets[tet_of(half_face)];
    return tet[0] == kFreeSlot ? -1 : of(face_key(tet, face_of(half_face)));
  }
  TETUNE_HD static Size of(const FaceKey& key) {
    constexpr std::uint32_t kMultiplier = 0x9e3779b1;
    const std::uint32_t hash = (std::uint32_t(key.middle) * kMultiplier + std::uint32_t(key.high)) * kMultiplier;
    return kBuckets * key.low + (hash >> (32 - kBucketBits));
  }
};

/// Matches the half-faces in the row of one vertex, those whose lowest vertex it is: on the CPU.
struct MatchFaces {
  Span<const Tet> tets;
  Span<const std::uint32_t> offsets;
  Span<HalfFace> items;
  Span<FaceAdjacency> tet2tet;

  struct FaceLess {
    Span<const Tet> tets;
    std::uint64_t key(HalfFace item) const { return face_key(tets[tet_of(item)], face_of(item)).pair(); }
    bool operator()(HalfFace a, HalfFace b) const {
      const std::uint64_t key_a = key(a);
      const std::uint64_t key_b = key(b);
      return key_a != key_b ? key_a < key_b : a < b;
    }
  };

  AdjacencyReport operator()(Size vertex) const {
    const Size begin = offsets[vertex];
    const Size n = offsets[vertex + 1] - begin;
    HalfFace* row = items.data() + begin;
    constexpr Size kMaxCompared = 96;
    return n <= kMaxCompared ? match_by_comparison<kMaxCompared>(row, static_cast<int>(n)) : match_by_sorting(row, n);
  }

 private:
  /// Compares all pairs in vector code: for short rows faster than sorting.
  template <Size kMaxRow>
  AdjacencyReport match_by_comparison(const HalfFace* row, int n) const {
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

  AdjacencyReport match_by_sorting(HalfFace* row, Size n) const {
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

  bool is_odd(HalfFace item) const { return face_key(tets[tet_of(item)], face_of(item)).odd; }
  HalfFace& across(HalfFace item) const { return tet2tet[tet_of(item)][face_of(item)]; }
};

/// A half-face, and the exclusive or of its vertices: few faces with the same lowest vertex have the same one.
struct alignas(8) FaceInRow {
  HalfFace face;
  Index combined;
};
struct MakeFaceInRow {
  Span<const Tet> tets;
  TETUNE_HD FaceInRow operator()(HalfFace face) const {
    const Tet tet = tets[tet_of(face)];
    Index combined = 0;
    for (int k = 0; k < 4; ++k) combined ^= k == face_of(face) ? 0 : tet[k];
    return {face, combined};
  }
};

/// Matches one half-face with those in its row: on a device, where the threads of the longest rows would have the
/// longest chains of instructions of all kernels.
struct MatchFace {
  Span<const Tet> tets;
  Span<const std::uint32_t> offsets;
  Span<const FaceInRow> items;
  Span<FaceAdjacency> tet2tet;

  TETUNE_HD AdjacencyReport operator()(Size i) const {
    const auto face = static_cast<HalfFace>(i);
    const Tet tet = tets[tet_of(face)];
    if (tet[0] == kFreeSlot) return {};
    const FaceKey key = face_key(tet, face_of(face));
    const Index combined = MakeFaceInRow{tets}(face).combined;
    HalfFace other = kNoHalfFace;
    int others = 0;
    const Size row = BucketOfFace::of(key);
    for (Size r = offsets[row]; r < offsets[row + 1]; ++r) {
      const FaceInRow candidate = items[r];
      if (candidate.combined != combined || candidate.face == face) continue;
      if (key_of(candidate.face).pair() != key.pair()) continue;
      ++others;
      other = candidate.face;
    }
    const bool is_opposite = others == 1 && key_of(other).odd != key.odd;
    tet2tet[tet_of(face)][face_of(face)] = is_opposite ? other : kNoHalfFace;
    AdjacencyReport report;
    if (others == 1 && !is_opposite && face < other) ++report.misoriented_faces;
    if (others > 1) ++report.non_manifold_faces;
    return report;
  }

 private:
  TETUNE_HD FaceKey key_of(HalfFace face) const { return face_key(tets[tet_of(face)], face_of(face)); }
};

struct LockInterface {
  MeshView mesh;
  Span<const int> tags;
  TETUNE_HD int tag(Size t) const { return tags[mesh.tet2original[t]]; }
  TETUNE_HD void operator()(Size t) const {
    for (int f = 0; f < 4; ++f) {
      HalfFace& across = mesh.tet2tet[t][f];
      if (across != kNoHalfFace && tag(tet_of(across)) != tag(t)) across |= kLocked;
    }
  }
};

}  // namespace adjacency_detail

/// Computes tet2tet. A face that is non-manifold or misoriented is left as boundary and counted.
template <class Backend>
AdjacencyReport build_adjacency(const Backend& backend, WorkMesh<Backend>& mesh) {
  using namespace adjacency_detail;
  mesh.tet2tet.resize(backend, mesh.slots(), mesh.room());
  if constexpr (Backend::kIsAsynchronous) {
    BufferOf<Backend, std::uint32_t> offsets;
    BufferOf<Backend, FaceInRow> items;
    build_unordered_rows<Backend, BucketOfFace, MakeFaceInRow, FaceInRow>(
        backend,
        {.rows = BucketOfFace::kBuckets * mesh.vertices(),
         .items = 4 * mesh.slots(),
         .row_of = {mesh.tet2vertex},
         .make = {mesh.tet2vertex}},
        offsets, items);
    return backend.template reduce<AdjacencyReport>(4 * mesh.slots(),
                                                    MatchFace{mesh.tet2vertex, offsets, items, mesh.tet2tet});
  } else {
    Csr<Backend> rows;
    build_csr(backend, mesh.vertices(), 4 * mesh.slots(), LowestVertexOfFace{mesh.tet2vertex}, rows);
    return backend.template reduce<AdjacencyReport>(
        mesh.vertices(), MatchFaces{mesh.tet2vertex, rows.offsets, rows.items, mesh.tet2tet});
  }
}

/// The corners at each vertex: items are 4 * tet + local vertex.
template <class Backend>
void build_vertex2tet(const Backend& backend, WorkMesh<Backend>& mesh, Csr<Backend>& vertex2tet) {
  build_csr(backend, mesh.vertices(), 4 * mesh.slots(), VertexOfTetCorner{mesh.tet2vertex}, vertex2tet);
}

/// Locks the faces between tetrahedra of different tags. `tags` holds one tag per tetrahedron of the caller.
template <class Backend>
void lock_interfaces(const Backend& backend, WorkMesh<Backend>& mesh, Span<const int> tags) {
  using namespace adjacency_detail;
  backend.for_each(mesh.slots(), LockInterface{mesh.view(), tags});
}

}  // namespace tetune
