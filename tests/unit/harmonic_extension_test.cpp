// SPDX-License-Identifier: Apache-2.0
// The harmonic extension against a dense solver with a matrix that is assembled tetrahedron by tetrahedron.
#include "phases/motion/harmonic_extension.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "emulation/emulation.hpp"
#include "support/meshes.hpp"
#include "support/work.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

constexpr double kTolerance = 1e-10;

/// A problem: freedom of the vertices, and displacements of the fixed ones.
struct Problem {
  TetMesh mesh;
  std::vector<VertexDof> dof;
  std::vector<Vec3> axis;
  std::vector<Vec3> displacement;
};

bool on_side(double x) { return x == 0 || x == 1; }

/// A cube whose vertices on sides x = 0 and x = 1 are given, and slide on the other four.
Problem cube_problem(int n) {
  Problem p{test::scrambled(test::cube(n, 0.2, 2), 3, 1), {}, {}, {}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(-0.1, 0.1);
  for (const Point3& x : p.mesh.points) {
    Vec3 d{0, 0, 0};
    Vec3 axis{0, 0, 0};
    VertexDof dof = VertexDof::free;
    if (on_side(x[0])) {
      dof = VertexDof::fixed;
      d = {part(random), part(random), part(random)};
    } else if (on_side(x[1]) && on_side(x[2])) {
      dof = VertexDof::line;
      axis = {1, 0, 0};
    } else if (on_side(x[1]) || on_side(x[2])) {
      dof = VertexDof::plane;
      // Not along a coordinate axis, so that the components depend on each other.
      axis = on_side(x[1]) ? Vec3{0.6, 0.8, 0} : Vec3{0, 0.28, 0.96};
    }
    p.dof.push_back(dof);
    p.axis.push_back(axis);
    p.displacement.push_back(d);
  }
  return p;
}

template <class Backend>
std::vector<Vec3> solve(const Backend& backend, const Problem& p, double tolerance, int* iterations = nullptr) {
  WorkMesh<Backend> mesh = upload_mesh(backend, p.mesh);
  Rings<Backend> rings;
  build_rings(backend, mesh, rings);
  BufferOf<Backend, VertexDof> dof;
  BufferOf<Backend, Vec3> axis;
  dof.upload(backend, p.dof);
  axis.upload(backend, p.axis);
  BufferOf<Backend, Vec3> displacement;
  displacement.upload(backend, p.displacement);
  Stiffness<Backend> stiffness;
  assemble_stiffness(backend, mesh, rings.view(), stiffness);
  const int done = extend_harmonically(backend, stiffness, {dof.span(), axis.span()}, tolerance, 10000, displacement);
  if (iterations != nullptr) *iterations = done;
  return displacement.download();
}

/// Minimizes the sum over tetrahedra of |grad d|^2 by Gaussian elimination in the admissible directions of each vertex.
std::vector<Vec3> solve_densely(const Problem& p) {
  struct Unknown {
    Size vertex;
    Vec3 direction;
  };
  std::vector<Unknown> unknowns;
  for (Size v = 0; v < std::ssize(p.dof); ++v) {
    const VertexDof dof = span_of(p.dof)[v];
    if (dof == VertexDof::line) unknowns.push_back({v, span_of(p.axis)[v]});
    if (dof == VertexDof::plane) {
      const PlaneBasis basis = plane_basis(span_of(p.axis)[v]);
      unknowns.push_back({v, basis.u});
      unknowns.push_back({v, basis.v});
    }
    if (dof == VertexDof::free) {
      for (const Vec3& e : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) unknowns.push_back({v, e});
    }
  }
  const std::size_t vertices = p.dof.size();
  std::vector<std::vector<double>> k(vertices, std::vector<double>(vertices, 0));
  for (const auto& tet : p.mesh.tets) {
    Vec3 x[4];
    for (std::size_t i = 0; i < 4; ++i) x[i] = vec(p.mesh.points[to_size_t(tet[i])]);
    Vec3 gradient[4];
    for (int i = 0; i < 4; ++i) {
      const Vec3& a = x[(i + 1) % 4];
      const Vec3 n = cross(x[(i + 2) % 4] - a, x[(i + 3) % 4] - a);
      gradient[i] = (1 / dot(n, x[i] - a)) * n;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) k[to_size_t(tet[i])][to_size_t(tet[j])] += dot(gradient[i], gradient[j]);
    }
  }
  const std::size_t n = unknowns.size();
  std::vector<std::vector<double>> a(n, std::vector<double>(n + 1, 0));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      a[i][j] = k[to_size_t(unknowns[i].vertex)][to_size_t(unknowns[j].vertex)] *
                dot(unknowns[i].direction, unknowns[j].direction);
    }
    for (std::size_t v = 0; v < vertices; ++v) {
      if (p.dof[v] == VertexDof::fixed) {
        a[i][n] -= k[to_size_t(unknowns[i].vertex)][v] * dot(unknowns[i].direction, p.displacement[v]);
      }
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t row = i + 1; row < n; ++row) {  // the matrix is positive definite
      const double factor = a[row][i] / a[i][i];
      for (std::size_t j = i; j <= n; ++j) a[row][j] -= factor * a[i][j];
    }
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t j = i + 1; j < n; ++j) a[i][n] -= a[i][j] * a[j][n];
    a[i][n] /= a[i][i];
  }
  std::vector<Vec3> d = p.displacement;
  for (std::size_t i = 0; i < n; ++i) {
    Vec3& at = d[to_size_t(unknowns[i].vertex)];
    at = at + a[i][n] * unknowns[i].direction;
  }
  return d;
}

