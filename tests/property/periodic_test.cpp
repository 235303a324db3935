// SPDX-License-Identifier: Apache-2.0
#include "tetune/periodic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "backend/span.hpp"
#include "boundary/motion_intersection.hpp"
#include "mesh/periodic.hpp"
#include "mesh/tet.hpp"
#include "support/entities.hpp"
#include "support/meshes.hpp"
#include "support/options.hpp"
#include "support/periodic_cube.hpp"
#include "support/sanitized.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using test::cube;
using test::options_of;
using test::outer_faces;
using test::periodic_cube;

/// The number of pairs that do not match to the last bit, with the translations that the links have at first.
std::size_t count_unmatched(const TetMesh& before, const TetMesh& after) {
  std::size_t count = 0;
  for (const PeriodicLink& link : before.periodic) {
    const Vec3 t = translation_of(link, before.points, 1e-9).value();
    for (const auto& [vertex, master] : link.pairs) {
      const Point3& p = span_of(after.points)[vertex];
      const Vec3 image = vec(span_of(after.points)[master]) + t;
      count += p == Point3{image.x, image.y, image.z} ? 0 : 1;
    }
  }
  return count;
}

std::size_t count_moved(const TetMesh& before, const TetMesh& after) {
  std::size_t count = 0;
  for (const PeriodicLink& link : before.periodic) {
    for (const auto& [vertex, master] : link.pairs) {
      count += span_of(before.points)[vertex] == span_of(after.points)[vertex] ? 0 : 1;
    }
  }
  return count;
}

/// The number of triangles of linked faces without an image.
std::size_t count_unpaired(const TetMesh& mesh) {
  const std::set<std::array<Index, 3>> faces = outer_faces(mesh);
  std::size_t count = 0;
  for (const PeriodicLink& link : mesh.periodic) {
    std::map<Index, Index> to_master;
    std::map<Index, Index> to_vertex;
    for (const auto& [vertex, master] : link.pairs) {
      to_master[vertex] = master;
      to_vertex[master] = vertex;
    }
    for (const std::map<Index, Index>& image : {to_master, to_vertex}) {
      for (std::array<Index, 3> face : faces) {
        if (!std::all_of(face.begin(), face.end(), [&](Index v) { return image.count(v) > 0; })) continue;
        for (Index& v : face) v = image.at(v);
        count += 1 - faces.count(ascending(face));
      }
    }
  }
  return count;
}

/// A lattice with a period in all directions, along the edges of an oblique cell: the edges in which the cubes' faces
/// are divided are the long diagonals on some of its faces.
TetMesh oblique_lattice(int n, double jitter, double shear) {
  TetMesh mesh = periodic_cube(n, jitter);
  link_box_faces(mesh, {true, true, true});
  for (Point3& p : mesh.points) p[0] += shear * p[2];
  for (PeriodicLink& link : mesh.periodic) link.affine.clear();
  return mesh;
}

/// The smallest angle of a triangle on the outside, in degrees.
double smallest_face_angle(const TetMesh& mesh) {
  double smallest = 180;
  for (const std::array<Index, 3>& face : outer_faces(mesh)) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 at = vec(span_of(mesh.points)[face[k]]);
      const Vec3 a = vec(span_of(mesh.points)[face[(k + 1) % 3]]) - at;
      const Vec3 b = vec(span_of(mesh.points)[face[(k + 2) % 3]]) - at;
      smallest = std::min(smallest, std::atan2(norm(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi);
    }
  }
  return smallest;
}

/// Edges of periodic faces are flipped together with their images.
TEST(Periodic, PairedFacesFlipTogether) {
  for (const double jitter : {0.0, 0.2}) {
    const TetMesh input = oblique_lattice(5, jitter, 0.8);
    ASSERT_EQ(count_unpaired(input), 0U);
    ASSERT_EQ(outer_faces(input).size(), 6U * 5 * 5 * 2);
    Options options = options_of(Effort::standard, Boundary::preserve, 1);
    TetMesh kept = input;
    options.boundary_flips = false;
    const double energy_kept = optimize(kept, options).energy_after;
    options.boundary_flips = true;
    TetMesh mesh = input;
    TetMesh other = input;
    const Report report = optimize(mesh, options);
    options.threads = 3;
    optimize(other, options);
    EXPECT_EQ(mesh.points, other.points);
    EXPECT_EQ(mesh.tets, other.tets);
    EXPECT_GT(report.boundary_flips, 10);
    EXPECT_NE(outer_faces(mesh), outer_faces(input));
    EXPECT_EQ(count_unpaired(mesh), 0U);
    EXPECT_EQ(outer_faces(mesh).size(), outer_faces(input).size());
    EXPECT_TRUE(validate(mesh, 1).ok());
    EXPECT_NEAR(quality(mesh, 1).volume, 1, 1e-12);
    EXPECT_LT(report.energy_after, 0.99 * energy_kept);
    EXPECT_GT(smallest_face_angle(mesh), smallest_face_angle(kept) + 1);
  }
}

