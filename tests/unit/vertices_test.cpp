// SPDX-License-Identifier: Apache-2.0
// Vertices inserted and removed: on cavities made by hand, and against plain checks on whole meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/connect.hpp"
#include "meshes.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"
#include "vertices/angle_ring.hpp"
#include "vertices/open_angles.hpp"
#include "vertices/revise.hpp"
#include "work.hpp"

namespace tetune {
namespace {

/// What revise_vertices() works on; the vertices of the surface are fixed.
struct Work {
  test::CpuMesh mesh;
  FlipState<par::Cpu> flips;
  Mobilities<par::Cpu> mobilities;

  explicit Work(const TetMesh& m) : mesh(test::to_work(m)) {
    const par::Cpu cpu(1);
    build_adjacency(cpu, mesh);
    test::lock_interfaces(cpu, mesh, m);
    mesh.law = kShapeLaw;
    const std::size_t n = m.points.size();
    std::vector<Index> ids(n);
    for (std::size_t v = 0; v < n; ++v) ids[v] = static_cast<Index>(v);
    mesh.vertex2original.upload(ids);
    std::vector<Mobility> kind(n, Mobility::free);
    const MeshView view = mesh.view();
    for (Size t = 0; t < mesh.slots(); ++t) {
      for (int f = 0; f < 4; ++f) {
        for (int k = 0; k < 3 && is_locked(view.tet2tet[t][f]); ++k)
          kind[static_cast<std::size_t>(view.tet2vertex[t][face_vertex(f, k)])] = Mobility::fixed;
      }
    }
    mobilities.kind.upload(kind);
    mobilities.axis.upload(std::vector<Vec3>(n, Vec3{0, 0, 0}));
    mobilities.awake.upload(std::vector<std::uint8_t>(n, 0));
    flips.constrained_vertex.upload(std::vector<std::uint8_t>(n, 0));
  }

  void constrain(Index a, Index b) {
    flips.constrained_keys.upload({ConstrainedEdges::edge_key(a, b)});
    flips.constrained_vertex.span()[a] = flips.constrained_vertex.span()[b] = 1;
  }

  /// Around the tetrahedra with an angle whose cotangent is above `cot`.
  ReviseReport revise(double cot = 0, Size most_tets = 1 << 20, int threads = 1, double vertex_cot = 0) {
    std::vector<Index> around;
    for (Size t = 0; t < mesh.slots(); ++t) {
      if (mesh.view().alive(t) && largest_cot(mesh.view(), t) > cot) around.push_back(static_cast<Index>(t));
    }
    refresh_energy(par::Cpu(1), mesh, flips);
    return revise_vertices(par::Cpu(threads), mesh, flips, mobilities,
                           {around.data(), static_cast<Size>(around.size())}, most_tets, vertex_cot);
  }
};

/// Four tetrahedra around the edge (0, 1), one of them a sliver whose four vertices are on the surface, as are all.
TetMesh sliver_on_the_surface() {
  TetMesh m;
  m.points = {{-1, 0, 0}, {1, 0, 0}, {0, -1, -0.1}, {0, 1, -0.1}, {0, 1.5, 1.5}, {0, -1.5, 1.5}};
  m.tets = {{0, 2, 3, 1}, {0, 3, 4, 1}, {0, 4, 5, 1}, {0, 5, 2, 1}};
  return test::with_tags(m);
}

/// A regular tetrahedron divided by a vertex close to one of its faces.
TetMesh divided_tet() {
  TetMesh m;
  m.points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {-0.3, -0.3, -0.3}};
  m.tets = {{4, 1, 2, 3}, {0, 4, 2, 3}, {0, 1, 4, 3}, {0, 1, 2, 4}};
  for (auto& t : m.tets) std::swap(t[2], t[3]);
  return test::with_tags(m);
}

/// Vertex 5 is around the edge (0, 1), but so far beyond its end that the edge cannot be removed.
TetMesh vertex_beyond() {
  TetMesh m;
  m.points = {{-1.1, 0, 0}, {1, 0, 0}, {0, -1.4, -1.4}, {0, 1.4, -1.4}, {2.4, 0, 1.8}, {1.3, 0, 0.4}};
  m.tets = {{0, 2, 3, 1}, {0, 3, 5, 1}, {0, 5, 2, 1}, {5, 0, 2, 4}, {5, 2, 1, 4}, {5, 1, 3, 4}, {5, 3, 0, 4}};
  return test::with_tags(m);
}

/// Divides some tetrahedra by a vertex close to one of their faces.
TetMesh with_needless_vertices(TetMesh m, std::size_t every) {
  const std::size_t tets = m.tets.size();
  for (std::size_t t = 0; t < tets; t += every) {
    const std::array<Index, 4> tet = m.tets[t];
    Point3 p{};
    for (std::size_t k = 0; k < 4; ++k) {
      const Point3& q = m.points[static_cast<std::size_t>(tet[k])];
      for (std::size_t i = 0; i < 3; ++i) p[i] += (k == 0 ? 0.1 : 0.3) * q[i];
    }
    const auto v = static_cast<Index>(m.points.size());
    m.points.push_back(p);
    m.point_tags.push_back(0);
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<Index, 4> part = tet;
      part[k] = v;
      if (k == 0) {
        m.tets[t] = part;
      } else {
        m.tets.push_back(part);
        m.tet_tags.push_back(m.tet_tags[t]);
      }
    }
  }
  return m;
}

