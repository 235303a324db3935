// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "boundary/boundary_triangles.hpp"
#include "boundary/classify.hpp"
#include "mesh/id_maps.hpp"
#include "operators/engine/active_set.hpp"
#include "operators/flips/boundary_flip.hpp"
#include "operators/flips/flip_energy.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/work.hpp"
#include "tetune/validate.hpp"

/// Flips in the boundary: a fixture, fans of tetrahedra on a plane, and an oracle for their triangulation.
namespace tetune::test {

using backend::Cpu;

/// A mesh with its boundary, as load() finds it.
struct BoundaryFlips {
  TetMesh original;
  Cpu cpu;
  CpuMesh work;
  Criterion criterion;
  FlipState<Cpu> state;
  BoundaryTriangles<Cpu> boundary;
  std::vector<std::uint8_t> active;
  double energy = 0;

  explicit BoundaryFlips(const TetMesh& mesh, const std::vector<Index>& frozen = {},
                         const std::vector<std::array<Index, 2>>& constrained = {}, int threads = 1)
      : original(mesh), cpu(threads), work(to_work(mesh)) {
    build_adjacency(cpu, work);
    lock_interfaces(cpu, work, mesh);
    std::vector<std::uint64_t> keys;
    std::vector<std::uint8_t> on_edge(mesh.points.size(), 0);
    for (const auto& e : constrained) {
      keys.push_back(ConstrainedEdges::edge_key(e[0], e[1]));
      for (const Index v : e) on_edge[static_cast<std::size_t>(v)] = 1;
    }
    state.constrained_keys.upload(cpu, keys);
    state.constrained_vertex.upload(cpu, on_edge);
    const std::vector<Index> vertices = identity_map(mesh.points.size());
    const ListedTriangles listed{
        {reinterpret_cast<const Index*>(mesh.triangles.data()), 3 * static_cast<Size>(mesh.triangles.size())},
        {mesh.triangle_tags.data(), static_cast<Size>(mesh.triangle_tags.size())},
        {},
        {},
        {vertices.data(), static_cast<Size>(vertices.size())},
        false};
    Cpu::Buffer<Listed> state_buffer;
    Surface<Cpu> surface;
    build_surface(cpu, work, listed, state_buffer, surface);
    std::vector<VertexConstraint> held(mesh.points.size(), VertexConstraint::none);
    for (const Index v : frozen) held[static_cast<std::size_t>(v)] = VertexConstraint::frozen;
    build_boundary(cpu, surface, listed, Span<const VertexConstraint>(held.data(), static_cast<Size>(held.size())),
                   boundary);
    active.assign(mesh.points.size(), 1);
    energy = refresh_energy(cpu, work, criterion, state.energies);
    activate_all(cpu, work, criterion, state);
  }
  PassResult pass() {
    return boundary_flip_pass(cpu, work, criterion, state, boundary, {},
                              {active.data(), static_cast<Size>(active.size())});
  }
  /// The listed triangles of the mesh after the flips.
  std::vector<std::array<Index, 3>> listed_now(const TetMesh& mesh) {
    std::vector<std::array<Index, 3>> now = mesh.triangles;
    const std::vector<Index> same = identity_map(mesh.points.size());
    for (const auto& [entry, triangle] : follow_changes(boundary.triangles.download(), same, mesh.triangles).changes) {
      now[static_cast<std::size_t>(entry)] = triangle;
    }
    return now;
  }
  /// The outer faces, each turned as its tetrahedron has it and from its lowest vertex on.
  std::set<std::array<Index, 3>> faces() {
    std::set<std::array<Index, 3>> all;
    each_face([&](const std::array<Index, 3>& v, HalfFace link) {
      if (link == kNoHalfFace) all.insert(from_lowest(v));
    });
    return all;
  }
  /// The faces that must stay inside, sorted.
  std::set<std::array<Index, 3>> inner_faces() {
    std::set<std::array<Index, 3>> all;
    each_face([&](const std::array<Index, 3>& v, HalfFace link) {
      if (link != kNoHalfFace && is_locked(link)) all.insert(ascending(v));
    });
    return all;
  }
  template <class Visit>
  void each_face(const Visit& visit) {
    for (Size t = 0; t < work.slots(); ++t) {
      for (int f = 0; f < 4 && work.view().alive(t); ++f) {
        std::array<Index, 3> v{};
        for (int k = 0; k < 3; ++k) v[static_cast<std::size_t>(k)] = work.view().tet2vertex[t][face_vertex(f, k)];
        visit(v, work.view().tet2tet[t][f]);
      }
    }
  }
  static std::array<Index, 3> from_lowest(std::array<Index, 3> v) {
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    return v;
  }
  TetMesh result() { return from_work(work, original); }
  void expect_consistent() {
    EXPECT_EQ(check_adjacency(work), "");
    const ValidationReport report = validate(result());
    EXPECT_TRUE(report.ok()) << report.message(false);
    const auto inside = inner_faces();
    std::set<std::array<Index, 3>> outer_triangles;
    std::set<std::array<Index, 3>> inner_triangles;
    for (const BoundaryTriangle& t : boundary.triangles.download()) {
      if (const auto v = ascending(std::array{t.v[0], t.v[1], t.v[2]}); inside.count(v) == 1) {
        inner_triangles.insert(v);
      } else {
        outer_triangles.insert(from_lowest({t.v[0], t.v[1], t.v[2]}));
      }
    }
    EXPECT_EQ(outer_triangles, faces());
    EXPECT_EQ(inner_triangles, inside);
    EXPECT_NEAR(refresh_energy(cpu, work, criterion, state.energies), energy, 1e-9 * energy);
  }
};

/// A fan of n tetrahedra around the edge (0, 1) on the plane z = 0, from vertex 2 on; the vertices of its half ring are
/// shaken. Its two triangles on the plane are flat to the last bit.
inline TetMesh fan(int n, std::uint32_t seed, double height = 0) {
  std::mt19937 random(seed);
  const auto uniform = [&random] { return test::uniform(random); };
  TetMesh m;
  m.points = {{0.3 * uniform(), -1.5 - uniform(), 0}, {0.3 * uniform(), 1.5 + uniform(), 0}};
  for (int i = 0; i <= n; ++i) {
    const bool in_plane = i == 0 || i == n;
    const double angle = std::numbers::pi * (i + (in_plane ? 0 : 0.3 * (uniform() - 0.5))) / n;
    const double radius = 0.7 + 0.6 * uniform();
    m.points.push_back({-radius * std::cos(angle), 0.6 * uniform() - 0.3, in_plane ? 0 : radius * std::sin(angle)});
  }
  m.points.back()[2] = height;
  for (int i = 0; i < n; ++i) m.tets.push_back({0, static_cast<Index>(2 + i), static_cast<Index>(3 + i), 1});
  return with_tags(m);
}

/// Plain oracle: the least energy over all triangulations of the places i..k of a polygon around the edge (0, 1).
inline double least_energy(const TetMesh& m, const std::vector<Index>& polygon, std::size_t i, std::size_t k) {
  if (k == i + 1) return 0;
  const auto p = [&m](Index v) { return at(m, v); };
  double least = kInfeasible;
  for (std::size_t j = i + 1; j < k; ++j) {
    const Vec3 r[3] = {p(polygon[i]), p(polygon[j]), p(polygon[k])};
    const TetEnergy below = tet_energy(kHarmonicObjective, p(0), r[0], r[1], r[2]);
    const TetEnergy above = tet_energy(kHarmonicObjective, p(1), r[0], r[2], r[1]);
    if (!below.certified || !above.certified) continue;
    least =
        std::min(least, least_energy(m, polygon, i, j) + least_energy(m, polygon, j, k) + below.energy + above.energy);
  }
  return least;
}
inline double least_energy(const TetMesh& m, const std::vector<Index>& polygon) {
  return least_energy(m, polygon, 0, polygon.size() - 1);
}

/// The polygon of fan().
inline std::vector<Index> fan_polygon(int n) {
  std::vector<Index> polygon;
  for (Index v = 2; v <= n + 2; ++v) polygon.push_back(v);
  return polygon;
}

}  // namespace tetune::test
