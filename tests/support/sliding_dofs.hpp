// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "boundary/sliding/features.hpp"
#include "mesh/constrained_edges.hpp"
#include "support/work.hpp"
#include "tetune/optimize.hpp"

/// Where vertices may go with Boundary::slide.
namespace tetune::test {

/// The report of a run that moves no vertex: it counts the vertices by degrees of freedom.
inline Report classify_sliding(TetMesh mesh, double feature_angle = 45, double max_deviation = 0) {
  Options options;
  options.boundary = Boundary::slide;
  options.feature_angle = feature_angle;
  options.max_deviation = max_deviation;
  options.max_iterations = 0;
  options.threads = 1;
  return optimize(mesh, options);
}

inline void expect_dofs(const Report& r, std::int64_t fixed, std::int64_t curve, std::int64_t surface,
                        std::int64_t free) {
  EXPECT_EQ(r.fixed_vertices, fixed);
  EXPECT_EQ(r.curve_vertices, curve);
  EXPECT_EQ(r.surface_vertices, surface);
  EXPECT_EQ(r.free_vertices, free);
  EXPECT_EQ(r.plane_vertices + r.line_vertices, 0);
}

/// The reference surface of a mesh without lists, and the degrees of freedom of its vertices.
struct Sliding {
  CpuMesh work;
  Surface<backend::Cpu> surface;
  ReferenceSurface<backend::Cpu> reference;
  std::vector<VertexDof> dof;

  explicit Sliding(const TetMesh& mesh, double feature_angle) : work(to_work(mesh)) {
    const backend::Cpu cpu(1);
    build_adjacency(cpu, work);
    test::lock_interfaces(cpu, work, mesh);
    const ListedTriangles listed{};
    backend::Cpu::Buffer<Listed> state;
    build_surface(cpu, work, listed, state, surface);
    const EdgeSet<backend::Cpu> none(cpu, {}, work.vertices());
    backend::Cpu::Buffer<VertexConstraint> constraints;
    constraints.upload(cpu, std::vector<VertexConstraint>(mesh.points.size(), VertexConstraint::none));
    backend::Cpu::Buffer<VertexDof> buffer(cpu, work.vertices());
    build_reference(cpu, work, ConstrainedSurface<backend::Cpu>{surface, none, constraints.span()}, feature_angle,
                    buffer.span(), reference);
    dof = buffer.download();
  }
};

/// A vertex of cube(n) by its place in the grid.
inline Index cube_vertex(int n, int i, int j, int k) { return static_cast<Index>((k * (n + 1) + j) * (n + 1) + i); }

}  // namespace tetune::test