/// With a triangle of one face held, that of the other one stays as well.
TEST(Periodic, AnImageThatStaysHoldsTheFace) {
  TetMesh mesh = oblique_lattice(4, 0, 0.8);
  for (const auto& [vertex, master] : mesh.periodic[1].pairs) mesh.required_vertices.push_back(vertex);
  const TetMesh input = mesh;
  optimize(mesh, options_of(Effort::standard, Boundary::preserve, 1));
  std::set<Index> masters;
  for (const auto& [vertex, master] : mesh.periodic[1].pairs) masters.insert(master);
  for (const std::array<Index, 3>& face : outer_faces(input)) {
    const bool is_held = std::all_of(face.begin(), face.end(), [&](Index v) { return masters.count(v) > 0; });
    if (!is_held) continue;
    EXPECT_EQ(outer_faces(mesh).count(face), 1U);
  }
  EXPECT_EQ(count_unpaired(mesh), 0U);
}

TEST(Periodic, FacesOfABoxAreLinked) {
  TetMesh mesh = periodic_cube(3, 0.2);
  link_box_faces(mesh, {true, true, true});
  ASSERT_EQ(mesh.periodic.size(), 3U);
  for (const PeriodicLink& link : mesh.periodic) EXPECT_EQ(link.pairs.size(), 16U);
  EXPECT_EQ(count_unmatched(mesh, mesh), 0U);
  const PeriodicClasses classes = find_periodic_classes(mesh);
  std::array<int, 9> sizes{};
  for (std::size_t c = 0; c < classes.size(); ++c) ++sizes.at(classes.first[c + 1] - classes.first[c]);
  EXPECT_EQ(sizes[2], 3 * 4);
  EXPECT_EQ(sizes[4], 3 * 2);
  EXPECT_EQ(sizes[8], 1);
}

TEST(Periodic, AFaceThatDoesNotMatchIsRefused) {
  TetMesh mesh = periodic_cube(3, 0.2);
  for (Point3& p : mesh.points) {
    if (p[0] == 1 && p[1] > 0 && p[1] < 0.5 && p[2] > 0 && p[2] < 0.5) p[1] += 1e-4;
  }
  try {
    link_box_faces(mesh, {true, false, false});
    FAIL();
  } catch (const MeshError& e) {
    EXPECT_NE(std::string(e.what()).find("periodic in x: 2 vertices"), std::string::npos) << e.what();
  }
  EXPECT_TRUE(mesh.periodic.empty());
}

/// Faces move, and match to the last bit; edges of the box move along themselves; the shape is that of the box.
TEST(Periodic, ImagesMoveTogether) {
  // The second box has a length that the difference of the faces' coordinates does not reproduce at once.
  for (const auto& [low, side] : {std::pair(0.0, 1.0), std::pair(0.1, 0.7)}) {
    for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
      for (const Effort effort : {Effort::standard, Effort::best}) {
        const TetMesh input = [low = low, side = side] {
          TetMesh m = periodic_cube(5, 0.2, low, side);
          link_box_faces(m, {true, true, true});
          return m;
        }();
        ASSERT_EQ(count_unmatched(input, input), 0U);
        TetMesh mesh = input;
        const Report report = optimize(mesh, options_of(effort, boundary, 1));
        EXPECT_EQ(count_unmatched(input, mesh), 0U);
        EXPECT_EQ(count_unpaired(mesh), 0U);
        // Each face has 36 vertices; corners stay.
        EXPECT_GT(count_moved(input, mesh), 2U * 16);
        EXPECT_EQ(report.periodic_vertices, 6 * 16 + 12 * 4);
        EXPECT_TRUE(validate(mesh, 1).ok());
        EXPECT_NEAR(quality(mesh, 1).volume, side * side * side, 1e-12);
        for (const Point3& p : input.points) {
          const Point3& now = mesh.points[static_cast<std::size_t>(&p - input.points.data())];
          for (std::size_t k = 0; k < 3; ++k) {
            if (p[k] == low || p[k] == low + side) {
              EXPECT_EQ(now[k], p[k]);
            }
          }
        }
      }
    }
  }
}

