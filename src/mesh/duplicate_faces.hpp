// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/atomic.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {
namespace duplicate_faces_detail {

/// A hash set of faces with open addressing that stores a 32-bit fingerprint per face. The first probe depends on the
/// lowest vertex of the face, so that faces that are close in the mesh are close in the table; after each kNearProbes
/// consecutive collisions, probing continues at a random bucket.
struct FaceHashSet {
  Span<std::uint32_t> buckets;  ///< 0: empty
  std::uint64_t buckets_per_vertex;

  static constexpr int kNearProbes = 32;
  static constexpr std::uint64_t kIncrement = 0x9e3779b97f4a7c15U;
  static constexpr std::uint64_t kMultiplier = 0xbf58476d1ce4e5b9U;

  /// Returns false if the face is in the set already.
  TETUNE_HD bool insert(const FaceKey& key) const {
    const auto low = static_cast<std::uint64_t>(key.low);
    std::uint64_t hash = (key.pair() + kIncrement * (low + 1)) ^ key.pair() >> 29;
    hash *= kMultiplier;
    hash ^= hash >> 31;
    const auto fingerprint = static_cast<std::uint32_t>(hash >> 32) | 1U;
    const auto size = static_cast<std::uint64_t>(buckets.size());
    std::uint64_t bucket = low * buckets_per_vertex + ((hash & 0xffffffffU) * buckets_per_vertex >> 32);
    for (int probes = 1;; ++probes) {
      const std::uint32_t found = backend::atomic_compare_exchange(buckets[static_cast<Size>(bucket)], 0, fingerprint);
      if (found == 0) return true;
      if (found == fingerprint) return false;
      if (probes % kNearProbes != 0) {
        bucket = bucket + 1 < size ? bucket + 1 : 0;
      } else {
        hash = (hash ^ hash >> 29) * kMultiplier + kIncrement;
        bucket = (hash >> 32) * size >> 32;
      }
    }
  }
};

/// Inserts the faces of one tetrahedron, each face of the mesh once.
struct InsertFaces {
  Span<const Tet> tets;
  Span<const FaceAdjacency> tet2tet;
  FaceHashSet faces;
  TETUNE_HD Sum<Size> operator()(Size t) const {
    Sum<Size> duplicates;
    if (tets[t][0] == kFreeSlot) return duplicates;
    for (int face = 0; face < 4; ++face) {
      const HalfFace across = tet2tet[t][face];
      if (across != kNoHalfFace && tet_of(across) < t) continue;
      if (!faces.insert(face_key(tets[t], face))) ++duplicates.value;
    }
    return duplicates;
  }
};

}  // namespace duplicate_faces_detail

/// Counts the faces that seem to have the same three vertices as another face, as flips create them in a mesh that
/// overlaps itself. A result of 0 is exact; any other may be due to a hash collision and has to be verified. Requires
/// tet2tet.
template <class Backend>
Size count_duplicate_faces(const Backend& backend, WorkMesh<Backend>& mesh) {
  using namespace duplicate_faces_detail;
  if (mesh.vertices() == 0) return 0;
  // A tetrahedron inserts at most four faces, so that the table cannot overflow, and two on average, so that half of it
  // stays empty.
  const Size buckets_per_vertex = 1 + 4 * mesh.slots() / mesh.vertices();
  BufferOf<Backend, std::uint32_t> buckets(backend, mesh.vertices() * buckets_per_vertex);
  backend.fill(buckets.span(), std::uint32_t{0});
  const FaceHashSet faces{buckets.span(), static_cast<std::uint64_t>(buckets_per_vertex)};
  const InsertFaces insert{mesh.tet2vertex.span(), mesh.tet2tet.span(), faces};
  return backend.template reduce<Sum<Size>>(mesh.slots(), insert).value;
}

}  // namespace tetune
