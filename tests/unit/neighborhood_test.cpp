// SPDX-License-Identifier: Apache-2.0
// A neighborhood taken out of a mesh and put back: what it holds, what is fixed in it, and that the mesh stays whole.
#include "phases/restart/neighborhood.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "boundary/sliding/deviation_bound.hpp"
#include "driver/import_mesh.hpp"
#include "phases/restart/restart_worst.hpp"
#include "support/curved.hpp"
#include "support/meshes.hpp"

namespace tetune {
namespace {

using backend::Cpu;

HostWork imported(const TetMesh& mesh, Boundary boundary, double max_deviation = 0) {
  const Cpu backend(1);
  Options options;
  options.max_deviation = max_deviation;
  options.effort = Effort::best;
  options.boundary = boundary;
  WorkingSet<Cpu> work;
  Report report;
  import_mesh(backend, ImportInput{mesh, options}, work, report);
  return HostWork(work);
}

std::array<Index, 3> key_of(const Tet& tet, int face) {
  const FaceKey key = face_key(tet, face);
  return {key.low, key.middle, key.high};
}

/// The largest distance of a sliding vertex from its position in the edited surface.
double drift_of(const HostWork& mesh) {
  double drift = 0;
  for (Size v = 0; v < std::ssize(mesh.checked.edited_points); ++v) {
    if (!slides(span_of(mesh.dof)[v])) continue;
    drift = std::max(drift, norm(vec(span_of(mesh.points)[v]) - vec(span_of(mesh.checked.edited_points)[v])));
  }
  return drift;
}

/// Vertices whose triangles have not changed have one position in the checked and in the edited surface. Inserted ones
/// are none of these.
void expect_edited_as_checked(const HostWork& mesh) {
  const CheckedSurfaceOnHost& checked = mesh.checked;
  ASSERT_EQ(checked.edited_points.size(), checked.points.size());
  ASSERT_EQ(checked.is_edited.size(), checked.points.size());
  for (Size v = 0; v < std::ssize(checked.points); ++v) {
    if (span_of(checked.is_edited)[v] != 0) continue;
    EXPECT_EQ(norm(vec(span_of(checked.edited_points)[v]) - vec(span_of(checked.points)[v])), 0);
    EXPECT_NE(span_of(mesh.vertex2original)[v], kInserted);
  }
}

/// Neighbors name each other and share their face; the triangles of the boundary are the locked faces.
/// Vertices have not drifted by more than the bound allows.
void expect_consistent(const HostWork& mesh) {
  EXPECT_LE(drift_of(mesh), kDriftShare * mesh.max_deviation);
  expect_edited_as_checked(mesh);
  std::map<std::array<Index, 3>, int> locked;
  Size alive = 0;
  for (Size t = 0; t < mesh.slots(); ++t) {
    if (!mesh.alive(t)) continue;
    ++alive;
    const Tet& tet = span_of(mesh.tet2vertex)[t];
    for (int f = 0; f < 4; ++f) {
      const HalfFace across = span_of(mesh.tet2tet)[t][f];
      if (is_locked(across)) locked[key_of(tet, f)] = 0;
      if (across == kNoHalfFace) continue;
      ASSERT_TRUE(mesh.alive(tet_of(across)));
      const HalfFace back = span_of(mesh.tet2tet)[tet_of(across)][face_of(across)];
      EXPECT_EQ(back, make_half_face(to_index(t), f) | (across & kLocked));
      EXPECT_EQ(key_of(span_of(mesh.tet2vertex)[tet_of(across)], face_of(across)), key_of(tet, f));
    }
  }
  EXPECT_EQ(alive, mesh.tets());
  if (mesh.triangles.empty()) return;  // a fixed boundary
  EXPECT_EQ(mesh.triangles.size(), locked.size());
  for (const BoundaryTriangle& t : mesh.triangles) {
    std::array<Index, 3> v{t.v[0], t.v[1], t.v[2]};
    std::sort(v.begin(), v.end());
    ASSERT_TRUE(locked.contains(v));
    EXPECT_EQ(locked[v]++, 0);
  }
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same(const HostWork& a, const HostWork& b) {
  EXPECT_TRUE(same_bytes(a.points, b.points));
  EXPECT_TRUE(same_bytes(a.tet2vertex, b.tet2vertex));
  EXPECT_TRUE(same_bytes(a.tet2tet, b.tet2tet));
  EXPECT_EQ(a.tet2original, b.tet2original);
  EXPECT_EQ(a.vertex2original, b.vertex2original);
  EXPECT_EQ(a.free_slots, b.free_slots);
  EXPECT_EQ(a.dof, b.dof);
  EXPECT_TRUE(same_bytes(a.axis, b.axis));
  EXPECT_TRUE(same_bytes(a.surface_point, b.surface_point));
  EXPECT_TRUE(same_bytes(a.displacement_bound, b.displacement_bound));
  EXPECT_TRUE(same_bytes(a.checked.points, b.checked.points));
  EXPECT_TRUE(same_bytes(a.checked.surface_points, b.checked.surface_points));
  EXPECT_EQ(a.checked.is_edited, b.checked.is_edited);
  EXPECT_TRUE(same_bytes(a.checked.edited_points, b.checked.edited_points));
  EXPECT_TRUE(same_bytes(a.triangles, b.triangles));
  EXPECT_EQ(a.constrained_vertex, b.constrained_vertex);
}

std::vector<TetMesh> meshes() { return {test::cube(4, 0.2), test::two_materials(4, 0.2), test::ball(4)}; }

TEST(Neighborhood, PutBackUnchangedLeavesTheMeshAsItWas) {
  const std::pair<Boundary, double> cases[] = {
      {Boundary::fixed, 0}, {Boundary::preserve, 0}, {Boundary::slide, 0}, {Boundary::slide, 0.1}};
  for (const auto& [boundary, max_deviation] : cases) {
    for (const TetMesh& mesh : meshes()) {
      const HostWork before = imported(mesh, boundary, max_deviation);
      EXPECT_EQ(before.checked.points.empty(), max_deviation == 0);
      HostWork after = before;
      NeighborhoodFinder finder(after);
      for (Index slot = 0; slot < before.slots(); slot += 37) {
        finder.find(slot, 1 + slot % 3);
        Neighborhood neighborhood(after, finder.found(), list_corners(Cpu(1), after));
        EXPECT_EQ(neighborhood.work.mesh.tets(), std::ssize(finder.tets()));
        EXPECT_EQ(neighborhood.work.dofs.max_deviation, before.max_deviation);
        neighborhood.put_back(after);
      }
      expect_same(before, after);
    }
  }
}

TEST(Neighborhood, HasTheTetsOfItsRings) {
  const HostWork mesh = imported(test::cube(5), Boundary::preserve);
  NeighborhoodFinder finder(mesh);
  const Index slot = to_index(mesh.slots() / 2);
  std::vector<std::uint8_t> in_rings(mesh.points.size(), 0);
  for (int k = 0; k < 4; ++k) span_of(in_rings)[span_of(mesh.tet2vertex)[slot][k]] = 1;
  for (int rings = 0; rings < 3; ++rings) {
    const auto has_one = [&](const Tet& tet) {
      return std::any_of(tet.v, tet.v + 4, [&](Index v) { return span_of(in_rings)[v] != 0; });
    };
    finder.find(slot, rings);
    EXPECT_EQ(std::ssize(finder.tets()), std::count_if(mesh.tet2vertex.begin(), mesh.tet2vertex.end(), has_one));
    std::vector<std::uint8_t> next = in_rings;
    for (const Tet& tet : mesh.tet2vertex) {
      for (int k = 0; k < 4 && has_one(tet); ++k) span_of(next)[tet[k]] = 1;
    }
    in_rings = next;
  }
}

TEST(Neighborhood, TouchesAnotherAcrossAFace) {
  const HostWork mesh = imported(test::cube(5), Boundary::preserve);
  NeighborhoodFinder finder(mesh);
  finder.find(0, 1);
  std::vector<std::uint8_t> taken(mesh.tet2vertex.size(), 0);
  std::set<std::array<Index, 3>> faces;
  for (const Index t : finder.tets()) {
    span_of(taken)[t] = 1;
    for (int f = 0; f < 4; ++f) faces.insert(key_of(span_of(mesh.tet2vertex)[t], f));
  }
  Size touching = 0;
  for (Index slot = 0; slot < mesh.slots(); ++slot) {
    finder.find(slot, 0);
    bool shares_face = false;
    for (const Index t : finder.tets()) {
      for (int f = 0; f < 4; ++f) {
        shares_face = shares_face || faces.contains(key_of(span_of(mesh.tet2vertex)[t], f));
      }
    }
    EXPECT_EQ(finder.touches(taken), shares_face);
    touching += shares_face ? 1 : 0;
  }
  EXPECT_GT(touching, std::ssize(faces) / 4);
  EXPECT_LT(touching, mesh.slots());
}

TEST(Neighborhood, FixesTheVerticesThatOthersHaveToo) {
  const HostWork mesh = imported(test::cube(5), Boundary::preserve);
  NeighborhoodFinder finder(mesh);
  finder.find(to_index(mesh.slots() / 2), 1);
  Neighborhood neighborhood(mesh, finder.found(), list_corners(Cpu(1), mesh));
  std::vector<int> tets_at(mesh.points.size(), 0);
  for (const Index t : neighborhood.slots()) {
    for (int k = 0; k < 4; ++k) ++span_of(tets_at)[span_of(mesh.tet2vertex)[t][k]];
  }
  for (const Tet& tet : mesh.tet2vertex) {
    for (int k = 0; k < 4; ++k) --span_of(tets_at)[tet[k]];
  }
  Size free = 0;
  const MeshView part = neighborhood.work.mesh.view();
  for (Size t = 0; t < neighborhood.work.mesh.slots(); ++t) {
    for (int k = 0; k < 4; ++k) {
      const Index of_whole = span_of(mesh.tet2vertex)[span_of(neighborhood.slots())[t]][k];
      const VertexDof dof = neighborhood.work.dofs.dof.span()[part.tet2vertex[t][k]];
      if (dof == VertexDof::fixed) continue;
      EXPECT_EQ(span_of(tets_at)[of_whole], 0);
      EXPECT_EQ(dof, span_of(mesh.dof)[of_whole]);
      free += dof == VertexDof::free ? 1 : 0;
    }
  }
  EXPECT_GT(free, 0);
}

TEST(Neighborhood, DoesNotMoveAVertexWherePartsTouch) {
  TetMesh mesh = test::one_tet();
  TetMesh other = test::one_tet();
  for (std::size_t v = 1; v < 4; ++v) {
    mesh.points.push_back({-other.points[v][0], -other.points[v][1], -other.points[v][2]});
  }
  mesh.tets.push_back({0, 4, 6, 5});
  mesh = test::with_tags(mesh);
  HostWork work = imported(mesh, Boundary::preserve);
  std::fill(work.dof.begin(), work.dof.end(), VertexDof::plane);
  NeighborhoodFinder finder(work);
  finder.find(0, 3);
  EXPECT_EQ(finder.tets().size(), 1U);
  Neighborhood neighborhood(work, finder.found(), list_corners(Cpu(1), work));
  EXPECT_EQ(std::ranges::count(neighborhood.work.dofs.dof.download(), VertexDof::fixed), 1);
}

/// A triangle of a neighborhood gets another vertex. Its new edges, or the triangle itself, may be elsewhere in the
/// mesh.
TEST(Neighborhood, FindsSurfaceThatTheRestOfTheMeshHas) {
  const HostWork mesh = imported(test::cube(5), Boundary::slide);
  const CornersByVertex corners = list_corners(Cpu(1), mesh);
  NeighborhoodFinder finder(mesh);
  finder.find(0, 1);
  Neighborhood part(mesh, finder.found(), corners);
  EXPECT_FALSE(part.doubles_surface(mesh, corners));

  BoundaryTriangle& t = part.work.boundary.triangles.span()[0];
  const auto of_whole = [&](Index v) {
    return to_index(std::ranges::find(mesh.vertex2original, part.work.mesh.vertex2original.span()[v]) -
                    mesh.vertex2original.begin());
  };
  const auto has_edge_to = [&](Index v) {
    return have_edge(span_of(mesh.triangles), corners.view(), of_whole(t.v[1]), of_whole(v)) ||
           have_edge(span_of(mesh.triangles), corners.view(), of_whole(t.v[2]), of_whole(v));
  };
  Index other = 0;
  while (other == t.v[1] || other == t.v[2] || has_edge_to(other)) ++other;
  t.v[0] = other;
  EXPECT_FALSE(part.doubles_surface(mesh, corners));

  const Index outside = to_index(mesh.vertices() - 1);
  for (const Index third : {outside, of_whole(t.v[2])}) {
    HostWork more = mesh;
    BoundaryTriangle& added = more.triangles.emplace_back(t);
    added.v[0] = of_whole(other);
    added.v[1] = of_whole(t.v[1]);
    added.v[2] = third;
    EXPECT_TRUE(part.doubles_surface(more, list_corners(Cpu(1), more)));
  }
}

struct Restarted {
  bool is_changed;      ///< whether a restart was kept
  bool lowers_largest;  ///< whether the rounds for it lowered the largest angle
};

Restarted restart(const TetMesh& mesh, Boundary boundary, double max_deviation = 0) {
  Options options;
  options.max_deviation = max_deviation;
  options.effort = Effort::best;
  options.boundary = boundary;
  options.max_growth = 2;
  const Cpu backend(1);
  WorkingSet<Cpu> whole;
  Report report;
  import_mesh(backend, ImportInput{mesh, options}, whole, report);
  BufferOf<Cpu, double> buffer;
  refresh_energy(backend, whole.mesh, {kShapeObjective}, buffer);
  const Span<const double> energies = buffer.span();
  HostWork work(whole);
  RestartSearch search(
      work, {options, {}, find_floor(backend, whole.mesh, energies), 1.5, std::ssize(mesh.tets), whole.removable});
  const double weight = tuning_of(Effort::best).angles.obtuse_weight;
  const double cost = search.extremes().cost(weight);
  WorstReport r;
  for (int round = 0; round < 4 && search.run_round(r); ++round) expect_consistent(work);
  const DihedralCots balanced = search.extremes();
  EXPECT_LE(balanced.cost(weight), cost);
  search.aim_at_largest_angle();
  for (int round = 0; round < 4 && search.run_round(r); ++round) expect_consistent(work);
  EXPECT_LE(search.extremes().max, balanced.max);
  EXPECT_GE(search.extremes().min, balanced.min);
  return {search.has_changed(), search.extremes().min > balanced.min};
}

TEST(Restarts, LeaveAConsistentMesh) {
  int changed = 0, lower = 0;
  for (const Boundary boundary : {Boundary::fixed, Boundary::preserve, Boundary::slide}) {
    for (const TetMesh& mesh : meshes()) {
      const Restarted result = restart(mesh, boundary);
      changed += result.is_changed ? 1 : 0;
      lower += result.lowers_largest ? 1 : 0;
    }
  }
  EXPECT_GT(changed, 6);
  EXPECT_GT(lower, 1);
}

TEST(Restarts, MoveTheCheckedSurfaceToo) {
  int changed = 0;
  for (const double bound : {0.03, 0.003}) {
    for (const TetMesh& mesh : meshes()) changed += restart(mesh, Boundary::slide, bound).is_changed ? 1 : 0;
  }
  EXPECT_GT(changed, 2);
}

}  // namespace
}  // namespace tetune