using Face = std::array<Point3, 3>;

/// The faces on one tetrahedron, or between two of different tags, by the places of their corners.
std::multiset<Face> surface(const TetMesh& m) {
  std::map<std::array<Index, 3>, std::vector<int>> faces;
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::array<Index, 3> face{};
      for (std::size_t k = 0, at = 0; k < 4; ++k) {
        if (k != skip) face[at++] = m.tets[t][k];
      }
      std::sort(face.begin(), face.end());
      faces[face].push_back(m.tet_tags[t]);
    }
  }
  std::multiset<Face> result;
  for (const auto& [face, tags] : faces) {
    if (tags.size() == 2 && tags[0] == tags[1]) continue;
    Face at;
    for (std::size_t k = 0; k < 3; ++k) at[k] = m.points[static_cast<std::size_t>(face[k])];
    std::sort(at.begin(), at.end());
    result.insert(at);
  }
  return result;
}

/// Revises a mesh pass by pass, and checks all that must hold after each.
ReviseReport check_revisions(const TetMesh& before, int passes, double cot, double vertex_cot = 0) {
  Work work(before);
  const auto old_surface = surface(before);
  const Quality old_quality = quality(before);
  double angle = old_quality.dihedral_min;
  ReviseReport sum;
  for (int pass = 0; pass < passes; ++pass) {
    const ReviseReport r = work.revise(cot, 1 << 20, 1, vertex_cot);
    sum.edges += r.edges;
    sum.inserted += r.inserted;
    sum.removed += r.removed;
    EXPECT_EQ(test::check_links(work.mesh), "");
    const TetMesh after = test::from_work(work.mesh, before);
    const ValidationReport valid = validate(after);
    EXPECT_TRUE(valid.ok()) << valid.message(false);
    EXPECT_EQ(surface(after), old_surface);
    // The energies are those of the new tetrahedra.
    std::vector<double> energies = work.flips.energies.download();
    refresh_energy(par::Cpu(1), work.mesh, work.flips);
    for (std::size_t t = 0; t < energies.size(); ++t) {
      const double exact = work.flips.energies.span()[static_cast<Size>(t)];
      EXPECT_NEAR(energies[t], exact, 1e-12 * exact);
    }
    const Quality now = quality(after);
    EXPECT_NEAR(now.volume, old_quality.volume, 1e-12 * old_quality.volume);
    EXPECT_GE(now.dihedral_min, angle * (1 - 1e-12));
    angle = now.dihedral_min;

    // Ids and arrays.
    std::vector<std::uint8_t> used(after.points.size(), 0);
    for (const auto& t : after.tets) {
      for (const Index v : t) used[static_cast<std::size_t>(v)] = 1;
    }
    Size inserted = 0;
    Size removed = 0;
    for (Size v = 0; v < work.mesh.vertices(); ++v) {
      const Index original = work.mesh.vertex2original.span()[v];
      const bool gone = original == kRemoved;
      EXPECT_EQ(used[static_cast<std::size_t>(v)], gone ? 0 : 1);
      inserted += v >= static_cast<Size>(before.points.size()) ? 1 : 0;
      removed += gone ? 1 : 0;
      EXPECT_TRUE(original < 0 || original == v);
    }
    EXPECT_EQ(inserted, sum.inserted);
    EXPECT_EQ(removed, sum.removed);
    for (const Size size : {work.mobilities.kind.size(), work.mobilities.axis.size(), work.mobilities.awake.size(),
                            work.flips.constrained_vertex.size(), work.mesh.vertex2original.size()}) {
      EXPECT_EQ(size, work.mesh.vertices());
    }
    if (r.inserted + r.removed + r.edges == 0) break;
  }
  return sum;
}

