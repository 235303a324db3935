// SPDX-License-Identifier: Apache-2.0
#include "input_surface.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace tetune::mpi {
namespace {

/// The triangles that are sent with a vertex: those within this number of rings of its surface point, of that in the
/// checked surface, and of its initial position. A vertex moves by less than one ring per round.
constexpr int kRings = 2;

template <class T>
std::vector<Id> ids_of(const std::vector<T>& items, Id T::*id) {
  std::vector<Id> ids;
  ids.reserve(items.size());
  for (const T& item : items) ids.push_back(item.*id);
  return ids;
}

/// Sorts a list by key and keeps one item per key; join(a, b) merges b, an item with the same key, into a.
template <class T, class Key, class Join>
void sort_unique(std::vector<T>& list, Key key, Join join) {
  std::stable_sort(list.begin(), list.end(), [&key](const T& a, const T& b) { return key(a) < key(b); });
  std::size_t last = 0;
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (key(list[i]) == key(list[last])) {
      join(list[last], list[i]);
    } else {
      list[++last] = list[i];
    }
  }
  if (!list.empty()) list.resize(last + 1);
}
constexpr auto keep_first = [](auto&, const auto&) {};

/// Keeps the items i for which keep(i) is true.
template <class T, class Predicate>
void filter(std::vector<T>& list, Predicate keep) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (keep(i)) list[count++] = list[i];
  }
  list.resize(count);
}

}  // namespace

InputSurface::InputSurface(const Part& part, const Part& halo, const std::vector<int>& frozen_regions,
                           const SlideSurface& found) {
  // The halo has all tetrahedra of these vertices.
  const IdMap in_halo(halo.vertex_id);
  Marks own(halo.vertex_id.size(), 0);
  const Marks held = held_vertices(part.mesh, frozen_regions);
  for (std::size_t v = 0; v < held.size(); ++v) {
    const Index at = in_halo[part.vertex_id[v]];
    if (held[v] != 0 && at >= 0) item(own, at) = 1;
  }
  std::vector<int> triangles(own.size(), 0);
  for (std::size_t t = 0; t < found.triangles.size(); ++t) {
    std::array<std::pair<Id, unsigned>, 3> corners;
    bool all = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t v(found.triangles[t][k]);
      ++triangles[v];
      all = all && own[v] != 0;
      corners[k] = {halo.vertex_id[v], found.feature_edges[t] >> k & 1U};
    }
    if (!all) continue;
    std::sort(corners.begin(), corners.end());
    Face face{};
    for (std::size_t k = 0; k < 3; ++k) {
      face.v[k] = corners[k].first;
      face.feature_edges |= int(corners[k].second << k);
    }
    faces_.push_back(face);
  }
  for (std::size_t v = 0; v < own.size(); ++v) {
    if (own[v] == 0 || found.dof[v] == VertexDof::free) continue;
    SurfaceVertex vertex{halo.vertex_id[v], found.points[v], {-1, -1}, triangles[v], found.dof[v]};
    for (std::size_t side = 0; side < 2; ++side) {
      const Index next = found.line[v][side];
      if (next >= 0) vertex.line[side] = item(halo.vertex_id, next);
    }
    vertices_.push_back(vertex);
    surface_points_.push_back({vertex.id, {vertex.id, -1, -1}, {vertex.id, -1, -1}, vertex.x});
  }
  index();
}

void InputSurface::index() {
  sort_unique(
      vertices_, [](const SurfaceVertex& v) { return v.id; }, keep_first);
  sort_unique(
      surface_points_, [](const SurfacePoint& p) { return p.vertex; }, keep_first);
  // Because of rounding one rank may find a feature edge that another does not.
  sort_unique(
      faces_, [](const Face& f) { return f.v; }, [](Face& a, const Face& b) { a.feature_edges |= b.feature_edges; });
  vertex_at_ = IdMap(ids_of(vertices_, &SurfaceVertex::id));
  point_at_ = IdMap(ids_of(surface_points_, &SurfacePoint::vertex));
  face_at_.clear();
  for (const Face& f : faces_) face_at_.push_back({vertex_at_[f.v[0]], vertex_at_[f.v[1]], vertex_at_[f.v[2]]});
}

bool InputSurface::marked(std::size_t face, const Marks& vertex) const {
  return std::all_of(face_at_[face].begin(), face_at_[face].end(), [&vertex](Index v) { return item(vertex, v) != 0; });
}

