// SPDX-License-Identifier: Apache-2.0
#include "part.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
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

/// Where the entities of a part go when it is divided: bits.
constexpr std::uint8_t kStays = 1, kOut = 2;
struct Goes {
  std::vector<std::uint8_t> vertex, tet, triangle, edge;
};

/// Listed entities go where tetrahedra that have them go.
template <std::size_t N>
std::vector<std::uint8_t> go_along(const std::vector<std::array<Index, N>>& list,
                                   const std::vector<std::array<Index, 4>>& tets, const Goes& goes) {
  std::vector<std::uint8_t> result(list.size(), kStays);
  std::vector<std::array<Index, N>> maybe;
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < list.size(); ++i) {
    std::uint8_t all = kOut;
    for (const Index v : list[i]) all &= goes.vertex[static_cast<std::size_t>(v)];
    if (all == 0) continue;
    maybe.push_back(list[i]);
    which.push_back(i);
  }
  std::vector<std::uint8_t> found(maybe.size(), 0);
  find_in(maybe, tets, goes.vertex.size(),
          [&](Index i, std::size_t t) { found[static_cast<std::size_t>(i)] |= goes.tet[t]; });
  for (std::size_t i = 0; i < maybe.size(); ++i) {
    if (found[i] != 0) result[which[i]] = found[i];
  }
  return result;
}

/// Numbers what goes one way; -1 for the rest.
std::vector<Index> numbered(const std::vector<std::uint8_t>& goes, std::uint8_t way) {
  std::vector<Index> places(goes.size(), -1);
  Index next = 0;
  for (std::size_t i = 0; i < goes.size(); ++i) {
    if ((goes[i] & way) != 0) places[i] = next++;
  }
  return places;
}

/// Where each of some entities is in a list, or comes to be when those that are not there are appended.
std::vector<Index> found_or_appended(const std::vector<Id>& ids, const std::vector<Id>& list) {
  const IdMap local(ids);
  std::vector<Index> places(ids.size(), -1);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Index at = local[list[i]];
    if (at >= 0) places[static_cast<std::size_t>(at)] = static_cast<Index>(i);
  }
  auto next = static_cast<Index>(list.size());
  for (Index& place : places) {
    if (place < 0) place = next++;
  }
  return places;
}

/// For each entity its place in another part: at the end, in this order, or among what is there already, or none (-1).
struct Places {
  std::vector<Index> vertex, tet, triangle, edge;
};

/// Appends to a part what has its place at the end.
void append(Part& part, const Part& from, const Places& places) {
  const auto add = [](auto& list, const auto& items, const std::vector<Index>& place, auto translate) {
    const auto end = static_cast<Index>(list.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (place[i] >= end) list.push_back(translate(items[i]));
    }
    return end;
  };
  const auto as_it_is = [](const auto& item) { return item; };
  const auto renumber = [&places](auto element) {
    for (Index& v : element) v = places.vertex[static_cast<std::size_t>(v)];
    return element;
  };
  const auto add_listed = [](std::vector<Index>& list, const std::vector<Index>& items, const std::vector<Index>& place,
                             Index end) {
    for (const Index i : items) {
      if (place[static_cast<std::size_t>(i)] >= end) list.push_back(place[static_cast<std::size_t>(i)]);
    }
  };
  TetMesh& mesh = part.mesh;
  const TetMesh& more = from.mesh;
  Index end = add(mesh.points, more.points, places.vertex, as_it_is);
  add(mesh.point_tags, more.point_tags, places.vertex, as_it_is);
  add(part.vertex_id, from.vertex_id, places.vertex, as_it_is);
  add(part.vertex_flags, from.vertex_flags, places.vertex, as_it_is);
  add_listed(mesh.corners, more.corners, places.vertex, end);
  add_listed(mesh.required_vertices, more.required_vertices, places.vertex, end);

  end = add(mesh.tets, more.tets, places.tet, renumber);
  add(mesh.tet_tags, more.tet_tags, places.tet, as_it_is);
  add(part.tet_id, from.tet_id, places.tet, as_it_is);
  add_listed(mesh.required_tets, more.required_tets, places.tet, end);

  end = add(mesh.triangles, more.triangles, places.triangle, renumber);
  add(mesh.triangle_tags, more.triangle_tags, places.triangle, as_it_is);
  add(part.triangle_id, from.triangle_id, places.triangle, as_it_is);
  add_listed(mesh.required_triangles, more.required_triangles, places.triangle, end);

  end = add(mesh.edges, more.edges, places.edge, renumber);
  add(mesh.edge_tags, more.edge_tags, places.edge, as_it_is);
  add(part.edge_id, from.edge_id, places.edge, as_it_is);
  add_listed(mesh.required_edges, more.required_edges, places.edge, end);
  add_listed(mesh.ridges, more.ridges, places.edge, end);
}

template <std::size_t N>
Element<N> element(const std::vector<Id>& vertex_id, const std::array<Index, N>& v, Id id, int tag, int flags) {
  Element<N> e{id, {}, tag, flags};
  for (std::size_t k = 0; k < N; ++k) e.v[k] = vertex_id[static_cast<std::size_t>(v[k])];
  return e;
}

