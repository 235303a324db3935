// SPDX-License-Identifier: Apache-2.0
#include "input_surface.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace tetune::mpi {
namespace {

/// What goes along with a vertex: triangles in so many rings around where it is, and around where it was at first. It
/// goes less than one ring far in a round.
constexpr int kRings = 2;

template <class T>
std::vector<Id> ids_of(const std::vector<T>& items, Id T::*id) {
  std::vector<Id> ids;
  ids.reserve(items.size());
  for (const T& item : items) ids.push_back(item.*id);
  return ids;
}

/// Puts a list in order, each key once; join(a, b) adds what another of the same key says.
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

/// Keeps the items i with keep(i).
template <class T, class Keep>
void filter(std::vector<T>& list, Keep keep) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (keep(i)) list[kept++] = list[i];
  }
  list.resize(kept);
}

}  // namespace

InputSurface::InputSurface(const Part& part, const Part& shell, const std::vector<int>& frozen_regions,
                           const SlideSurface& found) {
  // These have all their tetrahedra in the shell.
  const IdMap in_shell(shell.vertex_id);
  std::vector<std::uint8_t> own(shell.vertex_id.size(), 0);
  const std::vector<std::uint8_t> held = held_vertices(part.mesh, frozen_regions);
  for (std::size_t v = 0; v < held.size(); ++v) {
    const Index at = in_shell[part.vertex_id[v]];
    if (held[v] != 0 && at >= 0) own[static_cast<std::size_t>(at)] = 1;
  }
  std::vector<int> triangles(own.size(), 0);
  for (std::size_t t = 0; t < found.triangles.size(); ++t) {
    std::array<std::pair<Id, unsigned>, 3> corners;
    bool all = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(found.triangles[t][k]);
      ++triangles[v];
      all = all && own[v] != 0;
      corners[k] = {shell.vertex_id[v], found.walls[t] >> k & 1U};
    }
    if (!all) continue;
    std::sort(corners.begin(), corners.end());
    Face face{};
    for (std::size_t k = 0; k < 3; ++k) {
      face.v[k] = corners[k].first;
      face.walls |= static_cast<int>(corners[k].second << k);
    }
    faces_.push_back(face);
  }
  for (std::size_t v = 0; v < own.size(); ++v) {
    if (own[v] == 0 || found.kind[v] == Mobility::free) continue;
    SurfaceVertex vertex{shell.vertex_id[v], found.points[v], {-1, -1}, triangles[v], found.kind[v]};
    for (std::size_t way = 0; way < 2; ++way) {
      const Index next = found.line[v][way];
      if (next >= 0) vertex.line[way] = shell.vertex_id[static_cast<std::size_t>(next)];
    }
    vertices_.push_back(vertex);
    seats_.push_back({vertex.id, {vertex.id, -1, -1}});
  }
  index();
}

void InputSurface::index() {
  sort_unique(
      vertices_, [](const SurfaceVertex& v) { return v.id; }, keep_first);
  sort_unique(
      seats_, [](const Seat& s) { return s.vertex; }, keep_first);
  // One rank may see a wall where rounding hides it from another.
  sort_unique(
      faces_, [](const Face& f) { return f.v; }, [](Face& a, const Face& b) { a.walls |= b.walls; });
  vertex_at_ = IdMap(ids_of(vertices_, &SurfaceVertex::id));
  seat_at_ = IdMap(ids_of(seats_, &Seat::vertex));
  face_at_.clear();
  for (const Face& f : faces_) face_at_.push_back({vertex_at_[f.v[0]], vertex_at_[f.v[1]], vertex_at_[f.v[2]]});
}

bool InputSurface::marked(std::size_t face, const std::vector<std::uint8_t>& vertex) const {
  return std::all_of(face_at_[face].begin(), face_at_[face].end(),
                     [&vertex](Index v) { return vertex[static_cast<std::size_t>(v)] != 0; });
}