void InputSurface::mark(const SurfacePoint& point, Marks& vertex) const {
  for (const Id id : {point.vertex, point.on[0], point.on[1], point.on[2], point.checked_on[0], point.checked_on[1],
                      point.checked_on[2]}) {
    const Index at = id < 0 ? -1 : vertex_at_[id];
    if (at >= 0) item(vertex, at) = 1;
  }
}

void InputSurface::widen(Marks& vertex) const {
  for (int ring = 0; ring < kRings; ++ring) {
    const Marks before = vertex;
    for (const auto& face : face_at_) {
      std::uint8_t any = 0;
      for (const Index v : face) any |= item(before, v);
      for (const Index v : face) item(vertex, v) |= any;
    }
    // Feature lines inside a region have no triangles.
    for (std::size_t v = 0; v < before.size(); ++v) {
      if (before[v] == 0) continue;
      for (const Id id : vertices_[v].line) {
        const Index next = id < 0 ? -1 : vertex_at_[id];
        if (next >= 0) item(vertex, next) = 1;
      }
    }
  }
}

/// Appends vertices of the surface that the part lacks; returns the position of each marked one in the mesh.
std::vector<Index> InputSurface::append_vertices(const Marks& near, Piece& piece, TetMesh& mesh) const {
  const IdMap in_mesh(piece.id);
  std::vector<Index> position(vertices_.size(), -1);
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (near[i] == 0) continue;
    position[i] = in_mesh[vertices_[i].id];
    if (position[i] >= 0) continue;
    position[i] = index_count(piece.id);
    piece.id.push_back(vertices_[i].id);
    mesh.points.push_back(vertices_[i].x);
    mesh.point_tags.push_back(0);
  }
  return position;
}

/// The entry of a vertex of the surface in a list of positions, or -1 where it has none.
Index InputSurface::position_of(Id id, const std::vector<Index>& position) const {
  const Index at = id < 0 ? -1 : vertex_at_[id];
  return at < 0 ? -1 : item(position, at);
}

/// Sets the degrees of freedom of the surface's vertices: one whose triangles or line are not all here is fixed.
void InputSurface::set_vertices(const Marks& near, const std::vector<Index>& position,
                                const std::vector<int>& triangles_here, SlideSurface& surface) const {
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (near[i] == 0) continue;
    const SurfaceVertex& vertex = vertices_[i];
    const std::array<Index, 2> line{position_of(vertex.line[0], position), position_of(vertex.line[1], position)};
    bool is_complete = triangles_here[i] == vertex.triangles;
    for (std::size_t side = 0; side < 2; ++side)
      is_complete = is_complete && (vertex.line[side] < 0 || line[side] >= 0);
    item(surface.points, position[i]) = vertex.x;
    item(surface.line, position[i]) = line;
    item(surface.dof, position[i]) = is_complete ? vertex.dof : VertexDof::fixed;
  }
}

InputSurface::Piece InputSurface::under(Part& part, bool bounded, Marks& frozen) const {
  Piece piece;
  piece.id = part.vertex_id;
  SlideSurface& surface = piece.surface;
  const std::size_t count = piece.id.size();
  Marks near(vertices_.size(), 0);
  for (const Id id : piece.id) {
    const Index point = point_at_[id];
    if (point >= 0) mark(item(surface_points_, point), near);
  }
  widen(near);
  const std::vector<Index> position = append_vertices(near, piece, part.mesh);
  frozen.resize(piece.id.size(), 1);
  surface.surface_point.assign(piece.id.size(), kNoSurfacePoint);
  if (bounded) {
    surface.checked_surface_point = surface.surface_point;
    surface.checked_points = part.mesh.points;
  }
  for (std::size_t v = 0; v < count; ++v) {
    const Index at = point_at_[piece.id[v]];
    if (at < 0) continue;
    const SurfacePoint& point = item(surface_points_, at);
    for (std::size_t k = 0; k < 3; ++k) surface.surface_point[v][k] = position_of(point.on[k], position);
    if (!bounded) continue;
    for (std::size_t k = 0; k < 3; ++k)
      surface.checked_surface_point[v][k] = position_of(point.checked_on[k], position);
    surface.checked_points[v] = point.checked;
  }

  std::vector<int> triangles_here(vertices_.size(), 0);
  std::vector<int> triangles_of_part(vertices_.size(), 0);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (!marked(f, near)) continue;
    std::array<Index, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) triangle[k] = item(position, face_at_[f][k]);
    const bool of_part = std::all_of(triangle.begin(), triangle.end(), [&](Index v) { return v < to_index(count); });
    surface.triangles.push_back(triangle);
    surface.feature_edges.push_back(std::uint8_t(faces_[f].feature_edges));
    for (const Index i : face_at_[f]) {
      ++item(triangles_here, i);
      item(triangles_of_part, i) += of_part ? 1 : 0;
    }
  }
  surface.points = part.mesh.points;
  surface.dof.assign(piece.id.size(), VertexDof::free);
  surface.line.assign(piece.id.size(), {-1, -1});
  set_vertices(near, position, triangles_here, surface);
  if (!bounded) return piece;
  // The bound depends on the triangles of a vertex and on those of their vertices.
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (!marked(f, near)) continue;
    const bool is_complete = std::all_of(face_at_[f].begin(), face_at_[f].end(), [&](Index i) {
      return item(triangles_of_part, i) == item(vertices_, i).triangles;
    });
    if (is_complete) continue;
    for (const Index i : face_at_[f]) item(frozen, item(position, i)) = 1;
  }
  return piece;
}

