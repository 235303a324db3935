// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/buffer.hpp"
#include "boundary/vertex_dofs.hpp"

/// Sets of vertices as flags. VertexDofs::active is the active set of the sweeps; the output of flips and temporary
/// selections are sets of their own.
namespace tetune {

/// A temporary selection: a flag per vertex.
template <class Backend>
using VertexMask = BufferOf<Backend, std::uint8_t>;

/// The vertices whose ring flips have changed since the set was cleared.
template <class Backend>
class ChangedVertices {
 public:
  void clear(const Backend& backend, Size vertices) {
    flags_.resize(backend, vertices);
    backend.fill(flags_.span(), std::uint8_t{0});
  }
  void assign(const Backend& backend, const VertexMask<Backend>& vertices) { flags_.assign(backend, vertices); }

  /// The argument `changed` of flip passes.
  Span<std::uint8_t> output() { return flags_.span(); }
  Span<const std::uint8_t> flags() { return flags_.span(); }

 private:
  VertexMask<Backend> flags_;
};

namespace vertex_sets_detail {

struct Activate {
  Span<const std::uint8_t> changed;
  Span<std::uint8_t> active;
  TETUNE_HD void operator()(Size v) const {
    if (changed[v] != 0) active[v] = 1;
  }
};

}  // namespace vertex_sets_detail

/// Adds the changed vertices to the active set.
template <class Backend>
void activate(const Backend& backend, ChangedVertices<Backend>& changed, VertexDofs<Backend>& dofs) {
  const Span<const std::uint8_t> flags = changed.flags();
  backend.for_each(flags.size(), vertex_sets_detail::Activate{flags, dofs.active.span()});
}

}  // namespace tetune
