// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "math/hilbert.hpp"
#include "mesh/work_mesh.hpp"

/// The order of vertices and slots in memory.
namespace tetune {
namespace sort_mesh_detail {

struct Interval {
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  TETUNE_HD void merge(const Interval& other) {
    if (other.low < low) low = other.low;
    if (other.high > high) high = other.high;
  }
};

struct Bounds {
  Interval x, y, z;
  TETUNE_HD void merge(const Bounds& other) {
    x.merge(other.x);
    y.merge(other.y);
    z.merge(other.z);
  }
};

struct BoundsOfPoint {
  Span<const Point> points;
  TETUNE_HD Bounds operator()(Size i) const {
    const Point p = points[i];
    return {{p.x, p.x}, {p.y, p.y}, {p.z, p.z}};
  }
};

struct ComputeHilbertKey {
  Span<const Point> points;
  Bounds bounds;
  Span<std::uint64_t> keys;
  Span<Index> ids;
  TETUNE_HD void operator()(Size i) const {
    const Point p = points[i];
    double side = bounds.x.high - bounds.x.low;
    if (bounds.y.high - bounds.y.low > side) side = bounds.y.high - bounds.y.low;
    if (bounds.z.high - bounds.z.low > side) side = bounds.z.high - bounds.z.low;
    // The odd factor and offset keep round fractions of the box, where vertices of structured meshes lie, away from
    // cell borders: the order then does not depend on the last bit, and a rescaled mesh gets the same order.
    const double scale = side > 0 ? kOddFactor * kHilbertCells / side : 0;
    keys[i] =
        hilbert_index(cell(p.x, bounds.x.low, scale), cell(p.y, bounds.y.low, scale), cell(p.z, bounds.z.low, scale));
    ids[i] = static_cast<Index>(i);
  }
  TETUNE_HD static std::uint32_t cell(double x, double low, double scale) {
    return static_cast<std::uint32_t>((x - low) * scale + kOddOffset);
  }

 private:
  static constexpr double kOddFactor = 0.98765432109876;
  static constexpr double kOddOffset = 0.31830988618379;
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
  Span<std::uint32_t> lowest_vertex;
  Span<Index> ids;
  TETUNE_HD void operator()(Size t) const {
    Tet tet = tets[t];
    for (int k = 0; k < 4; ++k) tet[k] = original2vertex[tet[k]];
    Index lowest = tet[0];
    for (int k = 1; k < 4; ++k) lowest = tet[k] < lowest ? tet[k] : lowest;
    tets[t] = tet;
    lowest_vertex[t] = static_cast<std::uint32_t>(lowest);
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

struct IsAlive {
  Span<const Tet> tets;
  TETUNE_HD bool operator()(Size t) const { return tets[t].v[0] != kFreeSlot; }
};

/// Makes the tetrahedra those of the slots `order`, in that order.
template <class Backend>
void gather_tets(const Backend& backend, Span<const Index> order, Size room, WorkMesh<Backend>& mesh) {
  BufferOf<Backend, Tet> tets;
  BufferOf<Backend, Index> originals;
  tets.resize(backend, order.size(), room);
  originals.resize(backend, order.size(), room);
  backend.for_each(order.size(), GatherTets{mesh.tet2vertex, mesh.tet2original, order, tets, originals});
  mesh.tet2vertex.swap(tets);
  mesh.tet2original.swap(originals);
  mesh.free_count = 0;
}

}  // namespace sort_mesh_detail

/// Renumbers a freshly uploaded mesh for locality: vertices along a Hilbert curve, tetrahedra by lowest vertex.
/// Requires points and tet2vertex in the caller's order; sets vertex2original and permutes tet2original.
template <class Backend>
void sort_mesh(const Backend& backend, WorkMesh<Backend>& mesh) {
  using namespace sort_mesh_detail;
  const Size vertices = mesh.vertices();
  const Size tets = mesh.slots();

  const Bounds bounds = backend.template reduce<Bounds>(vertices, BoundsOfPoint{mesh.points});
  BufferOf<Backend, std::uint64_t> keys(backend, vertices);
  mesh.vertex2original.resize(backend, vertices);
  backend.for_each(vertices, ComputeHilbertKey{mesh.points, bounds, keys, mesh.vertex2original});
  backend.sort_by_key(keys, mesh.vertex2original, kHilbertBits);
  BufferOf<Backend, Point> points(backend, vertices);
  BufferOf<Backend, Index> original2vertex(backend, vertices);
  backend.for_each(vertices, PermutePoints{mesh.points, mesh.vertex2original, points, original2vertex});
  mesh.points.swap(points);

  BufferOf<Backend, std::uint32_t> lowest_vertex(backend, tets);
  BufferOf<Backend, Index> order(backend, tets);
  backend.for_each(tets, RelabelTet{mesh.tet2vertex, original2vertex, lowest_vertex, order});
  int bits = 1;
  while ((Size{1} << bits) < vertices) ++bits;
  backend.sort_by_key(lowest_vertex, order, bits);
  gather_tets(backend, Span<const Index>(order.span()), mesh.room(), mesh);
}

/// Removes free slots and drops tet2tet. Returns the previous slot of each tetrahedron.
template <class Backend>
BufferOf<Backend, Index> compact_slots(const Backend& backend, WorkMesh<Backend>& mesh) {
  using namespace sort_mesh_detail;
  BufferOf<Backend, Index> slots(backend, mesh.slots());
  slots.resize(backend, backend.compact(mesh.slots(), IsAlive{mesh.tet2vertex}, slots.span()));
  gather_tets(backend, Span<const Index>(slots.span()), slots.size(), mesh);
  mesh.tet2tet.resize(backend, 0);
  return slots;
}

}  // namespace tetune
