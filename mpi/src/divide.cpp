// SPDX-License-Identifier: Apache-2.0
// Dividing a part in two, and merging parts.
#include <algorithm>
#include <numeric>
#include <utility>

#include "lookup.hpp"
#include "part.hpp"

namespace tetune::mpi {
namespace {

/// The parts that an entity belongs to when a part is divided in two, as bits.
constexpr std::uint8_t kStays = 1, kLeaves = 2;
struct Division {
  Marks vertex, tet, triangle, edge;
};

/// Listed entities go with the tetrahedra that have them.
template <std::size_t N>
Marks division_of_listed(const std::vector<std::array<Index, N>>& list, const std::vector<std::array<Index, 4>>& tets,
                         const Division& division) {
  Marks result(list.size(), kStays);
  std::vector<std::array<Index, N>> candidates;
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < list.size(); ++i) {
    std::uint8_t all = kLeaves;
    for (const Index v : list[i]) all &= item(division.vertex, v);
    if (all == 0) continue;
    candidates.push_back(list[i]);
    which.push_back(i);
  }
  Marks found(candidates.size(), 0);
  find_in(candidates, tets, division.vertex.size(), [&](Index i, std::size_t t) { item(found, i) |= division.tet[t]; });
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (found[i] != 0) result[which[i]] = found[i];
  }
  return result;
}

/// Numbers the entities that belong to a part; -1 for the others.
std::vector<Index> numbered(const Marks& division, std::uint8_t bit) {
  std::vector<Index> positions(division.size(), -1);
  Index next = 0;
  for (std::size_t i = 0; i < division.size(); ++i) {
    if ((division[i] & bit) != 0) positions[i] = next++;
  }
  return positions;
}

/// The position of each id in a list after the ids that it lacks have been appended to it.
std::vector<Index> merged_positions(const std::vector<Id>& ids, const std::vector<Id>& list) {
  const IdMap local(ids);
  std::vector<Index> positions(ids.size(), -1);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Index at = local[list[i]];
    if (at >= 0) item(positions, at) = to_index(i);
  }
  auto next = index_count(list);
  for (Index& position : positions) {
    if (position < 0) position = next++;
  }
  return positions;
}

/// For each entity its position in another part: behind all of its entities, in this order, or that of an entity that
/// the part has already, or none (-1).
struct Positions {
  std::vector<Index> vertex, tet, triangle, edge;
};

/// Appends to a part the entities whose positions are behind all that it has.
void append(Part& part, const Part& from, const Positions& positions) {
  const auto add = [](auto& list, const auto& items, const std::vector<Index>& position, auto translate) {
    const auto end = index_count(list);
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (position[i] >= end) list.push_back(translate(items[i]));
    }
    return end;
  };
  const auto unchanged = [](const auto& item) { return item; };
  const auto renumber = [&positions](auto element) {
    for (Index& v : element) v = item(positions.vertex, v);
    return element;
  };
  const auto add_listed = [](std::vector<Index>& list, const std::vector<Index>& items,
                             const std::vector<Index>& position, Index end) {
    for (const Index i : items) {
      if (item(position, i) >= end) list.push_back(item(position, i));
    }
  };
  TetMesh& mesh = part.mesh;
  const TetMesh& more = from.mesh;
  Index end = add(mesh.points, more.points, positions.vertex, unchanged);
  add(mesh.point_tags, more.point_tags, positions.vertex, unchanged);
  add(part.vertex_id, from.vertex_id, positions.vertex, unchanged);
  add(part.vertex_flags, from.vertex_flags, positions.vertex, unchanged);
  add_listed(mesh.corners, more.corners, positions.vertex, end);
  add_listed(mesh.required_vertices, more.required_vertices, positions.vertex, end);

  end = add(mesh.tets, more.tets, positions.tet, renumber);
  add(mesh.tet_tags, more.tet_tags, positions.tet, unchanged);
  add(part.tet_id, from.tet_id, positions.tet, unchanged);
  add_listed(mesh.required_tets, more.required_tets, positions.tet, end);

  end = add(mesh.triangles, more.triangles, positions.triangle, renumber);
  add(mesh.triangle_tags, more.triangle_tags, positions.triangle, unchanged);
  add(part.triangle_id, from.triangle_id, positions.triangle, unchanged);
  add_listed(mesh.required_triangles, more.required_triangles, positions.triangle, end);

  end = add(mesh.edges, more.edges, positions.edge, renumber);
  add(mesh.edge_tags, more.edge_tags, positions.edge, unchanged);
  add(part.edge_id, from.edge_id, positions.edge, unchanged);
  add_listed(mesh.required_edges, more.required_edges, positions.edge, end);
  add_listed(mesh.ridges, more.ridges, positions.edge, end);
}

Division divide(const Part& part, const Marks& marked) {
  const TetMesh& mesh = part.mesh;
  Division division;
  division.tet.reserve(marked.size());
  for (const std::uint8_t m : marked) division.tet.push_back(m != 0 ? kLeaves : kStays);
  division.vertex.assign(mesh.points.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) item(division.vertex, v) |= division.tet[t];
  }
  for (std::uint8_t& g : division.vertex) g = g == 0 ? kStays : g;
  division.triangle = division_of_listed(mesh.triangles, mesh.tets, division);
  division.edge = division_of_listed(mesh.edges, mesh.tets, division);
  return division;
}

/// The entities that belong to one of the two parts.
Part part_of_division(const Part& part, const Division& division, std::uint8_t bit) {
  Part result;
  append(result, part,
         {numbered(division.vertex, bit), numbered(division.tet, bit), numbered(division.triangle, bit),
          numbered(division.edge, bit)});
  return result;
}

}  // namespace

Part copied(const Part& part, const Marks& marked) { return part_of_division(part, divide(part, marked), kLeaves); }

Part extract(Part& part, const Marks& marked) {
  const Division division = divide(part, marked);
  Part out = part_of_division(part, division, kLeaves);
  part = part_of_division(part, division, kStays);
  return out;
}

void merge(Part& part, const Part& other) {
  // A tetrahedron belongs to one part only. Several may have the same id, that of their common origin.
  std::vector<Index> tets(other.mesh.tets.size());
  std::iota(tets.begin(), tets.end(), index_count(part.mesh.tets));
  append(part, other,
         {merged_positions(other.vertex_id, part.vertex_id), std::move(tets),
          merged_positions(other.triangle_id, part.triangle_id), merged_positions(other.edge_id, part.edge_id)});
}

}  // namespace tetune::mpi