Goes ways_of(const Part& part, const std::vector<std::uint8_t>& marked) {
  const TetMesh& mesh = part.mesh;
  Goes goes;
  goes.tet.reserve(marked.size());
  for (const std::uint8_t m : marked) goes.tet.push_back(m != 0 ? kOut : kStays);
  goes.vertex.assign(mesh.points.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) goes.vertex[static_cast<std::size_t>(v)] |= goes.tet[t];
  }
  for (std::uint8_t& g : goes.vertex) g = g == 0 ? kStays : g;
  goes.triangle = go_along(mesh.triangles, mesh.tets, goes);
  goes.edge = go_along(mesh.edges, mesh.tets, goes);
  return goes;
}

/// What goes one way.
Part picked(const Part& part, const Goes& goes, std::uint8_t way) {
  Part result;
  append(result, part,
         {numbered(goes.vertex, way), numbered(goes.tet, way), numbered(goes.triangle, way), numbered(goes.edge, way)});
  return result;
}

}  // namespace

IdMap::IdMap(const std::vector<Id>& ids) : slots_(std::bit_ceil(2 * ids.size() + 2)) {
  for (const Id id : ids) add(id);
}

bool IdMap::add(Id id) {
  std::size_t at = place(id);
  if (slots_[at].index >= 0) return false;
  if (2 * (count_ + 1) > slots_.size()) {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& s : old) {
      if (s.index >= 0) slots_[place(s.id)] = s;
    }
    at = place(id);
  }
  slots_[at] = {id, static_cast<Index>(count_++)};
  return true;
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

Part copied(const Part& part, const std::vector<std::uint8_t>& marked) {
  return picked(part, ways_of(part, marked), kOut);
}

Part extract(Part& part, const std::vector<std::uint8_t>& marked) {
  const Goes goes = ways_of(part, marked);
  Part out = picked(part, goes, kOut);
  part = picked(part, goes, kStays);
  return out;
}

void absorb(Part& part, const Part& other) {
  // A tetrahedron is in one part alone. Several may have one id: they descend from the same.
  std::vector<Index> tets(other.mesh.tets.size());
  std::iota(tets.begin(), tets.end(), static_cast<Index>(part.mesh.tets.size()));
  append(part, other,
         {found_or_appended(other.vertex_id, part.vertex_id), std::move(tets),
          found_or_appended(other.triangle_id, part.triangle_id), found_or_appended(other.edge_id, part.edge_id)});
}

std::vector<std::uint8_t> on_surface(const TetMesh& mesh) {
  const auto mix = [](std::uint64_t x) {
    x = (x ^ (x >> 32U)) * 0x9E3779B97F4A7C15U;
    return (x ^ (x >> 29U)) * 0xBF58476D1CE4E5B9U;
  };
  // A face inside a region comes twice, and cancels. That others do has odds of 1 to 2^64.
  std::vector<std::uint64_t> left(mesh.points.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    std::array<std::uint64_t, 4> hash;
    for (std::size_t k = 0; k < 4; ++k) hash[k] = mix(static_cast<std::uint64_t>(mesh.tets[t][k]) + 1);
    const std::uint64_t all =
        hash[0] + hash[1] + hash[2] + hash[3] + mix(~static_cast<std::uint64_t>(mesh.tet_tags[t]));
    for (std::size_t f = 0; f < 4; ++f) {
      const std::uint64_t face = mix(all - hash[f]);
      for (std::size_t k = 0; k < 4; ++k) {
        if (k != f) left[static_cast<std::size_t>(mesh.tets[t][k])] ^= face;
      }
    }
  }
  std::vector<std::uint8_t> result;
  result.reserve(left.size());
  for (const std::uint64_t l : left) result.push_back(l != 0 ? 1 : 0);
  return result;
}

std::vector<std::uint8_t> held_vertices(const TetMesh& mesh, const std::vector<int>& frozen_regions) {
  std::vector<std::uint8_t> held = on_surface(mesh);
  const auto hold = [&held](const auto& vertices) {
    for (const Index v : vertices) held[static_cast<std::size_t>(v)] = 1;
  };
  for (const auto& triangle : mesh.triangles) hold(triangle);
  for (const auto& edge : mesh.edges) hold(edge);
  hold(mesh.corners);
  hold(mesh.required_vertices);
  for (const Index t : mesh.required_tets) hold(mesh.tets[static_cast<std::size_t>(t)]);
  if (frozen_regions.empty()) return held;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (std::find(frozen_regions.begin(), frozen_regions.end(), mesh.tet_tags[t]) != frozen_regions.end()) {
      hold(mesh.tets[t]);
    }
  }
  return held;
}

std::vector<std::uint8_t> tets_around(const TetMesh& mesh, const std::vector<std::uint8_t>& vertices) {
  std::vector<std::uint8_t> around;
  around.reserve(mesh.tets.size());
  for (const auto& tet : mesh.tets) {
    std::uint8_t any = 0;
    for (const Index v : tet) any |= vertices[static_cast<std::size_t>(v)];
    around.push_back(any);
  }
  return around;
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