TEST(Revise, InsertsAVertexAboveASliverOnTheSurface) {
  const TetMesh before = sliver_on_the_surface();
  ASSERT_TRUE(validate(before).ok());
  Work work(before);
  const ReviseReport r = work.revise(1.7);  // 30 degrees
  EXPECT_EQ(r.inserted, 1);
  EXPECT_EQ(r.removed, 0);
  EXPECT_EQ(work.mesh.tets(), 8);
  const TetMesh after = test::from_work(work.mesh, before);
  EXPECT_EQ(test::check_links(work.mesh), "");
  EXPECT_TRUE(validate(after).ok());
  EXPECT_EQ(surface(after), surface(before));
  EXPECT_GT(quality(after).dihedral_min, 2 * quality(before).dihedral_min);
  EXPECT_GT(after.points[6][2], 0.3);  // well above the edge it was put on
  EXPECT_EQ(work.mesh.vertex2original.span()[6], kInserted);
  EXPECT_EQ(work.mobilities.kind.span()[6], Mobility::free);
  for (Size v = 0; v < 7; ++v) EXPECT_EQ(work.mobilities.awake.span()[v], 1);
}

TEST(Revise, RemovesAVertexCloseToAFace) {
  const TetMesh before = divided_tet();
  ASSERT_TRUE(validate(before).ok());
  Work work(before);
  const ReviseReport r = work.revise(1.7);
  EXPECT_EQ(r.inserted, 0);
  EXPECT_EQ(r.removed, 1);
  EXPECT_EQ(work.mesh.tets(), 1);
  EXPECT_EQ(work.mesh.free_count, 3);
  EXPECT_EQ(work.mesh.vertex2original.span()[4], kRemoved);
  const TetMesh after = test::from_work(work.mesh, before);
  EXPECT_EQ(test::check_links(work.mesh), "");
  EXPECT_NEAR(quality(after).dihedral_min, 70.5288, 1e-4);
}

TEST(Revise, RemovesAnEdgeByMovingAVertexOfItsRing) {
  const TetMesh before = vertex_beyond();
  ASSERT_TRUE(validate(before).ok());
  const auto p = [&before](std::size_t v) { return vec(before.points[v]); };
  ASSERT_FALSE(orient(p(1), p(2), p(5), p(3)).certified());  // that of a 3-2 flip
  Work work(before);
  const ReviseReport r = work.revise(1.7, 1 << 20, 1, kNever);
  EXPECT_EQ(r.edges, 1);
  EXPECT_EQ(r.inserted + r.removed, 0);
  EXPECT_EQ(work.mesh.tets(), 6);
  EXPECT_EQ(work.mesh.free_count, 1);
  const TetMesh after = test::from_work(work.mesh, before);
  EXPECT_EQ(test::check_links(work.mesh), "");
  EXPECT_TRUE(validate(after).ok());
  EXPECT_EQ(surface(after), surface(before));
  EXPECT_LT(after.points[5][0], 1);
  for (std::size_t v = 0; v < 5; ++v) EXPECT_EQ(after.points[v], before.points[v]);
  for (const auto& t : after.tets) EXPECT_EQ(std::count(t.begin(), t.end(), 0) + std::count(t.begin(), t.end(), 1), 1);
  EXPECT_GT(quality(after).dihedral_min, 2 * quality(before).dihedral_min);
  EXPECT_EQ(work.mesh.vertex2original.span()[5], 5);
  EXPECT_EQ(work.mobilities.awake.span()[5], 1);
}

TEST(Revise, RemovesNoEdgeByAVertexThatMustStay) {
  const TetMesh m = vertex_beyond();
  {
    Work work(m);
    work.mobilities.kind.span()[5] = Mobility::fixed;
    EXPECT_EQ(work.revise(1.7, 1 << 20, 1, kNever).edges, 0);
  }
  for (const std::array<Index, 2>& edge : {std::array<Index, 2>{0, 1}, std::array<Index, 2>{4, 5}}) {
    Work work(m);
    work.constrain(edge[0], edge[1]);
    EXPECT_EQ(work.revise(1.7, 1 << 20, 1, kNever).edges, 0);
  }
  TetMesh two = m;
  two.tet_tags = {1, 2, 2, 2, 2, 2, 2};
  Work work(two);
  work.mobilities.kind.span()[5] = Mobility::free;
  EXPECT_EQ(work.revise(1.7, 1 << 20, 1, kNever).edges, 0);
}

