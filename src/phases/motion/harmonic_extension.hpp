// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "boundary/vertex_dofs.hpp"
#include "mesh/csr.hpp"
#include "relocation/rings.hpp"

/// The extension of a displacement from some vertices to all others by a discrete Laplace equation (docs/method.md,
/// "Moving a mesh").
namespace tetune {

/// The stiffness matrix: the entry of vertex v and its neighbor columns[i] is values[i], for i from offsets[v] to
/// offsets[v + 1] - 1.
struct StiffnessView {
  Span<const std::uint32_t> offsets;
  Span<const Index> columns;
  Span<const double> values;
  Span<const double> diagonal;
};

template <class Backend>
struct Stiffness {
  BufferOf<Backend, std::uint32_t> offsets;
  BufferOf<Backend, Index> columns;
  BufferOf<Backend, double> values;
  BufferOf<Backend, double> diagonal;
  StiffnessView view() const { return {offsets.span(), columns.span(), values.span(), diagonal.span()}; }
};

/// Where each vertex may go: VertexDof::surface and curve count as fixed.
struct MotionSpaces {
  Span<const VertexDof> dof;
  Span<const Vec3> axis;  ///< see MotionSpace
};

namespace harmonic_extension_detail {

struct IndexLess {
  TETUNE_HD bool operator()(Index a, Index b) const { return a < b; }
};

/// Writes the neighbors of a vertex, sorted and each once, to the place of its ring's faces, and counts them.
struct ListNeighbors {
  RingsView rings;
  Span<Index> neighbors;  ///< three per face
  Span<std::uint32_t> counts;
  TETUNE_HD void operator()(Size v) const {
    const Size begin = rings.offsets[v];
    const Size faces = rings.offsets[v + 1] - begin;
    if (faces == 0) {
      counts[v] = 0;
      return;
    }
    Index* row = neighbors.data() + 3 * begin;
    for (Size f = 0; f < faces; ++f) {
      for (int k = 0; k < 3; ++k) row[3 * f + k] = rings.faces[begin + f].v[k];
    }
    sort_small(row, 3 * faces, IndexLess{});
    Size n = 1;
    for (Size i = 1; i < 3 * faces; ++i) {
      if (row[i] != row[n - 1]) row[n++] = row[i];
    }
    counts[v] = static_cast<std::uint32_t>(n);
  }
};

/// Fills one row: per tetrahedron (v, p0, p1, p2) with w = 6 V the entries n_v . n_j / w^2, where n_i is w times the
/// gradient of the linear basis function of vertex i. w counts as at least kMinVolume times the cube of the longest
/// edge: it may round to 0, and rounding errors of larger entries would be as large as the entries of other tetrahedra.
struct FillRow {
  Span<const Point> points;
  RingsView rings;
  Span<const Index> neighbors;
  Span<const std::uint32_t> offsets;
  Span<Index> columns;
  Span<double> values;
  Span<double> diagonal;
  TETUNE_HD void operator()(Size v) const {
    const Size row = offsets[v];
    const Size length = offsets[v + 1] - row;
    const Size first_neighbor = 3 * Size{rings.offsets[v]};  // may exceed 32 bits
    for (Size i = 0; i < length; ++i) {
      columns[row + i] = neighbors[first_neighbor + i];
      values[row + i] = 0;
    }
    double sum = 0;
    for (Size f = rings.offsets[v]; f < rings.offsets[v + 1]; ++f) sum += add(v, rings.faces[f].v, row, length);
    diagonal[v] = sum;
  }

 private:
  static constexpr double kMinVolume = 1e-6;