void InputSurface::mark(const Seat& seat, std::vector<std::uint8_t>& vertex) const {
  for (const Id id : {seat.vertex, seat.on[0], seat.on[1], seat.on[2]}) {
    const Index at = id < 0 ? -1 : vertex_at_[id];
    if (at >= 0) vertex[static_cast<std::size_t>(at)] = 1;
  }
}

void InputSurface::widen(std::vector<std::uint8_t>& vertex) const {
  for (int ring = 0; ring < kRings; ++ring) {
    const std::vector<std::uint8_t> before = vertex;
    for (const auto& face : face_at_) {
      std::uint8_t any = 0;
      for (const Index v : face) any |= before[static_cast<std::size_t>(v)];
      for (const Index v : face) vertex[static_cast<std::size_t>(v)] |= any;
    }
    // Some lines run inside a region.
    for (std::size_t v = 0; v < before.size(); ++v) {
      if (before[v] == 0) continue;
      for (const Id id : vertices_[v].line) {
        const Index next = id < 0 ? -1 : vertex_at_[id];
        if (next >= 0) vertex[static_cast<std::size_t>(next)] = 1;
      }
    }
  }
}

InputSurface::Piece InputSurface::under(Part& part, bool bounded, std::vector<std::uint8_t>& frozen) const {
  Piece piece;
  piece.id = part.vertex_id;
  SlideSurface& surface = piece.surface;
  TetMesh& mesh = part.mesh;
  const std::size_t count = piece.id.size();

  // What is near, and its places in the mesh.
  std::vector<std::uint8_t> near(vertices_.size(), 0);
  for (const Id id : piece.id) {
    const Index seat = seat_at_[id];
    if (seat >= 0) mark(seats_[static_cast<std::size_t>(seat)], near);
  }
  widen(near);
  const IdMap in_mesh(piece.id);
  std::vector<Index> place(vertices_.size(), -1);
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (near[i] == 0) continue;
    place[i] = in_mesh[vertices_[i].id];
    if (place[i] >= 0) continue;
    place[i] = static_cast<Index>(piece.id.size());
    piece.id.push_back(vertices_[i].id);
    mesh.points.push_back(vertices_[i].x);
    mesh.point_tags.push_back(0);
  }
  const std::size_t all = piece.id.size();
  const auto place_of = [&](Id id) {
    const Index at = id < 0 ? -1 : vertex_at_[id];
    return at < 0 ? -1 : place[static_cast<std::size_t>(at)];
  };
  frozen.resize(all, 1);
  surface.site.assign(all, kNoSite);
  for (std::size_t v = 0; v < count; ++v) {
    const Index seat = seat_at_[piece.id[v]];
    if (seat < 0) continue;
    const std::array<Id, 3>& on = seats_[static_cast<std::size_t>(seat)].on;
    for (std::size_t k = 0; k < 3; ++k) surface.site[v][k] = place_of(on[k]);
  }

  std::vector<int> here(vertices_.size(), 0);
  std::vector<int> in_tets(vertices_.size(), 0);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (!marked(f, near)) continue;
    std::array<Index, 3> triangle{};
    bool of_mesh = true;
    for (std::size_t k = 0; k < 3; ++k) {
      triangle[k] = place[static_cast<std::size_t>(face_at_[f][k])];
      of_mesh = of_mesh && static_cast<std::size_t>(triangle[k]) < count;
    }
    surface.triangles.push_back(triangle);
    surface.walls.push_back(static_cast<std::uint8_t>(faces_[f].walls));
    for (const Index i : face_at_[f]) {
      ++here[static_cast<std::size_t>(i)];
      in_tets[static_cast<std::size_t>(i)] += of_mesh ? 1 : 0;
    }
  }
  surface.points = mesh.points;
  surface.kind.assign(all, Mobility::free);
  surface.line.assign(all, {-1, -1});
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (near[i] == 0) continue;
    const SurfaceVertex& vertex = vertices_[i];
    const auto v = static_cast<std::size_t>(place[i]);
    surface.points[v] = vertex.x;
    surface.line[v] = {place_of(vertex.line[0]), place_of(vertex.line[1])};
    bool whole = here[i] == vertex.triangles;
    for (std::size_t way = 0; way < 2; ++way) whole = whole && (vertex.line[way] < 0 || surface.line[v][way] >= 0);
    surface.kind[v] = whole ? vertex.kind : Mobility::fixed;
  }
  if (bounded) {
    // The bound asks for the triangles around a vertex, and for those around their vertices.
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (!marked(f, near)) continue;
      const bool whole = std::all_of(face_at_[f].begin(), face_at_[f].end(), [&](Index i) {
        return in_tets[static_cast<std::size_t>(i)] == vertices_[static_cast<std::size_t>(i)].triangles;
      });
      if (whole) continue;
      for (const Index i : face_at_[f]) frozen[static_cast<std::size_t>(place[static_cast<std::size_t>(i)])] = 1;
    }
  }
  return piece;
}

