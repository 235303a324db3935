// SPDX-License-Identifier: Apache-2.0
#include "distribute.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "bisection.hpp"
#include "listed_entities.hpp"
#include "tetune/error.hpp"

namespace tetune::mpi {
namespace {

/// The vertices of the cells, in increasing order.
std::vector<Id> unique_vertices(const std::vector<Cell>& cells) {
  std::vector<Id> ids;
  IdMap found;
  for (const Cell& c : cells) {
    for (const Id v : c.v) {
      if (found.add(v)) ids.push_back(v);
    }
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

/// Sends entities to their owner ranks, which keep one copy of each.
template <class T>
std::vector<T> at_owner(MPI_Comm comm, const std::vector<T>& items, Id total) {
  const Blocks blocks(total, size_of(comm));
  std::vector<int> to;
  to.reserve(items.size());
  for (const T& item : items) to.push_back(blocks.owner(item.id));
  std::vector<T> owned = Route(comm, to).send(items);
  std::stable_sort(owned.begin(), owned.end(), [](const T& a, const T& b) { return a.id < b.id; });
  owned.erase(std::unique(owned.begin(), owned.end(), [](const T& a, const T& b) { return a.id == b.id; }),
              owned.end());
  return owned;
}

/// Numbers entities without gaps.
template <class T>
void number(MPI_Comm comm, std::vector<T>& items, Id& total) {
  Id next = sum_before(comm, std::ssize(items));
  total = all_reduce(comm, std::ssize(items), MPI_SUM);
  for (T& item : items) item.id = next++;
}

template <std::size_t N>
void check_vertices(const std::vector<Element<N>>& elements, Id vertices, const char* kind) {
  for (const Element<N>& e : elements) {
    for (const Id v : e.v) {
      if (v >= 0 && v < vertices) continue;
      throw MeshError(std::string(kind) + " " + std::to_string(e.id + 1) + " has vertex " + std::to_string(v + 1) +
                      " (both counted from 1), but there are " + std::to_string(vertices) + " vertices");
    }
  }
}

/// Checks all that the distribution relies on; validate() checks the rest in the parts.
void check(const Pieces& pieces, Id vertices) {
  for (const Vertex& v : pieces.vertices) {
    if (std::all_of(v.x.begin(), v.x.end(), [](double x) { return std::isfinite(x); })) continue;
    throw MeshError("vertex " + std::to_string(v.id + 1) + " (counted from 1) has a coordinate that is not finite");
  }
  check_vertices(pieces.cells, vertices, "tetrahedron");
  check_vertices(pieces.sides, vertices, "triangle");
  check_vertices(pieces.lines, vertices, "edge");
}

/// Replaces the vertices of elements by their new ids, which the owner ranks of the old ones have.
void renumber(MPI_Comm comm, const Blocks& blocks, const std::vector<Id>& new_ids, std::vector<ElementBlock>& others) {
  std::vector<int> to;
  std::vector<Id> wanted;
  for (const ElementBlock& block : others) {
    for (const Index v : block.element2vertex) {
      to.push_back(blocks.owner(v));
      wanted.push_back(v);
    }
  }
  const Route route(comm, to);
  std::vector<Id> asked = route.send(wanted);
  const Id first = blocks.begin(rank_of(comm));
  for (Id& v : asked) v = item(new_ids, v - first);
  const std::vector<Id> renumbered = route.answer(asked);
  auto next = renumbered.begin();
  for (ElementBlock& block : others) {
    for (Index& v : block.element2vertex) v = Index(*next++);
  }
}

}  // namespace

Part distribute(MPI_Comm comm, Pieces pieces, const Totals& totals) {
  collective_try(comm, [&] { check(pieces, totals.vertices); });
  const Blocks blocks(totals.vertices, size_of(comm));
  const std::vector<Vertex> owned = at_owner(comm, pieces.vertices, totals.vertices);
  pieces.vertices = {};
  const Blocks cell_blocks(totals.cells, size_of(comm));
  std::vector<int> to;
  to.reserve(pieces.cells.size());
  for (const Cell& c : pieces.cells) to.push_back(cell_blocks.owner(c.id));
  std::vector<Cell> cells = Route(comm, to).send(pieces.cells);
  pieces.cells = {};
  {
    const std::vector<Id> ids = unique_vertices(cells);
    const std::vector<Vertex> vertices = StarForest(comm, ids, blocks).fetch(owned);
    const IdMap local(ids);
    std::vector<Point3> centroids;
    centroids.reserve(cells.size());
    for (const Cell& c : cells) {
      Point3 centroid{};
      for (const Id v : c.v) {
        const Point3& x = item(vertices, local[v]).x;
        for (std::size_t k = 0; k < 3; ++k) centroid[k] += 0.25 * x[k];
      }
      centroids.push_back(centroid);
    }
    to = bisect(comm, centroids);
  }
  Pieces mine;
  mine.cells = Route(comm, to).send(cells);
  cells = {};
  const StarForest vertices(comm, unique_vertices(mine.cells), blocks);
  mine.vertices = vertices.fetch(owned);
  // Vertices of no tetrahedron stay on their owner rank.
  const std::vector<int> copies = vertices.copies();
  for (std::size_t i = 0; i < owned.size(); ++i) {
    if (copies[i] == 0) mine.vertices.push_back(owned[i]);
  }
  Part part = assemble(std::move(mine));
  std::vector<Side> sides;
  std::vector<Line> lines;
  {
    const ListedEntities listed(comm, part, blocks, vertices);
    sides = listed.placed(pieces.sides, "triangles", "a face");
    lines = listed.placed(pieces.lines, "edges", "an edge");
  }
  add_lists(part, IdMap(part.vertex_id), std::move(sides), std::move(lines));
  return part;
}

Pieces send(MPI_Comm comm, Addressed a) {
  Pieces result;
  result.vertices = Route(comm, a.vertex_to).send(a.pieces.vertices);
  a.pieces.vertices = {};
  result.cells = Route(comm, a.cell_to).send(a.pieces.cells);
  a.pieces.cells = {};
  result.sides = Route(comm, a.side_to).send(a.pieces.sides);
  result.lines = Route(comm, a.line_to).send(a.pieces.lines);
  return result;
}

std::vector<Id> close_gaps(MPI_Comm comm, Part& part, Totals& totals) {
  const StarForest star(comm, part.vertex_id, Blocks(totals.vertices, size_of(comm)));
  const std::vector<int> copies = star.copies();
  const auto used = std::ssize(copies) - std::count(copies.begin(), copies.end(), 0);
  Id next = sum_before(comm, used);
  std::vector<Id> ids;
  ids.reserve(copies.size());
  for (const int n : copies) ids.push_back(n > 0 ? next++ : -1);
  part.vertex_id = star.fetch(ids);
  totals.vertices = all_reduce(comm, used, MPI_SUM);
  return ids;
}

std::vector<Vertex> vertices_at_owner(MPI_Comm comm, const std::vector<Vertex>& vertices, const Totals& totals) {
  return at_owner(comm, vertices, totals.vertices);
}

Pieces collect(MPI_Comm comm, Part part, Totals& totals, std::vector<ElementBlock>& others) {
  const Blocks blocks(totals.vertices, size_of(comm));
  renumber(comm, blocks, close_gaps(comm, part, totals), others);
  Pieces pieces = address(part, std::vector<int>(part.mesh.tets.size(), 0), 0).pieces;
  part = {};
  pieces.vertices = at_owner(comm, pieces.vertices, totals.vertices);
  pieces.sides = at_owner(comm, pieces.sides, totals.sides);
  pieces.lines = at_owner(comm, pieces.lines, totals.lines);
  number(comm, pieces.cells, totals.cells);
  number(comm, pieces.sides, totals.sides);
  number(comm, pieces.lines, totals.lines);
  return pieces;
}

}  // namespace tetune::mpi