  /// Adds the entries of one tetrahedron, and returns that of the diagonal.
  TETUNE_HD double add(Size v, const Index* face, Size row, Size length) const {
    const Vec3 x = vec(points[v]);
    const Vec3 e[3] = {vec(points[face[0]]) - x, vec(points[face[1]]) - x, vec(points[face[2]]) - x};
    Vec3 n[3];
    for (int k = 0; k < 3; ++k) n[k] = cross(e[(k + 1) % 3], e[(k + 2) % 3]);
    const double min_volume = kMinVolume * cube_of_longest_edge(e, face);
    const double volume = dot(n[0], e[0]);
    const double inverse = 1 / (volume > min_volume ? volume : min_volume);
    for (int k = 0; k < 3; ++k) n[k] = inverse * n[k];
    const Vec3 own = -1.0 * (n[0] + n[1] + n[2]);
    for (int k = 0; k < 3; ++k) values[row + position(face[k], row, length)] += dot(own, n[k]);
    return dot(own, own);
  }
  /// Has the same bits for all four vertices of a tetrahedron, so that the matrix is symmetric.
  TETUNE_HD double cube_of_longest_edge(const Vec3 (&from_vertex)[3], const Index* face) const {
    double longest2 = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 opposite = vec(points[face[k]]) - vec(points[face[(k + 1) % 3]]);
      const double own2 = dot(from_vertex[k], from_vertex[k]);
      const double opposite2 = dot(opposite, opposite);
      const double longer2 = own2 > opposite2 ? own2 : opposite2;
      longest2 = longer2 > longest2 ? longer2 : longest2;
    }
    return longest2 * std::sqrt(longest2);
  }
  TETUNE_HD Size position(Index column, Size row, Size length) const {
    Size low = 0;
    for (Size high = length; high - low > 1;) {
      const Size middle = (low + high) / 2;
      (columns[row + middle] <= column ? low : high) = middle;
    }
    return low;
  }
};

/// The linear system of the unknown displacements.
struct System {
  StiffnessView stiffness;
  Span<const VertexDof> dof;
  Span<const Vec3> axis;

  /// Row v of the product of the matrix and `d`, within the space of motion.
  TETUNE_HD Vec3 product(Size v, Span<const Vec3> d) const {
    if (dof[v] == VertexDof::fixed) return {0, 0, 0};
    Vec3 sum = stiffness.diagonal[v] * d[v];
    for (Size i = stiffness.offsets[v]; i < stiffness.offsets[v + 1]; ++i) {
      sum = sum + stiffness.values[i] * d[stiffness.columns[i]];
    }
    return project(v, sum);
  }
  /// The part of a vector within the space of motion of a vertex.
  TETUNE_HD Vec3 project(Size v, const Vec3& d) const {
    return tetune::project(d, motion_space(dof, axis, to_index(v)));
  }
  /// Jacobi's preconditioner. A vertex of no tetrahedron stays.
  TETUNE_HD Vec3 precondition(Size v, const Vec3& r) const {
    const double d = stiffness.diagonal[v];
    return d > 0 ? (1 / d) * r : Vec3{0, 0, 0};
  }
};

/// Sets the first residual and search direction.
struct StartSolver {
  System system;
  Span<const Vec3> displacement;
  Span<Vec3> residual;
  Span<Vec3> direction;
  TETUNE_HD Sum<double> operator()(Size v) const {
    const Vec3 r = -1.0 * system.product(v, displacement);
    const Vec3 z = system.precondition(v, r);
    residual[v] = r;
    direction[v] = z;
    return {dot(r, z)};
  }
};

struct Multiply {
  System system;
  Span<const Vec3> direction;
  Span<Vec3> product;
  TETUNE_HD Sum<double> operator()(Size v) const {
    const Vec3 q = system.product(v, direction);
    product[v] = q;
    return {dot(direction[v], q)};
  }
};

struct Advance {
  System system;
  double step;
  Span<const Vec3> direction;
  Span<const Vec3> product;
  Span<Vec3> displacement;
  Span<Vec3> residual;
  TETUNE_HD Sum<double> operator()(Size v) const {
    displacement[v] = displacement[v] + step * direction[v];
    const Vec3 r = residual[v] - step * product[v];
    residual[v] = r;
    return {dot(r, system.precondition(v, r))};
  }
};

struct NextDirection {
  System system;
  double weight;
  Span<const Vec3> residual;
  Span<Vec3> direction;
  TETUNE_HD void operator()(Size v) const {
    direction[v] = system.precondition(v, residual[v]) + weight * direction[v];
  }
};

/// The square of the norm of the right-hand side: the residual where no unknown vertex moves.
struct RightHandSide {
  System system;
  Span<const Vec3> displacement;
  TETUNE_HD Sum<double> operator()(Size v) const {
    if (system.dof[v] == VertexDof::fixed) return {};
    Vec3 sum{0, 0, 0};
    for (Size i = system.stiffness.offsets[v]; i < system.stiffness.offsets[v + 1]; ++i) {
      const Index j = system.stiffness.columns[i];
      if (system.dof[j] == VertexDof::fixed) sum = sum + system.stiffness.values[i] * displacement[j];
    }
    const Vec3 r = system.project(v, sum);
    return {dot(r, system.precondition(v, r))};
  }
};

/// Projects the initial guess into the space of motion.
struct ProjectGuess {
  System system;
  Span<Vec3> displacement;
  TETUNE_HD void operator()(Size v) const {
    if (system.dof[v] != VertexDof::fixed) displacement[v] = system.project(v, displacement[v]);
  }
};

}  // namespace harmonic_extension_detail