/// The minimum of the energy is that of the regular lattice, whose faces are not disturbed.
TEST(Periodic, DisturbedFacesReachTheMinimum) {
  Options options = options_of(Effort::best, Boundary::preserve, 1);
  options.flips = false;
  options.keep_vertices = true;
  const auto energy_with_links = [&options](double jitter) {
    TetMesh mesh = periodic_cube(6, jitter);
    link_box_faces(mesh, {true, true, true});
    return optimize(mesh, options).energy_after;
  };
  TetMesh held = periodic_cube(6, 0.2);
  for (Index v = 0; v < std::ssize(held.points); ++v) {
    const Point3& p = span_of(held.points)[v];
    const bool on_face = std::any_of(p.begin(), p.end(), [](double x) { return x == 0 || x == 1; });
    if (on_face) held.required_vertices.push_back(v);
  }
  const double minimum = energy_with_links(0);
  EXPECT_LT(std::fabs(energy_with_links(0.2) - minimum), 0.02 * (optimize(held, options).energy_after - minimum));
}

TEST(Periodic, TheResultDoesNotDependOnTheNumberOfThreads) {
  TetMesh mesh = periodic_cube(test::kSanitized ? 6 : 8, 0.2);
  link_box_faces(mesh, {true, false, true});
  TetMesh other = mesh;
  optimize(mesh, options_of(Effort::best, Boundary::preserve, 1));
  optimize(other, options_of(Effort::best, Boundary::preserve, 3));
  EXPECT_EQ(mesh.points, other.points);
  EXPECT_EQ(mesh.tets, other.tets);
}

TEST(Periodic, OneElementAcrossThePeriodStays) {
  // Every tetrahedron has a vertex and its image.
  TetMesh mesh = cube(1);
  link_box_faces(mesh, {true, true, true});
  const TetMesh input = mesh;
  optimize(mesh, options_of(Effort::standard, Boundary::preserve, 1));
  EXPECT_EQ(mesh.points, input.points);
}

TEST(Periodic, AnImageThatMayNotMoveHoldsItsMaster) {
  TetMesh mesh = periodic_cube(4, 0.2);
  link_box_faces(mesh, {true, true, true});
  const TetMesh input = mesh;
  for (const auto& [vertex, master] : mesh.periodic[0].pairs) mesh.required_vertices.push_back(vertex);
  optimize(mesh, options_of(Effort::standard, Boundary::preserve, 1));
  for (const auto& pair : mesh.periodic[0].pairs) {
    for (const Index v : pair) EXPECT_EQ(span_of(mesh.points)[v], span_of(input.points)[v]);
  }
  EXPECT_GT(count_moved(input, mesh), 0U);
}

TEST(Periodic, LinksThatAreNoTranslationHoldTheirVertices) {
  TetMesh mesh = periodic_cube(4, 0.2);
  PeriodicLink link;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (mesh.points[v][0] == 0) link.pairs.push_back({static_cast<Index>(v), 0});
  }
  mesh.periodic = {link};
  const TetMesh input = mesh;
  EXPECT_EQ(optimize(mesh, options_of(Effort::standard, Boundary::preserve, 1)).periodic_vertices, 0);
  for (const auto& [vertex, master] : link.pairs) {
    EXPECT_EQ(span_of(mesh.points)[vertex], span_of(input.points)[vertex]);
  }
}

TEST(Periodic, TheTranslationReproducesMostPairs) {
  const std::vector<Point3> points = {{0.1, 0, 0}, {0.1, 0.5, 0}, {0.1 + 0.7, 0, 0}, {0.1 + 0.7, 0.5, 1e-17}};
  const PeriodicLink link{2, 0, 0, {}, {{2, 0}, {3, 1}}};
  const Vec3 t = translation_of(link, points, 1e-9).value();
  EXPECT_EQ(0.1 + t.x, 0.1 + 0.7);
  EXPECT_EQ(t.y, 0);
  EXPECT_EQ(t.z, 0);
  EXPECT_FALSE(translation_of(link, points, 1e-18).has_value());
}

TEST(Periodic, AVertexThatDoesNotExistIsRefused) {
  TetMesh mesh = test::one_tet();
  mesh.tets[0][2] = 2000000000;
  EXPECT_THROW(link_box_faces(mesh, {true, false, false}), MeshError);
}

TEST(Periodic, SpacesOfMotionIntersect) {
  const MotionSpace x{VertexDof::plane, {1, 0, 0}};
  const MotionSpace y{VertexDof::plane, {0, 1, 0}};
  const MotionSpace back{VertexDof::plane, {-1, 0, 0}};
  EXPECT_EQ(intersect(x, back).axis.x, 1);
  const MotionSpace line = intersect(x, y);
  EXPECT_EQ(line.dof, VertexDof::line);
  EXPECT_EQ(line.axis.z, 1);
  EXPECT_EQ(intersect(line, x).dof, VertexDof::line);
  EXPECT_EQ(intersect(line, {VertexDof::plane, {0, 0, 1}}).dof, VertexDof::fixed);
  EXPECT_EQ(intersect(x, {VertexDof::surface, {}}).dof, VertexDof::fixed);
  EXPECT_EQ(intersect({VertexDof::free, {}}, line).axis.z, 1);
}

}  // namespace
}  // namespace tetune
