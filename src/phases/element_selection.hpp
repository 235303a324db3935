// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>

#include "backend/atomic.hpp"
#include "energy/criterion.hpp"
#include "energy/dihedral_cots.hpp"
#include "math/orient.hpp"
#include "mesh/work_mesh.hpp"

/// Selection of tetrahedra and of their vertices, for work on a few of them (docs/method.md, "The worst elements").
namespace tetune {

/// The volume of a tetrahedron is not certified positive by floating-point arithmetic.
struct HasUncertifiedVolume {
  MeshView mesh;
  TETUNE_HD bool operator()(Size t) const {
    if (!mesh.alive(t)) return false;
    const Tet tet = mesh.tet2vertex[t];
    return !orient(vec(mesh.points[tet[0]]), vec(mesh.points[tet[1]]), vec(mesh.points[tet[2]]),
                   vec(mesh.points[tet[3]]))
                .certified();
  }
};

/// The value of a slot is above a bound.
struct IsAbove {
  Span<const double> values;
  double bound;
  TETUNE_HD bool operator()(Size t) const { return values[t] > bound; }
};

/// The tetrahedron of a slot has a flagged vertex.
struct HasFlaggedVertex {
  MeshView mesh;
  Span<const std::uint8_t> flags;
  TETUNE_HD bool operator()(Size t) const {
    if (!mesh.alive(t)) return false;
    const Tet tet = mesh.tet2vertex[t];
    return (flags[tet[0]] | flags[tet[1]] | flags[tet[2]] | flags[tet[3]]) != 0;
  }
};

namespace element_selection_detail {

/// For each of some bounds, the number of values above it.
template <int kBounds>
struct Counts {
  Size above[kBounds] = {};
  TETUNE_HD void merge(const Counts& other) {
    for (int k = 0; k < kBounds; ++k) above[k] += other.above[k];
  }
};

template <int kBounds>
struct CountAbove {
  Span<const double> values;
  double bounds[kBounds];
  TETUNE_HD Counts<kBounds> operator()(Size t) const {
    Counts<kBounds> counts;
    for (int k = 0; k < kBounds; ++k) counts.above[k] = values[t] > bounds[k] ? 1 : 0;
    return counts;
  }
};

/// The bounds that the next steps of a bisection of [low, high] may try, as a binary tree: below that of node k the
/// step after it tries node 2 k + 1, above it node 2 k + 2.
template <int kBounds>
void fill_bisection(double (&bounds)[kBounds], int node, double low, double high) {
  if (node >= kBounds) return;
  bounds[node] = std::sqrt(low * high);
  fill_bisection(bounds, 2 * node + 1, low, bounds[node]);
  fill_bisection(bounds, 2 * node + 2, bounds[node], high);
}

/// Clears the values of tetrahedra without a flagged vertex.
struct ClearOutside {
  HasFlaggedVertex is_inside;
  Span<double> values;
  TETUNE_HD void operator()(Size t) const {
    if (values[t] != 0 && !is_inside(t)) values[t] = 0;
  }
};

struct FlagVertices {
  Span<const Tet> tets;
  Span<const Index> slots;
  Span<std::uint8_t> flags;
  TETUNE_HD void operator()(Size i) const {
    for (int k = 0; k < 4; ++k) backend::store_shared(flags[tets[slots[i]][k]], std::uint8_t{1});
  }
};

struct FlagVerticesOfExtreme {
  RatedMesh mesh;
  FlagVertices flag;
  double cost;
  TETUNE_HD void operator()(Size i) const {
    if (dihedral_cots(mesh, flag.slots[i]).cost(mesh.obtuse_weight) > cost) flag(i);
  }
};

/// Flags the neighbors of vertices whose flag is 1 with 2, so that they do not count as flagged while the kernel runs.
struct FlagNeighbors {
  MeshView mesh;
  Span<std::uint8_t> flags;
  TETUNE_HD void operator()(Size t) const {
    if (!mesh.alive(t)) return;
    const Tet tet = mesh.tet2vertex[t];
    bool has_flagged = false;
    for (int k = 0; k < 4; ++k) has_flagged = has_flagged || backend::load_shared(flags[tet[k]]) == 1;
    for (int k = 0; k < 4 && has_flagged; ++k) {
      if (backend::load_shared(flags[tet[k]]) == 0) {
        backend::store_shared(flags[tet[k]], std::uint8_t{2});
      }
    }
  }
};

}  // namespace element_selection_detail

/// Returns the slots for which a predicate holds.
template <class Backend, class Predicate>
BufferOf<Backend, Index> find_tets(const Backend& backend, WorkMesh<Backend>& mesh, const Predicate& predicate) {
  BufferOf<Backend, Index> tets(backend, mesh.slots());
  tets.resize(backend, backend.compact(mesh.slots(), predicate, tets.span()));
  return tets;
}

/// Returns the slots whose value is above `bound`; `values` has one entry per slot.
template <class Backend>
BufferOf<Backend, Index> tets_above(const Backend& backend, WorkMesh<Backend>& mesh, Span<const double> values,
                                    double bound) {
  return find_tets(backend, mesh, IsAbove{values, bound});
}

/// Returns the tetrahedra that have a flagged vertex.
template <class Backend>
BufferOf<Backend, Index> tets_with_flagged_vertex(const Backend& backend, WorkMesh<Backend>& mesh,
                                                  Span<const std::uint8_t> flags) {
  return find_tets(backend, mesh, HasFlaggedVertex{mesh.view(), flags});
}

/// Clears the values, one per slot, of the tetrahedra that have no flagged vertex.
template <class Backend>
void clear_outside(const Backend& backend, WorkMesh<Backend>& mesh, Span<const std::uint8_t> flags,
                   Span<double> values) {
  backend.for_each(mesh.slots(), element_selection_detail::ClearOutside{{mesh.view(), flags}, values});
}

/// The largest result of upper_quantile().
inline constexpr double kMaxQuantile = 1e6;

/// Returns the largest x, to within the fraction `resolution`, such that more than `max_above` of the values exceed
/// value_of(x), or 1: values that are equal are not separated. By bisection of the logarithm of x.
template <class Backend, class ValueOf = std::identity>
double upper_quantile(const Backend& backend, Span<const double> values, double max_above, double resolution = 0.01,
                      const ValueOf& value_of = {}) {
  using namespace element_selection_detail;
  double low = 1;
  double high = kMaxQuantile;
  // A device tries all bounds of several steps at once, as the host waits for each result.
  constexpr int kStepsAtOnce = 4;
  constexpr int kBounds = Backend::kIsAsynchronous ? (1 << kStepsAtOnce) - 1 : 1;
  while (high > (1 + resolution) * low) {
    double x[kBounds];
    fill_bisection(x, 0, low, high);
    CountAbove<kBounds> count{values, {}};
    for (int node = 0; node < kBounds; ++node) count.bounds[node] = value_of(x[node]);
    const auto counts = backend.template reduce<Counts<kBounds>>(values.size(), count);
    for (int node = 0; node < kBounds && high > (1 + resolution) * low;) {
      const bool is_below = static_cast<double>(counts.above[node]) > std::floor(max_above);
      (is_below ? low : high) = x[node];
      node = 2 * node + (is_below ? 2 : 1);
    }
  }
  return low;
}

/// Flags the vertices of the listed tetrahedra.
template <class Backend>
void flag_vertices(const Backend& backend, WorkMesh<Backend>& mesh, Span<const Index> tets, Span<std::uint8_t> flags) {
  backend.for_each(tets.size(), element_selection_detail::FlagVertices{mesh.tet2vertex.span(), tets, flags});
}

/// Flags the vertices of the listed tetrahedra whose dihedral angles exceed a cost.
template <class Backend>
void flag_vertices_of_extreme(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                              Span<const Index> tets, double cost, Span<std::uint8_t> flags) {
  backend.for_each(tets.size(), element_selection_detail::FlagVerticesOfExtreme{
                                    rated(mesh, criterion), {mesh.tet2vertex.span(), tets, flags}, cost});
}

/// Flags the vertices that share a tetrahedron with one that is flagged with 1, with 2: the worst tetrahedra improve
/// only if the vertices around them make room.
template <class Backend>
void flag_neighbors(const Backend& backend, WorkMesh<Backend>& mesh, Span<std::uint8_t> flags) {
  backend.for_each(mesh.slots(), element_selection_detail::FlagNeighbors{mesh.view(), flags});
}

}  // namespace tetune
