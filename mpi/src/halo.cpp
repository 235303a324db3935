// SPDX-License-Identifier: Apache-2.0
#include "halo.hpp"

#include <map>
#include <utility>

#include "driver/distributed_interface.hpp"
#include "holders.hpp"

namespace tetune::mpi {
namespace {

std::vector<std::size_t> possibly_shared(const Part& part) {
  std::vector<std::size_t> vertices;
  for (std::size_t v = 0; v < part.vertex_flags.size(); ++v) {
    if ((part.vertex_flags[v] & kShared) != 0) vertices.push_back(v);
  }
  return vertices;
}

/// A vertex and another rank that has it.
struct Copy {
  Id id;
  int rank;
};

void join(Addressed& all, const Addressed& more) {
  const auto add = [](auto& list, const auto& items) { list.insert(list.end(), items.begin(), items.end()); };
  add(all.pieces.vertices, more.pieces.vertices);
  add(all.pieces.cells, more.pieces.cells);
  add(all.pieces.sides, more.pieces.sides);
  add(all.pieces.lines, more.pieces.lines);
  add(all.vertex_to, more.vertex_to);
  add(all.cell_to, more.cell_to);
  add(all.side_to, more.side_to);
  add(all.line_to, more.line_to);
}

/// The tetrahedra with marked vertices, all addressed to one rank.
Addressed touching(const Part& part, const Marks& vertices, int rank) {
  const Part touched = copied(part, tets_at(part.mesh.tets, vertices));
  return address(touched, std::vector<int>(touched.mesh.tets.size(), rank), rank);
}

}  // namespace

Part halo_of(MPI_Comm comm, const Part& part, const Totals& totals, const std::vector<int>& frozen_regions) {
  // The owner rank of a vertex has a list of the ranks that hold it.
  const Blocks blocks(totals.vertices, size_of(comm));
  const std::vector<std::size_t> shared = possibly_shared(part);
  const StarForest star(comm, gather_entries(part.vertex_id, shared), blocks);
  const Holders holders(star, blocks, rank_of(comm));
  std::vector<Copy> copies;
  std::vector<int> to;
  for (Id id = blocks.begin(rank_of(comm)); id < blocks.begin(rank_of(comm) + 1); ++id) {
    holders.for_each(id, [&](int one) {
      holders.for_each(id, [&](int other) {
        if (one == other) return;
        copies.push_back({id, other});
        to.push_back(one);
      });
    });
  }
  copies = Route(comm, to).send(copies);

  Addressed all;
  Part halo;
  collective_try(comm, [&] {
    Marks vertices(part.vertex_id.size(), 0);
    for (const std::size_t v : shared) vertices[v] = 1;
    const Part own = copied(part, tets_at(part.mesh.tets, vertices));
    const IdMap in_own(own.vertex_id);
    std::map<int, Marks> shared_with;
    for (const Copy& c : copies) {
      Marks& marks = shared_with[c.rank];
      marks.resize(own.vertex_id.size(), 0);
      item(marks, in_own[c.id]) = 1;
    }
    for (const auto& [rank, marks] : shared_with) join(all, touching(own, marks, rank));
    halo = copied(part, tets_at(part.mesh.tets, held_vertices(part.mesh, frozen_regions)));
  });
  Pieces arrived = send(comm, std::move(all));
  collective_try(comm, [&] { merge(halo, assemble(std::move(arrived))); });
  return halo;
}

Shared::Shared(MPI_Comm comm, const Part& part, const Totals& totals)
    : vertices_(possibly_shared(part)),
      star_(comm, gather_entries(part.vertex_id, vertices_), Blocks(totals.vertices, size_of(comm))) {}

void Shared::mark(Part& part) const {
  const std::vector<int> copies = star_.fetch(star_.copies());
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    if (copies[i] < 2) part.vertex_flags[vertices_[i]] &= std::uint8_t(~kShared);
  }
}

void Shared::minimize(std::vector<int>& values) const {
  const std::vector<int> minima = star_.minima(gather_entries(values, vertices_));
  for (std::size_t i = 0; i < vertices_.size(); ++i) values[vertices_[i]] = minima[i];
}

}  // namespace tetune::mpi