TEST(Revise, LeavesAloneWhatIsConstrained) {
  {
    Work work(sliver_on_the_surface());
    work.constrain(0, 1);
    EXPECT_EQ(work.revise().inserted, 0);
  }
  {
    TetMesh m = sliver_on_the_surface();
    m.tet_tags = {1, 2, 2, 2};  // the faces at the edge are an interface
    Work work(m);
    EXPECT_EQ(work.revise().inserted, 0);
  }
  {
    Work work(divided_tet());
    work.mobilities.kind.span()[4] = Mobility::fixed;
    EXPECT_EQ(work.revise(1.7).removed, 0);
  }
}

TEST(Revise, KeepsToTheFloorAndToTheNumberOfTetrahedra) {
  {
    Work work(sliver_on_the_surface());
    const std::vector<Tet> before = work.mesh.tet2vertex.download();
    const ReviseReport r = work.revise(1.7, 7);
    EXPECT_EQ(r.inserted + r.removed, 0);
    EXPECT_EQ(work.mesh.vertices(), 6);
    const std::vector<Tet> after = work.mesh.tet2vertex.download();
    for (std::size_t t = 0; t < before.size(); ++t) {
      for (int k = 0; k < 4; ++k) EXPECT_EQ(before[t][k], after[t][k]);
    }
    EXPECT_EQ(work.revise(1.7, 8).inserted, 1);
  }
  Work work(sliver_on_the_surface());
  work.mesh.floor = {1.01, 1e300, 1};  // nothing worse than regular
  EXPECT_EQ(work.revise().inserted, 0);
}

TEST(Revise, KeepsAMeshAMesh) {
  ReviseReport sum;
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const TetMesh m =
        seed % 2 == 0 ? test::two_materials(4, 0.15) : test::scrambled(test::cube(3, 0.25, seed), 2, seed);
    const ReviseReport r = check_revisions(with_needless_vertices(m, 8), 4, 2);
    sum.inserted += r.inserted;
    sum.removed += r.removed;
  }
  EXPECT_GT(sum.inserted, 10);
  EXPECT_GT(sum.removed, 20);
}

TEST(Revise, KeepsTheVerticesWhereItRemovesEdgesAlone) {
  Size edges = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const TetMesh m = seed % 2 == 0 ? test::two_materials(6, 0.2) : test::scrambled(test::cube(5, 0.25, seed), 2, seed);
    const ReviseReport r = check_revisions(with_needless_vertices(m, 12), 4, 1.5, kNever);
    EXPECT_EQ(r.inserted + r.removed, 0);
    edges += r.edges;
  }
  EXPECT_GT(edges, 40);
}

/// Edges that must stay are not lost inside a cavity.
TEST(Revise, KeepsConstrainedEdges) {
  Size edges = 0;
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const TetMesh m = with_needless_vertices(test::cube(4, 0.25, seed), 8);
    Work work(m);
    std::vector<std::uint64_t> keys;
    for (std::size_t t = 0; t < m.tets.size(); t += 7) {
      keys.push_back(ConstrainedEdges::edge_key(m.tets[t][0], m.tets[t][1]));
      for (int k = 0; k < 2; ++k) work.flips.constrained_vertex.span()[m.tets[t][static_cast<std::size_t>(k)]] = 1;
    }
    std::sort(keys.begin(), keys.end());
    work.flips.constrained_keys.upload(keys);
    for (int pass = 0; pass < 3; ++pass) edges += work.revise(1.5, 1 << 20, 1, kNever).edges;
    std::set<std::uint64_t> left;
    for (const auto& t : test::from_work(work.mesh, m).tets) {
      for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t l = 0; l < k; ++l) left.insert(ConstrainedEdges::edge_key(t[k], t[l]));
      }
    }
    for (const std::uint64_t key : keys) EXPECT_EQ(left.count(key), 1U);
  }
  EXPECT_GT(edges, 10);
}