double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0;
  for (Size v = 0; v < std::ssize(a); ++v) largest = std::max(largest, norm(span_of(a)[v] - span_of(b)[v]));
  return largest;
}

TEST(HarmonicExtension, AgreesWithADenseSolver) {
  const Problem p = cube_problem(5);
  int iterations = 0;
  const std::vector<Vec3> d = solve(backend::Cpu(2), p, kTolerance, &iterations);
  EXPECT_LT(largest_difference(d, solve_densely(p)), 1e-8);
  EXPECT_GT(iterations, 10);
  EXPECT_LT(iterations, 1000);
}

TEST(HarmonicExtension, SameBitsForAnyNumberOfThreadsAndEmulated) {
  const Problem p = cube_problem(9);
  const std::vector<Vec3> one = solve(backend::Cpu(1), p, kTolerance);
  EXPECT_EQ(largest_difference(solve(backend::Cpu(3), p, kTolerance), one), 0);
  EXPECT_LT(largest_difference(solve(backend::Emulation(1), p, kTolerance), one), 1e-7);
}

/// A rigid translation is exact whatever the elements' sizes, and takes no iteration from the right start.
TEST(HarmonicExtension, ReproducesATranslation) {
  Problem p = cube_problem(4);
  const Vec3 shift{0.3, 0, 0};
  for (std::size_t v = 0; v < p.dof.size(); ++v) {
    if (p.dof[v] == VertexDof::plane) p.axis[v] = on_side(p.mesh.points[v][1]) ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    p.displacement[v] = p.dof[v] == VertexDof::fixed ? shift : Vec3{0, 0, 0};
  }
  std::vector<Vec3> expected(p.dof.size(), shift);
  EXPECT_LT(largest_difference(solve(backend::Cpu(1), p, kTolerance), expected), 1e-8);
  p.displacement = expected;
  int iterations = -1;
  EXPECT_LT(largest_difference(solve(backend::Cpu(1), p, 1e-6, &iterations), expected), 1e-15);
  EXPECT_EQ(iterations, 0);
}

/// Volumes that round to 0 or below would make the matrix infinite or indefinite.
TEST(HarmonicExtension, FlatTetrahedraMoveWithTheOthers) {
  Problem p = cube_problem(4);
  const auto is_inner = [](const Point3& x) { return !on_side(x[0]) && !on_side(x[1]) && !on_side(x[2]); };
  const Index inner =
      to_index(std::find_if(p.mesh.points.begin(), p.mesh.points.end(), is_inner) - p.mesh.points.begin());
  const auto has_inner = [inner](const auto& tet) { return std::find(tet.begin(), tet.end(), inner) != tet.end(); };
  const auto& tet = *std::find_if(p.mesh.tets.begin(), p.mesh.tets.end(), has_inner);
  Vec3 centroid{0, 0, 0};
  for (const Index v : tet) {
    if (v != inner) centroid = centroid + (1.0 / 3) * vec(p.mesh.points[to_size_t(v)]);
  }
  p.mesh.points[to_size_t(inner)] = to_point(centroid);
  ASSERT_LT(quality(p.mesh).dihedral_min, 1e-6);
  const Vec3 shift{0.3, 0, 0};
  for (std::size_t v = 0; v < p.dof.size(); ++v) {
    if (p.dof[v] == VertexDof::plane) p.axis[v] = on_side(p.mesh.points[v][1]) ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    p.displacement[v] = p.dof[v] == VertexDof::fixed ? shift : Vec3{0, 0, 0};
  }
  int iterations = 0;
  const std::vector<Vec3> moved = solve(backend::Cpu(1), p, kTolerance, &iterations);
  EXPECT_LT(largest_difference(moved, std::vector<Vec3>(p.dof.size(), shift)), 1e-4);
  EXPECT_GT(iterations, 10);
  EXPECT_LT(iterations, 1000);
}

/// Nothing is prescribed, or a vertex is in no tetrahedron: all stays.
TEST(HarmonicExtension, NothingMoves) {
  Problem p = cube_problem(3);
  p.mesh.points.push_back({5, 5, 5});
  p.dof.push_back(VertexDof::free);
  p.axis.push_back({0, 0, 0});
  p.displacement.assign(p.dof.size(), Vec3{0, 0, 0});
  const std::vector<Vec3> zero = p.displacement;
  EXPECT_EQ(largest_difference(solve(backend::Cpu(1), p, kTolerance), zero), 0);
}

}  // namespace
}  // namespace tetune