void InputSurface::settle(const Piece& piece) {
  const auto id_of = [&piece](Index v) { return v < 0 ? Id{-1} : piece.id[static_cast<std::size_t>(v)]; };
  for (std::size_t v = 0; v < piece.id.size(); ++v) {
    const std::array<Index, 3>& site = piece.surface.site[v];
    const Index seat = seat_at_[piece.id[v]];
    if (seat < 0 || site == kNoSite) continue;
    for (std::size_t k = 0; k < 3; ++k) seats_[static_cast<std::size_t>(seat)].on[k] = id_of(site[k]);
  }
}

void InputSurface::send(MPI_Comm comm, const Addressed& leaving) {
  std::map<int, std::vector<Seat>> seats_to;
  for (std::size_t i = 0; i < leaving.vertex_to.size(); ++i) {
    const Index seat = seat_at_[leaving.pieces.vertices[i].id];
    if (seat >= 0) seats_to[leaving.vertex_to[i]].push_back(seats_[static_cast<std::size_t>(seat)]);
  }
  std::vector<SurfaceVertex> vertices;
  std::vector<Face> faces;
  std::vector<Seat> seats;
  std::vector<int> vertex_to;
  std::vector<int> face_to;
  std::vector<int> seat_to;
  for (const auto& [rank, some] : seats_to) {
    std::vector<std::uint8_t> near(vertices_.size(), 0);
    for (const Seat& seat : some) mark(seat, near);
    widen(near);
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (near[i] != 0) vertices.push_back(vertices_[i]);
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (marked(f, near)) faces.push_back(faces_[f]);
    }
    seats.insert(seats.end(), some.begin(), some.end());
    vertex_to.resize(vertices.size(), rank);
    face_to.resize(faces.size(), rank);
    seat_to.resize(seats.size(), rank);
  }
  const auto take = [](auto& list, const auto& arrived) { list.insert(list.end(), arrived.begin(), arrived.end()); };
  take(vertices_, Route(comm, vertex_to).send(vertices));
  take(faces_, Route(comm, face_to).send(faces));
  take(seats_, Route(comm, seat_to).send(seats));
  index();
}

void InputSurface::keep(const Part& part) {
  std::vector<std::uint8_t> is_here(seats_.size(), 0);
  for (const Id id : part.vertex_id) {
    const Index seat = seat_at_[id];
    if (seat >= 0) is_here[static_cast<std::size_t>(seat)] = 1;
  }
  filter(seats_, [&](std::size_t i) { return is_here[i] != 0; });
  std::vector<std::uint8_t> near(vertices_.size(), 0);
  for (const Seat& seat : seats_) mark(seat, near);
  widen(near);
  filter(faces_, [&](std::size_t f) { return marked(f, near); });
  filter(vertices_, [&](std::size_t i) { return near[i] != 0; });
  index();
}

}  // namespace tetune::mpi