void InputSurface::write_back(const Piece& piece) {
  const auto id_of = [&piece](Index v) { return v < 0 ? Id{-1} : item(piece.id, v); };
  for (std::size_t v = 0; v < piece.id.size(); ++v) {
    const std::array<Index, 3>& on = piece.surface.surface_point[v];
    const Index point = point_at_[piece.id[v]];
    if (point < 0 || on == kNoSurfacePoint) continue;
    SurfacePoint& stored = item(surface_points_, point);
    for (std::size_t k = 0; k < 3; ++k) stored.on[k] = id_of(on[k]);
    if (piece.surface.checked_points.empty()) continue;
    stored.checked = piece.surface.checked_points[v];
    for (std::size_t k = 0; k < 3; ++k) stored.checked_on[k] = id_of(piece.surface.checked_surface_point[v][k]);
  }
}

void InputSurface::send(MPI_Comm comm, const Addressed& leaving) {
  std::map<int, std::vector<SurfacePoint>> points_to;
  for (std::size_t i = 0; i < leaving.vertex_to.size(); ++i) {
    const Index point = point_at_[leaving.pieces.vertices[i].id];
    if (point >= 0) points_to[leaving.vertex_to[i]].push_back(item(surface_points_, point));
  }
  std::vector<SurfaceVertex> vertices;
  std::vector<Face> faces;
  std::vector<SurfacePoint> points;
  std::vector<int> vertex_to;
  std::vector<int> face_to;
  std::vector<int> point_to;
  for (const auto& [rank, some] : points_to) {
    Marks near(vertices_.size(), 0);
    for (const SurfacePoint& point : some) mark(point, near);
    widen(near);
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (near[i] != 0) vertices.push_back(vertices_[i]);
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (marked(f, near)) faces.push_back(faces_[f]);
    }
    points.insert(points.end(), some.begin(), some.end());
    vertex_to.resize(vertices.size(), rank);
    face_to.resize(faces.size(), rank);
    point_to.resize(points.size(), rank);
  }
  const auto take = [](auto& list, const auto& arrived) { list.insert(list.end(), arrived.begin(), arrived.end()); };
  take(vertices_, Route(comm, vertex_to).send(vertices));
  take(faces_, Route(comm, face_to).send(faces));
  take(surface_points_, Route(comm, point_to).send(points));
  index();
}

void InputSurface::keep(const Part& part) {
  Marks is_here(surface_points_.size(), 0);
  for (const Id id : part.vertex_id) {
    const Index point = point_at_[id];
    if (point >= 0) item(is_here, point) = 1;
  }
  filter(surface_points_, [&](std::size_t i) { return is_here[i] != 0; });
  Marks near(vertices_.size(), 0);
  for (const SurfacePoint& point : surface_points_) mark(point, near);
  widen(near);
  filter(faces_, [&](std::size_t f) { return marked(f, near); });
  filter(vertices_, [&](std::size_t i) { return near[i] != 0; });
  index();
}

}  // namespace tetune::mpi
