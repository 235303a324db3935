// SPDX-License-Identifier: Apache-2.0
#include "part.hpp"

#include <algorithm>
#include <utility>

#include "lookup.hpp"

namespace tetune::mpi {
namespace {

template <class T>
void sort_unique(std::vector<T>& items) {
  // A stable sort keeps the copy of the lowest rank.
  std::stable_sort(items.begin(), items.end(), [](const T& a, const T& b) { return a.id < b.id; });
  items.erase(std::unique(items.begin(), items.end(), [](const T& a, const T& b) { return a.id == b.id; }),
              items.end());
}

/// The arrays of a part for one kind of elements.
template <std::size_t N>
struct Arrays {
  std::vector<std::array<Index, N>>& list;
  std::vector<int>& tags;
  std::vector<Id>& ids;
  std::vector<Index>& required;
  std::vector<Index>* ridges = nullptr;  ///< of edges
};

template <std::size_t N>
void add_elements(const std::vector<Element<N>>& elements, const IdMap& local, const Arrays<N>& to) {
  to.list.reserve(elements.size());
  to.tags.reserve(elements.size());
  to.ids.reserve(elements.size());
  for (const Element<N>& e : elements) {
    const auto at = index_count(to.list);
    std::array<Index, N> v;
    for (std::size_t k = 0; k < N; ++k) v[k] = local[e.v[k]];
    to.list.push_back(v);
    to.tags.push_back(e.tag);
    to.ids.push_back(e.id);
    if ((e.flags & kRequired) != 0) to.required.push_back(at);
    if (to.ridges != nullptr && (e.flags & kRidge) != 0) to.ridges->push_back(at);
  }
}

/// The ranks that each entity is sent to, mostly one.
class Destinations {
 public:
  explicit Destinations(std::size_t count) : first_(count, -1) {}
  void add(Index i, int to) {
    int& first = item(first_, i);
    if (first < 0) {
      first = to;
    } else if (first != to) {
      more_.push_back({i, to});
    }
  }
  /// Calls f(i, rank) for each entity i, in increasing order, and each of its ranks; `otherwise` for one without ranks.
  template <class F>
  void for_each(int otherwise, F f) {
    std::sort(more_.begin(), more_.end());
    more_.erase(std::unique(more_.begin(), more_.end()), more_.end());
    auto next = more_.begin();
    for (std::size_t i = 0; i < first_.size(); ++i) {
      f(i, first_[i] < 0 ? otherwise : first_[i]);
      for (; next != more_.end() && next->first == to_index(i); ++next) f(i, next->second);
    }
  }

 private:
  std::vector<int> first_;
  std::vector<std::pair<Index, int>> more_;
};

void add_flag(std::vector<int>& flags, const std::vector<Index>& ids, int flag) {
  for (const Index i : ids) item(flags, i) |= flag;
}

template <std::size_t N>
Element<N> element(const std::vector<Id>& vertex_id, const std::array<Index, N>& v, Id id, int tag, int flags) {
  Element<N> e{id, {}, tag, flags};
  for (std::size_t k = 0; k < N; ++k) e.v[k] = item(vertex_id, v[k]);
  return e;
}

}  // namespace

Part assemble(Pieces pieces) {
  Part part;
  TetMesh& mesh = part.mesh;
  sort_unique(pieces.vertices);
  for (const Vertex& v : pieces.vertices) {
    const auto at = index_count(mesh.points);
    mesh.points.push_back(v.x);
    mesh.point_tags.push_back(v.tag);
    part.vertex_id.push_back(v.id);
    part.vertex_flags.push_back(static_cast<std::uint8_t>(v.flags & kOfPart));
    if ((v.flags & kCorner) != 0) mesh.corners.push_back(at);
    if ((v.flags & kRequired) != 0) mesh.required_vertices.push_back(at);
  }
  const IdMap local(part.vertex_id);
  add_elements<4>(pieces.cells, local, {mesh.tets, mesh.tet_tags, part.tet_id, mesh.required_tets});
  add_lists(part, local, std::move(pieces.sides), std::move(pieces.lines));
  return part;
}

void add_lists(Part& part, const IdMap& local, std::vector<Side> sides, std::vector<Line> lines) {
  TetMesh& mesh = part.mesh;
  sort_unique(sides);
  sort_unique(lines);
  add_elements<3>(sides, local, {mesh.triangles, mesh.triangle_tags, part.triangle_id, mesh.required_triangles});
  add_elements<2>(lines, local, {mesh.edges, mesh.edge_tags, part.edge_id, mesh.required_edges, &mesh.ridges});
}

Addressed address(const Part& part, const std::vector<int>& tet_to, int self) {
  const TetMesh& mesh = part.mesh;
  Addressed result;
  const std::size_t vertices = mesh.points.size();
  std::vector<int> flags(part.vertex_flags.begin(), part.vertex_flags.end());
  add_flag(flags, mesh.corners, kCorner);
  add_flag(flags, mesh.required_vertices, kRequired);
  Destinations vertex_to(vertices);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) vertex_to.add(v, tet_to[t]);
  }
  vertex_to.for_each(self, [&](std::size_t v, int to) {
    result.pieces.vertices.push_back({part.vertex_id[v], mesh.points[v], mesh.point_tags[v], flags[v]});
    result.vertex_to.push_back(to);
  });

  flags.assign(mesh.tets.size(), 0);
  add_flag(flags, mesh.required_tets, kRequired);
  result.pieces.cells.reserve(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    result.pieces.cells.push_back(element(part.vertex_id, mesh.tets[t], part.tet_id[t], mesh.tet_tags[t], flags[t]));
  }
  result.cell_to = tet_to;

  flags.assign(mesh.triangles.size(), 0);
  add_flag(flags, mesh.required_triangles, kRequired);
  Destinations side_to(mesh.triangles.size());
  find_in(mesh.triangles, mesh.tets, vertices, [&](Index i, std::size_t t) { side_to.add(i, tet_to[t]); });
  side_to.for_each(self, [&](std::size_t i, int to) {
    result.pieces.sides.push_back(
        element(part.vertex_id, mesh.triangles[i], part.triangle_id[i], mesh.triangle_tags[i], flags[i]));
    result.side_to.push_back(to);
  });

  flags.assign(mesh.edges.size(), 0);
  add_flag(flags, mesh.required_edges, kRequired);
  add_flag(flags, mesh.ridges, kRidge);
  Destinations line_to(mesh.edges.size());
  find_in(mesh.edges, mesh.tets, vertices, [&](Index i, std::size_t t) { line_to.add(i, tet_to[t]); });
  line_to.for_each(self, [&](std::size_t i, int to) {
    result.pieces.lines.push_back(element(part.vertex_id, mesh.edges[i], part.edge_id[i], mesh.edge_tags[i], flags[i]));
    result.line_to.push_back(to);
  });
  return result;
}

}  // namespace tetune::mpi
