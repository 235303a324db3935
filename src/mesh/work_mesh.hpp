// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/buffer.hpp"
#include "mesh/half_face.hpp"
#include "mesh/tet.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Entries of vertex2original for a vertex that was inserted, and for one that was removed from all tetrahedra.
inline constexpr Index kInserted = -1;
inline constexpr Index kRemoved = -2;

/// The mesh as kernels access it.
struct MeshView {
  Span<Point> points;
  Span<Tet> tet2vertex;
  Span<FaceAdjacency> tet2tet;
  Span<Index> tet2original;

  TETUNE_HD bool alive(Size slot) const { return tet2vertex[slot].v[0] != kFreeSlot; }
  /// The half-face across a face.
  TETUNE_HD TETUNE_INLINE HalfFace& across(HalfFace face) const { return tet2tet[tet_of(face)][face_of(face)]; }
  /// The vertex opposite a face in its tetrahedron.
  TETUNE_HD TETUNE_INLINE Index opposite_vertex(HalfFace face) const { return tet2vertex[tet_of(face)][face_of(face)]; }
};

/// The mesh during optimization, in a backend's memory: vertices sorted along a space-filling curve, tetrahedra by
/// lowest vertex. Tetrahedra are stored in slots, which operations free and reuse.
template <class Backend>
struct WorkMesh {
  template <class T>
  using Buffer = BufferOf<Backend, T>;

  Buffer<Point> points;
  Buffer<Tet> tet2vertex;
  Buffer<FaceAdjacency> tet2tet;
  /// Slot -> the caller's tetrahedron from which the one in the slot descends. Both are in the same region, because the
  /// interfaces between regions are locked.
  Buffer<Index> tet2original;
  /// Work vertex -> caller's vertex, kInserted or kRemoved.
  Buffer<Index> vertex2original;
  /// The free slots: the first `free_count` entries.
  Buffer<Index> free_slots;
  Size free_count = 0;

  Size vertices() const { return points.size(); }
  Size slots() const { return tet2vertex.size(); }
  Size tets() const { return slots() - free_count; }
  /// Capacity to reserve per slot array: operations seldom take more additional slots.
  Size room() const { return slots() + slots() / 16; }
  MeshView view() { return {points.span(), tet2vertex.span(), tet2tet.span(), tet2original.span()}; }
};

namespace work_mesh_detail {

struct ScalePoint {
  Span<const double> coordinates;  ///< x, y, z of each point
  double scale;
  Span<Point> points;
  TETUNE_HD void operator()(Size v) const {
    points[v] = point(scale * Vec3{coordinates[3 * v], coordinates[3 * v + 1], coordinates[3 * v + 2]});
  }
};

struct Enumerate {
  Span<Index> ids;
  TETUNE_HD void operator()(Size i) const { ids[i] = Index(i); }
};

}  // namespace work_mesh_detail

/// Uploads points, multiplied by `scale`, and tetrahedra in the caller's order. Requires indices in range.
template <class Backend>
WorkMesh<Backend> upload_mesh(const Backend& backend, const TetMesh& mesh, double scale = 1) {
  WorkMesh<Backend> work;
  const DeviceViewOf<Backend, Point3> points(backend, mesh.points);
  work.points.resize(backend, std::ssize(mesh.points));
  const Span<const double> coordinates{reinterpret_cast<const double*>(points.span().data()), 3 * points.span().size()};
  backend.for_each(work.points.size(), work_mesh_detail::ScalePoint{coordinates, scale, work.points});
  static_assert(sizeof(Tet) == sizeof(mesh.tets[0]));
  work.tet2vertex.resize(backend, std::ssize(mesh.tets));
  backend.memory().upload(work.tet2vertex.span().data(), mesh.tets.data(), mesh.tets.size() * sizeof(Tet));
  work.tet2original.resize(backend, std::ssize(mesh.tets));
  backend.for_each(work.tet2original.size(), work_mesh_detail::Enumerate{work.tet2original});
  return work;
}

}  // namespace tetune
