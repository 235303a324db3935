// SPDX-License-Identifier: Apache-2.0
#include "part.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace tetune::mpi {
namespace {

template <class T>
void sort_unique(std::vector<T>& items) {
  // Stable, so that of several copies the one of the lowest rank stays.
  std::stable_sort(items.begin(), items.end(), [](const T& a, const T& b) { return a.id < b.id; });
  items.erase(std::unique(items.begin(), items.end(), [](const T& a, const T& b) { return a.id == b.id; }),
              items.end());
}

/// Puts elements into the arrays of a mesh.
template <std::size_t N>
void put(const std::vector<Element<N>>& elements, const IdMap& local, std::vector<std::array<Index, N>>& list,
         std::vector<int>& tags, std::vector<Id>& ids, std::vector<Index>& required, std::vector<Index>* ridges) {
  list.reserve(elements.size());
  tags.reserve(elements.size());
  ids.reserve(elements.size());
  for (const Element<N>& e : elements) {
    const auto at = static_cast<Index>(list.size());
    std::array<Index, N> v;
    for (std::size_t k = 0; k < N; ++k) v[k] = local[e.v[k]];
    list.push_back(v);
    tags.push_back(e.tag);
    ids.push_back(e.id);
    if ((e.flags & kRequired) != 0) required.push_back(at);
    if (ridges != nullptr && (e.flags & kRidge) != 0) ridges->push_back(at);
  }
}

/// Ranks that each of some entities goes to: mostly one.
class Destinations {
 public:
  explicit Destinations(std::size_t count) : first_(count, -1) {}
  void add(Index i, int to) {
    int& first = first_[static_cast<std::size_t>(i)];
    if (first < 0) {
      first = to;
    } else if (first != to) {
      more_.push_back({i, to});
    }
  }
  /// Calls f(i, to) for each, i increasing.
  template <class F>
  void for_each(int otherwise, F f) {
    std::sort(more_.begin(), more_.end());
    more_.erase(std::unique(more_.begin(), more_.end()), more_.end());
    auto next = more_.begin();
    for (std::size_t i = 0; i < first_.size(); ++i) {
      f(i, first_[i] < 0 ? otherwise : first_[i]);
      for (; next != more_.end() && next->first == static_cast<Index>(i); ++next) f(i, next->second);
    }
  }

 private:
  std::vector<int> first_;
  std::vector<std::pair<Index, int>> more_;
};

/// The entries of a list by their vertices.
template <std::size_t N>
class Lookup {
 public:
  Lookup(const std::vector<std::array<Index, N>>& list, std::vector<std::uint8_t>& listed)
      : keys_(list), next_(list.size(), -1), first_(std::bit_ceil(2 * list.size() + 2), -1) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      for (const Index v : list[i]) listed[static_cast<std::size_t>(v)] = 1;
      std::sort(keys_[i].begin(), keys_[i].end());
      Index& first = first_[place(keys_[i])];
      next_[i] = first;
      first = static_cast<Index>(i);
    }
  }
  /// Calls found(i) for each entry of these vertices.
  template <class F>
  void find(const std::array<Index, N>& key, F found) const {
    for (Index i = first_[place(key)]; i >= 0; i = next_[static_cast<std::size_t>(i)]) {
      if (keys_[static_cast<std::size_t>(i)] == key) found(i);
    }
  }

 private:
  std::size_t place(const std::array<Index, N>& key) const {
    std::uint64_t hash = 0;
    for (const Index v : key) hash = (hash ^ static_cast<std::uint64_t>(v)) * 0x9E3779B97F4A7C15U;
    return static_cast<std::size_t>(hash >> 20U) & (first_.size() - 1);
  }
  std::vector<std::array<Index, N>> keys_;
  std::vector<Index> next_, first_;
};

