// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "backend/cpu.hpp"
#include "mesh/csr.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The tetrahedra of each vertex of a TetMesh, in increasing order. Host only.
class VertexTets {
 public:
  VertexTets(const backend::Cpu& backend, const TetMesh& mesh) {
    const Size corners = 4 * std::ssize(mesh.tets);
    build_csr_of<backend::Cpu, VertexOfCorner, TetOfCorner, Index>(
        backend, {.rows = std::ssize(mesh.points), .items = corners, .row_of = {span_of(mesh.tets)}}, offsets_, tets_);
  }
  std::span<const Index> of(Index v) const {
    const Index* const tets = tets_.span().data();
    return {tets + offsets_.span()[v], tets + offsets_.span()[v + 1]};
  }

 private:
  struct VertexOfCorner {
    Span<const std::array<Index, 4>> tets;
    Size operator()(Size corner) const { return tets[corner / 4][to_size_t(corner % 4)]; }
  };
  struct TetOfCorner {
    Index operator()(std::uint32_t corner) const { return to_index(corner / 4); }
  };

  BufferOf<backend::Cpu, std::uint32_t> offsets_;
  BufferOf<backend::Cpu, Index> tets_;
};

}  // namespace tetune