TEST(Revise, IsTheSameForAnyNumberOfThreads) {
  const TetMesh m = with_needless_vertices(test::cube(6, 0.2), 20);
  std::vector<TetMesh> results;
  for (const int threads : {1, 2, 5}) {
    Work work(m);
    const ReviseReport r = work.revise(2, 1 << 20, threads);
    EXPECT_GT(r.inserted, 0);
    EXPECT_GT(r.removed, 10);
    EXPECT_GT(r.edges, 0);
    results.push_back(test::from_work(work.mesh, m));
  }
  for (const TetMesh& r : results) {
    EXPECT_EQ(r.points, results[0].points);
    EXPECT_EQ(r.tets, results[0].tets);
  }
}

bool open(const AngleRing& ring, Vec3& x, const Motion& motion, double enough) {
  FreeWay way{motion};
  return ring.open(x, way, enough);
}

TEST(AngleRing, OpensTheSmallestAngle) {
  const TetMesh m = divided_tet();
  Work work(m);
  const LinkFace faces[4] = {{{1, 3, 2}}, {{0, 2, 3}}, {{0, 3, 1}}, {{0, 1, 2}}};
  const AngleRing ring(work.mesh.view(), faces, 4);
  int first = 0;
  Vec3 x = vec(m.points[4]);
  const double before = ring.largest_cot(x, 1e300, first);
  EXPECT_NEAR(before, 1 / std::tan(quality(m).dihedral_min * 3.14159265358979324 / 180), 1e-9);
  ASSERT_TRUE(open(ring, x, {Mobility::free, {}}, 0));
  // The middle is the only place where all four are the same.
  EXPECT_NEAR(norm(x), 0, 0.05);
  // Until it is enough, and no further.
  Vec3 y = vec(m.points[4]);
  ASSERT_TRUE(open(ring, y, {Mobility::free, {}}, 0.9 * before));
  const double enough = ring.largest_cot(y, 1e300, first);
  EXPECT_LE(enough, 0.9 * before);
  EXPECT_GT(enough, 1.1 * ring.largest_cot(x, 1e300, first));
  // Within a plane and along a line.
  Vec3 z = vec(m.points[4]);
  ASSERT_TRUE(open(ring, z, {Mobility::plane, {0, 0, 1}}, 0));
  EXPECT_EQ(z.z, m.points[4][2]);
  z = vec(m.points[4]);
  ASSERT_TRUE(open(ring, z, {Mobility::line, {0, 1, 0}}, 0));
  EXPECT_EQ(z.x, m.points[4][0]);
  EXPECT_EQ(z.z, m.points[4][2]);
  z = vec(m.points[4]);
  EXPECT_FALSE(open(ring, z, {Mobility::fixed, {}}, 0));
}

TEST(OpenAngles, MovesFlaggedVerticesAloneAndNoAngleBecomesSmaller) {
  TetMesh m = test::cube(5, 0.2);
  Work work(m);
  const par::Cpu cpu(2);
  Rings<par::Cpu> rings;
  build_rings(cpu, work.mesh, rings);
  Coloring<par::Cpu> coloring;
  color_vertices(cpu, rings.view(), work.mobilities.kind.span(), coloring);
  std::vector<std::uint8_t> flags(m.points.size(), 0);
  for (std::size_t v = 0; v < flags.size(); v += 2) flags[v] = 1;
  par::Cpu::Buffer<std::uint8_t> buffer;
  buffer.upload(flags);
  const Size moved = open_angles(cpu, work.mesh, rings.view(), coloring, work.mobilities,
                                 Span<const std::uint8_t>(buffer.span()), 0.5);
  const TetMesh after = test::from_work(work.mesh, m);
  EXPECT_TRUE(validate(after).ok());
  EXPECT_GE(quality(after).dihedral_min, quality(m).dihedral_min);
  EXPECT_GT(quality(after).dihedral_1, quality(m).dihedral_1 + 1);
  Size changed = 0;
  for (std::size_t v = 0; v < flags.size(); ++v) {
    if (after.points[v] == m.points[v]) continue;
    ++changed;
    EXPECT_EQ(flags[v], 1);
    EXPECT_EQ(work.mobilities.kind.span()[static_cast<Size>(v)], Mobility::free);
  }
  EXPECT_EQ(changed, moved);
  EXPECT_GT(moved, 10);
}

}  // namespace
}  // namespace tetune