/// Assembles the stiffness matrix of linear elements with the weight 1 / V per tetrahedron, so that small elements keep
/// their shape at the expense of large ones. Requires the rings of all vertices.
template <class Backend>
void assemble_stiffness(const Backend& backend, WorkMesh<Backend>& mesh, const RingsView& rings,
                        Stiffness<Backend>& stiffness) {
  using namespace harmonic_extension_detail;
  const Size vertices = mesh.vertices();
  BufferOf<Backend, Index> neighbors(backend, 3 * rings.faces.size());
  BufferOf<Backend, std::uint32_t> counts(backend, vertices + 1);
  backend.fill(counts.span(), std::uint32_t{0});
  backend.for_each(vertices, ListNeighbors{rings, neighbors, counts});
  stiffness.offsets.resize(backend, vertices + 1);
  const Size entries = backend.exclusive_scan(Span<const std::uint32_t>(counts.span()), stiffness.offsets.span());
  stiffness.columns.resize(backend, entries);
  stiffness.values.resize(backend, entries);
  stiffness.diagonal.resize(backend, vertices);
  backend.for_each(vertices, FillRow{mesh.points, rings, neighbors, stiffness.offsets, stiffness.columns,
                                     stiffness.values, stiffness.diagonal});
}

/// Solves for the displacements of all vertices that may move, by conjugate gradients; those of fixed vertices are
/// given. `displacement` holds these and an initial guess. Ends when the preconditioned norm of the residual is
/// `tolerance` times that of the right-hand side. Returns the number of iterations.
template <class Backend>
int extend_harmonically(const Backend& backend, const Stiffness<Backend>& stiffness, const MotionSpaces& spaces,
                        double tolerance, int max_iterations, BufferOf<Backend, Vec3>& displacement) {
  using namespace harmonic_extension_detail;
  const Size n = displacement.size();
  const System system{stiffness.view(), spaces.dof, spaces.axis};
  const Span<Vec3> d = displacement.span();
  BufferOf<Backend, Vec3> residual(backend, n);
  BufferOf<Backend, Vec3> direction(backend, n);
  BufferOf<Backend, Vec3> product(backend, n);
  backend.for_each(n, ProjectGuess{system, d});
  const double bound = tolerance * tolerance * backend.template reduce<Sum<double>>(n, RightHandSide{system, d}).value;
  double rz = backend.template reduce<Sum<double>>(n, StartSolver{system, d, residual, direction}).value;
  int iteration = 0;
  while (rz > bound && iteration < max_iterations && !backend.stop_requested()) {
    const double curvature = backend.template reduce<Sum<double>>(n, Multiply{system, direction, product}).value;
    if (!(curvature > 0)) break;  // rounding
    const double last = rz;
    rz =
        backend.template reduce<Sum<double>>(n, Advance{system, rz / curvature, direction, product, d, residual}).value;
    backend.for_each(n, NextDirection{system, rz / last, residual, direction});
    ++iteration;
  }
  return iteration;
}

}  // namespace tetune