/// Calls found(i, t) for each listed triangle or edge i that tetrahedron t has.
template <std::size_t N, class F>
void find_in(const std::vector<std::array<Index, N>>& list, const std::vector<std::array<Index, 4>>& tets,
             std::size_t vertices, F found) {
  if (list.empty()) return;
  std::vector<std::uint8_t> listed(vertices, 0);
  const Lookup<N> lookup(list, listed);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    std::array<Index, 4> on{};
    std::size_t count = 0;
    for (const Index v : tets[t]) {
      if (listed[static_cast<std::size_t>(v)] != 0) ++count;
    }
    if (count < N) continue;
    std::array<Index, 4> sorted = tets[t];
    std::sort(sorted.begin(), sorted.end());
    count = 0;
    for (const Index v : sorted) {
      if (listed[static_cast<std::size_t>(v)] != 0) on[count++] = v;
    }
    for (unsigned choice = 0; choice < 1U << count; ++choice) {
      if (std::popcount(choice) != static_cast<int>(N)) continue;
      std::array<Index, N> key;
      std::size_t k = 0;
      for (std::size_t i = 0; i < count; ++i) {
        if ((choice >> i & 1U) != 0) key[k++] = on[i];
      }
      lookup.find(key, [&](Index i) { found(i, t); });
    }
  }
}

template <std::size_t N>
std::vector<std::uint8_t> found_in(const std::vector<std::array<Index, N>>& list,
                                   const std::vector<std::array<Index, 4>>& tets, std::size_t vertices) {
  std::vector<std::uint8_t> found(list.size(), 0);
  find_in(list, tets, vertices, [&found](Index i, std::size_t) { found[static_cast<std::size_t>(i)] = 1; });
  return found;
}

void add_flag(std::vector<int>& flags, const std::vector<Index>& ids, int flag) {
  for (const Index i : ids) flags[static_cast<std::size_t>(i)] |= flag;
}

template <std::size_t N>
Element<N> element(const std::vector<Id>& vertex_id, const std::array<Index, N>& v, Id id, int tag, int flags) {
  Element<N> e{id, {}, tag, flags};
  for (std::size_t k = 0; k < N; ++k) e.v[k] = vertex_id[static_cast<std::size_t>(v[k])];
  return e;
}

}  // namespace

IdMap::IdMap(const std::vector<Id>& ids) : slots_(std::bit_ceil(2 * ids.size() + 2)), mask_(slots_.size() - 1) {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    std::size_t at = hash(ids[i]);
    while (slots_[at].index >= 0) at = (at + 1) & mask_;
    slots_[at] = {ids[i], static_cast<Index>(i)};
  }
}

Part assemble(Pieces pieces) {
  Part part;
  TetMesh& mesh = part.mesh;
  sort_unique(pieces.vertices);
  for (const Vertex& v : pieces.vertices) {
    const auto at = static_cast<Index>(mesh.points.size());
    mesh.points.push_back(v.x);
    mesh.point_tags.push_back(v.tag);
    part.vertex_id.push_back(v.id);
    part.vertex_flags.push_back(static_cast<std::uint8_t>(v.flags & kOfPart));
    if ((v.flags & kCorner) != 0) mesh.corners.push_back(at);
    if ((v.flags & kRequired) != 0) mesh.required_vertices.push_back(at);
  }
  const IdMap local(part.vertex_id);
  put(pieces.cells, local, mesh.tets, mesh.tet_tags, part.tet_id, mesh.required_tets, nullptr);
  add_lists(part, local, std::move(pieces.sides), std::move(pieces.lines));
  return part;
}

void add_lists(Part& part, const IdMap& local, std::vector<Side> sides, std::vector<Line> lines) {
  TetMesh& mesh = part.mesh;
  sort_unique(sides);
  sort_unique(lines);
  put(sides, local, mesh.triangles, mesh.triangle_tags, part.triangle_id, mesh.required_triangles, nullptr);
  put(lines, local, mesh.edges, mesh.edge_tags, part.edge_id, mesh.required_edges, &mesh.ridges);
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

std::vector<std::uint8_t> are_in(const std::vector<std::array<Index, 3>>& triangles,
                                 const std::vector<std::array<Index, 4>>& tets, std::size_t vertices) {
  return found_in(triangles, tets, vertices);
}
std::vector<std::uint8_t> are_in(const std::vector<std::array<Index, 2>>& edges,
                                 const std::vector<std::array<Index, 4>>& tets, std::size_t vertices) {
  return found_in(edges, tets, vertices);
}

}  // namespace tetune::mpi
