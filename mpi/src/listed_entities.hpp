// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "communicate.hpp"
#include "holders.hpp"
#include "part.hpp"
#include "tetune/error.hpp"

namespace tetune::mpi {

/// Sends listed triangles and edges to the parts that have one of their vertices; each part keeps those that are faces
/// or edges of its tetrahedra.
class ListedEntities {
 public:
  ListedEntities(MPI_Comm comm, const Part& part, const Blocks& blocks, const StarForest& vertices)
      : comm_(comm),
        part_(part),
        local_(part.vertex_id),
        blocks_(blocks),
        on_surface_(on_surface(part.mesh)),
        holders_(vertices, blocks, rank_of(comm)),
        surface_holders_(StarForest(comm, surface_ids(), blocks), blocks, rank_of(comm)) {}

  /// Returns the elements that belong to this part. Constraining ones that belong to no part are refused, in a message
  /// with `kind` and `of`.
  template <std::size_t N>
  std::vector<Element<N>> placed(const std::vector<Element<N>>& elements, const char* kind, const char* of) const {
    std::vector<int> to;
    to.reserve(elements.size());
    for (const Element<N>& e : elements) to.push_back(blocks_.owner(e.v[0]));
    const std::vector<Element<N>> received = Route(comm_, to).send(elements);
    std::vector<Element<N>> offers;
    std::vector<std::size_t> position;
    to.clear();
    for (std::size_t i = 0; i < received.size(); ++i) {
      (constrains(received[i]) || N < 3 ? holders_ : surface_holders_).for_each(received[i].v[0], [&](int rank) {
        offers.push_back(received[i]);
        position.push_back(i);
        to.push_back(rank);
      });
    }
    const Route route(comm_, to);
    std::vector<Element<N>> kept;
    const Marks taken = route.answer(accept(route.send(offers), kept));
    Marks placed(received.size(), 0);
    for (std::size_t i = 0; i < taken.size(); ++i) placed[position[i]] |= taken[i];
    std::vector<Element<N>> unplaced;
    for (std::size_t i = 0; i < received.size(); ++i) {
      if (placed[i] == 0 && constrains(received[i])) unplaced.push_back(received[i]);
    }
    refuse(unplaced, kind, of);
    return kept;
  }

 private:
  std::vector<Id> surface_ids() const {
    std::vector<Id> ids;
    for (std::size_t v = 0; v < on_surface_.size(); ++v) {
      if (on_surface_[v] != 0) ids.push_back(part_.vertex_id[v]);
    }
    return ids;
  }

  template <std::size_t N>
  static bool constrains(const Element<N>& e) {
    return e.tag != 0 || e.flags != 0;
  }

  /// Appends the elements that tetrahedra of this part have to `kept`, and marks them by 1 in the result. A triangle
  /// inside a region that constrains nothing is dropped, as by optimize().
  template <std::size_t N>
  Marks accept(const std::vector<Element<N>>& offered, std::vector<Element<N>>& kept) const {
    std::vector<std::array<Index, N>> list;
    std::vector<std::size_t> position;
    for (std::size_t i = 0; i < offered.size(); ++i) {
      const bool is_relevant = N < 3 || constrains(offered[i]);
      std::array<Index, N> v;
      bool possible = true;
      for (std::size_t k = 0; k < N && possible; ++k) {
        v[k] = local_[offered[i].v[k]];
        possible = v[k] >= 0 && (is_relevant || item(on_surface_, v[k]) != 0);
      }
      if (!possible) continue;
      list.push_back(v);
      position.push_back(i);
    }
    const auto is_in = are_in(list, part_.mesh.tets, part_.mesh.points.size());
    Marks taken(offered.size(), 0);
    for (std::size_t i = 0; i < position.size(); ++i) {
      if (is_in[i] == 0) continue;
      taken[position[i]] = 1;
      kept.push_back(offered[position[i]]);
    }
    return taken;
  }

  template <std::size_t N>
  void refuse(const std::vector<Element<N>>& unplaced, const char* kind, const char* of) const {
    const auto count = all_reduce(comm_, std::ssize(unplaced), MPI_SUM);
    if (count == 0) return;
    Id first = std::numeric_limits<Id>::max();
    for (const Element<N>& e : unplaced) first = std::min(first, e.id);
    first = all_reduce(comm_, first, MPI_MIN);
    throw MeshError(std::to_string(count) + " listed " + kind + " with a tag or required are not " + of +
                    " of any tetrahedron (first, counted from 1: " + std::to_string(first + 1) +
                    "); remove them, or optimize the mesh on one machine");
  }

  MPI_Comm comm_;
  const Part& part_;
  IdMap local_;
  Blocks blocks_;
  Marks on_surface_;
  Holders holders_, surface_holders_;
};

}  // namespace tetune::mpi
