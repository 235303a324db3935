// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <set>

#include "curved/curved_edges.hpp"
#include "curved/held_bound.hpp"
#include "curved/relaxation_energy.hpp"
#include "math/constants.hpp"
#include "support/curved.hpp"
#include "support/meshes.hpp"
#include "tetune/curve.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// The straight element of four vertices.
TenNodes straight(const std::array<Vec3, 4>& vertices) {
  TenNodes nodes{};
  for (std::size_t k = 0; k < 4; ++k) nodes[k] = vertices[k];
  for (std::size_t e = 0; e < 6; ++e) {
    nodes[4 + e] = 0.5 * (vertices[kCurvedTetEdges[e][0]] + vertices[kCurvedTetEdges[e][1]]);
  }
  return nodes;
}

const std::array<Vec3, 4> kUnitTet{Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// The determinant by the derivatives of the shape functions: the definition.
double plain_determinant(const TenNodes& nodes, const std::array<double, 4>& at) {
  std::array<Vec3, 4> derivatives{};  // by each barycentric coordinate
  for (std::size_t k = 0; k < 4; ++k) derivatives[k] = (4 * at[k] - 1) * nodes[k];
  for (std::size_t e = 0; e < 6; ++e) {
    const auto& [i, j] = kCurvedTetEdges[e];
    derivatives[i] = derivatives[i] + 4 * at[j] * nodes[4 + e];
    derivatives[j] = derivatives[j] + 4 * at[i] * nodes[4 + e];
  }
  const Vec3& d = derivatives[0];
  return dot(cross(derivatives[1] - d, derivatives[2] - d), derivatives[3] - d);
}

/// The smallest determinant at the points of a lattice with n steps per edge.
double sampled_minimum(const TenNodes& nodes, int n) {
  double least = kInfinity;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      for (int k = 0; i + j + k <= n; ++k) {
        const double h = 1.0 / n;
        least = std::min(least, plain_determinant(nodes, {(n - i - j - k) * h, i * h, j * h, k * h}));
      }
    }
  }
  return least;
}

TEST(Curved, StraightElementHasConstantDeterminant) {
  const ScaledJacobian j = jacobian_of(straight(kUnitTet));
  for (const double c : j.polynomial.coefficients) EXPECT_EQ(c, 1);
  const CurvedTet t = measure_nodes(straight(kUnitTet));
  EXPECT_EQ(t.validity, CurvedValidity::valid);
  EXPECT_NEAR(t.min_lower, 1, 1e-12);
  EXPECT_NEAR(t.max_upper, 1, 1e-12);
  EXPECT_EQ(t.corner_ratio, 1);
  EXPECT_EQ(t.middle_offset, 0);
}

TEST(Curved, AFlatElementHasInfiniteScaledJacobians) {
  const CurvedTet t = measure_nodes(straight({Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_NE(t.validity, CurvedValidity::valid);
  EXPECT_EQ(t.min_lower, -kInfinity);
  EXPECT_EQ(t.scaled_jacobian(), -kInfinity);
  EXPECT_EQ(t.max_upper, kInfinity);
}

TEST(Curved, DeterminantOfAMovedMiddleIsKnown) {
  // x = u + 4 s u (1 - u - v - w) along the first edge: dx/du = 1 + 4 s (1 - 2 u - v - w), the determinant.
  for (const double s : {0.1, 0.2, 0.24, 0.26, -0.3}) {
    TenNodes nodes = straight(kUnitTet);
    nodes[4].x += s;
    const CurvedTet t = measure_nodes(nodes);
    const double minimum = 1 - 4 * std::fabs(s);
    EXPECT_EQ(t.validity, minimum > 0 ? CurvedValidity::valid : CurvedValidity::inverted) << s;
    EXPECT_LE(t.min_lower, minimum);
    EXPECT_GE(t.min_lower, minimum - 2e-3);
    EXPECT_GE(t.min_upper, minimum);
    EXPECT_LE(t.max_lower, 1 + 4 * std::fabs(s));
    EXPECT_GE(t.max_upper, 1 + 4 * std::fabs(s));
    EXPECT_NEAR(t.middle_offset, std::fabs(s), 1e-15);
    if (minimum > 0) {
      EXPECT_NEAR(t.corner_ratio, (2 - minimum) / minimum, 1e-9);
    } else {
      EXPECT_EQ(t.corner_ratio, kInfinity);
    }
  }
  TenNodes flat = straight(kUnitTet);
  flat[4].x += 0.25;
  EXPECT_EQ(measure_nodes(flat).validity, CurvedValidity::undecided);
}

TEST(Curved, BezierFormIsTheDeterminant) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 100; ++i) {
    TenNodes nodes = straight(kUnitTet);
    for (Vec3& x : nodes) x = x + 0.3 * Vec3{uniform(random), uniform(random), uniform(random)};
    const JacobianPolynomial p = jacobian_of(nodes).polynomial;
    const std::array<double, 4> at{0.1, 0.2, 0.3, 0.4};
    // The polynomial is in units of a power of two.
    const double ratio = evaluate(p, {1, 0, 0, 0}) / plain_determinant(nodes, {1, 0, 0, 0});
    EXPECT_NEAR(evaluate(p, at), ratio * plain_determinant(nodes, at), 1e-11 * std::fabs(ratio));
    const auto parts = subdivide(p);
    EXPECT_NEAR(evaluate(parts[1], at), evaluate(p, {0.05, 0.6, 0.15, 0.2}), 1e-11 * std::fabs(ratio));
    // Part 5: its corners are the middles of 01, 02, 12, 13.
    EXPECT_NEAR(evaluate(parts[5], at), evaluate(p, {0.15, 0.4, 0.25, 0.2}), 1e-11 * std::fabs(ratio));
  }
}

/// Counts elements that are said to be valid and are not, and undecided ones, by dense sampling.
TEST(Curved, ProofAgreesWithSampling) {
  const char* const more = std::getenv("TETUNE_CURVED_ELEMENTS");
  const int elements = more != nullptr ? std::atoi(more) : 2000;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int false_valid = 0;
  int false_inverted = 0;
  int undecided = 0;
  int valid = 0;
  for (int i = 0; i < elements; ++i) {
    const auto shift = [&](double by) { return by * Vec3{uniform(random), uniform(random), uniform(random)}; };
    std::array<Vec3, 4> vertices = kUnitTet;
    for (Vec3& x : vertices) x = x + shift(0.3);
    TenNodes nodes = straight(vertices);
    const double size = 0.3 * std::fabs(uniform(random));
    for (std::size_t e = 4; e < 10; ++e) nodes[e] = nodes[e] + shift(size);
    const CurvedTet t = measure_nodes(nodes);
    const double least = sampled_minimum(nodes, 12);
    valid += t.validity == CurvedValidity::valid ? 1 : 0;
    undecided += t.validity == CurvedValidity::undecided ? 1 : 0;
    if (t.validity == CurvedValidity::valid && least <= 0) ++false_valid;
    const double size3 = std::fabs(jacobian_of(straight(vertices)).straight);
    if (t.validity == CurvedValidity::inverted && t.min_upper > -1e-3 * size3 && least > 0.05 * size3) ++false_inverted;
  }
  EXPECT_EQ(false_valid, 0);
  EXPECT_EQ(false_inverted, 0);
  EXPECT_LE(undecided, elements / 1000);
  EXPECT_GT(valid, elements / 4);
  EXPECT_LT(valid, elements - elements / 20);
  std::printf("%d elements: %d valid, %d undecided\n", elements, valid, undecided);
}

TEST(Curved, ProofIsIndependentOfScaleAndPlace) {
  TenNodes nodes = straight(kUnitTet);
  nodes[4].x += 0.2499;
  for (const double scale : {1.0, 1e-60, 1e60}) {
    TenNodes scaled = nodes;
    for (Vec3& x : scaled) x = scale * x;
    EXPECT_EQ(measure_nodes(scaled).validity, CurvedValidity::valid) << scale;
  }
  for (Vec3& x : nodes) x = x + Vec3{1e6, -1e6, 1e6};
  EXPECT_NE(measure_nodes(nodes).validity, CurvedValidity::inverted);
}

TEST(Curved, QualityCountsTheElementsOfCurvedEdges) {
  TetMesh m = test::cube(2);
  EXPECT_EQ(quality(m).curved.tets, 0);
  EXPECT_TRUE(measure_curved_each(m).empty());
  m.second_order = true;
  const auto edge = ascending(m.tets[0][0], m.tets[0][1]);
  const Point3& p = m.points[static_cast<std::size_t>(edge[0])];
  const Point3& q = m.points[static_cast<std::size_t>(edge[1])];
  m.curved_edges = {{edge, {0.5 * (p[0] + q[0]) + 0.02, 0.5 * (p[1] + q[1]), 0.5 * (p[2] + q[2])}}};
  const std::vector<CurvedTet> each = measure_curved_each(m);
  const Quality q1 = measure_all(m, 1, 3);
  const Quality q4 = measure_all(m, 4, 3);
  ASSERT_EQ(q1.curved.tets, std::ssize(each));
  EXPECT_EQ(q1.curved.valid, q1.curved.tets);
  EXPECT_LT(q1.curved.min_scaled_jacobian, 1);
  EXPECT_EQ(q1.curved.min_scaled_jacobian, q4.curved.min_scaled_jacobian);
  ASSERT_LE(q1.curved.worst.size(), 3U);
  EXPECT_EQ(q1.curved.worst[0].scaled_jacobian(), q1.curved.min_scaled_jacobian);
  m.curved_edges[0].middle[0] += 10;
  EXPECT_GT(measure_curved(m).inverted, 0);
  m.curved_edges.push_back(m.curved_edges[0]);
  EXPECT_THROW(static_cast<void>(measure_curved(m)), MeshError);
}

/// A cube whose upper face has mid-side nodes that are shifted upward or downward, but for those on its border.
TetMesh bulged_cube(double shift) {
  TetMesh m = test::cube(3, 0.15);
  m.second_order = true;
  std::vector<std::array<Index, 2>> edges;
  const auto top = [&m](Index v) { return m.points[static_cast<std::size_t>(v)][2] == 1; };
  const auto on_side = [&m](Index v, Index w) {
    const Point3& p = m.points[static_cast<std::size_t>(v)];
    const Point3& q = m.points[static_cast<std::size_t>(w)];
    return (p[0] == q[0] && (p[0] == 0 || p[0] == 1)) || (p[1] == q[1] && (p[1] == 0 || p[1] == 1));
  };
  for (const auto& tet : m.tets) {
    for (const auto& [i, j] : kCurvedTetEdges) {
      if (top(tet[i]) && top(tet[j]) && !on_side(tet[i], tet[j])) edges.push_back(ascending(tet[i], tet[j]));
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& e : edges) {
    const Point3& p = m.points[static_cast<std::size_t>(e[0])];
    const Point3& q = m.points[static_cast<std::size_t>(e[1])];
    m.curved_edges.push_back({e, {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, 1 + shift}});
  }
  return m;
}

/// The positions of the mid-side nodes of curved edges on the upper face, sorted.
std::vector<Point3> upper_middles(const TetMesh& m) {
  std::vector<Point3> middles;
  for (const CurvedEdge& e : m.curved_edges) {
    const auto z = [&m](Index v) { return m.points[static_cast<std::size_t>(v)][2]; };
    if (z(e.vertices[0]) == 1 && z(e.vertices[1]) == 1) middles.push_back(e.middle);
  }
  std::sort(middles.begin(), middles.end());
  return middles;
}

TEST(Curved, OptimizationKeepsTheSurfaceAndValidity) {
  for (const Boundary boundary : {Boundary::fixed, Boundary::preserve}) {
    for (const Effort effort : {Effort::standard, Effort::best}) {
      TetMesh m = bulged_cube(0.05);
      const TetMesh before = m;
      const Quality q = quality(before);
      ASSERT_TRUE(q.curved.all_valid());
      Options options;
      options.boundary = boundary;
      options.effort = effort;
      options.threads = 1;
      const Report report = optimize(m, options);
      const Quality after = quality(m);
      EXPECT_TRUE(validate(m).ok()) << validate(m).message(false);
      EXPECT_TRUE(after.curved.all_valid());
      EXPECT_GE(after.curved.min_scaled_jacobian, q.curved.min_scaled_jacobian - 3e-3);
      EXPECT_GE(after.dihedral_min, q.dihedral_min);
      // The mean, as vertices may be inserted.
      EXPECT_LT(after.shape_sum / double(m.tets.size()), q.shape_sum / double(before.tets.size()));
      EXPECT_EQ(upper_middles(m), upper_middles(before));
      EXPECT_EQ(m.triangles, before.triangles);
      EXPECT_EQ(report.tets_after, std::ssize(m.tets));
      TetMesh again = before;
      options.threads = 3;
      optimize(again, options);
      EXPECT_EQ(again.points, m.points);
      EXPECT_EQ(again.tets, m.tets);
      EXPECT_EQ(again.curved_edges, m.curved_edges);
    }
  }
}

TEST(Curved, InvertedElementsAreRefusedOrUntangled) {
  TetMesh m = bulged_cube(-0.2);
  const TetMesh before = m;
  ASSERT_GT(quality(m).curved.inverted, 0);
  EXPECT_THROW(optimize(m), MeshError);
  EXPECT_EQ(m.points, before.points);
  Options options;
  options.untangle = true;
  options.boundary = Boundary::fixed;
  const Report report = optimize(m, options);
  EXPECT_TRUE(validate(m).ok());
  EXPECT_TRUE(quality(m).curved.all_valid());
  EXPECT_EQ(upper_middles(m), upper_middles(before));
  EXPECT_EQ(report.vertices, std::ssize(before.points));
  for (const Index t : report.tet2original) EXPECT_LT(t, std::ssize(before.tets));
  for (std::size_t v = 0; v < m.points.size(); ++v) {
    const Index original = report.vertex2original.empty() ? Index(v) : report.vertex2original[v];
    if (original >= 0 && before.points[static_cast<std::size_t>(original)][2] == 1) {
      EXPECT_EQ(m.points[v], before.points[static_cast<std::size_t>(original)]);
    }
  }
}

/// A cube with a flat face that folds where one mid-side node passes a vertex.
TetMesh folded_cube() {
  TetMesh m = bulged_cube(0);
  CurvedEdge& edge = m.curved_edges[3];
  const Point3& p = m.points[static_cast<std::size_t>(edge.vertices[0])];
  const Point3& q = m.points[static_cast<std::size_t>(edge.vertices[1])];
  for (std::size_t k = 0; k < 2; ++k) edge.middle[k] = p[k] + 1.3 * (q[k] - p[k]);
  edge.middle[0] += 0.3 * (q[1] - p[1]);
  edge.middle[1] -= 0.3 * (q[0] - p[0]);
  return m;
}

TEST(Curved, FoldedSurfaceIsNamed) {
  TetMesh m = folded_cube();
  Options options;
  options.untangle = true;
  try {
    optimize(m, options);
    ADD_FAILURE() << "accepted";
  } catch (const MeshError& e) {
    EXPECT_NE(std::string(e.what()).find("mid-side nodes fold"), std::string::npos) << e.what();
  }
}

TEST(Curved, GradientOfTheRelaxationEnergyIsItsDerivative) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> shift(-0.05, 0.05);
  PatchElement element;
  for (std::size_t n = 0; n < 10; ++n) element.nodes[n] = n;
  element.inverse_ideal = inverse_of_edges({Vec3{0, 0, 0}, {1, 0.2, 0}, {0.1, 1, 0}, {0, 0.3, 1.1}});
  const TenNodes nodes = straight(kUnitTet);
  const std::vector<std::size_t> unknowns{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  RelaxationEnergy energy({element}, {nodes.begin(), nodes.end()}, unknowns);
  std::vector<double> x = energy.start();
  for (double& c : x) c += shift(random);
  std::vector<double> gradient(x.size());
  std::vector<double> ignored(x.size());
  for (const int power : {1, 4, 16}) {
    for (const double epsilon : {0.0, 0.3}) {
      energy.power = power;
      energy.epsilon = epsilon;
      energy(x, gradient);
      for (std::size_t i = 0; i < x.size(); ++i) {
        constexpr double kStep = 1e-6;
        std::vector<double> y = x;
        y[i] = x[i] + kStep;
        const double high = energy(y, ignored);
        y[i] = x[i] - kStep;
        const double slope = (high - energy(y, ignored)) / (2 * kStep);
        EXPECT_NEAR(gradient[i], slope, 1e-5 * (1 + std::fabs(slope)));
      }
    }
  }
}

TEST(Curved, HeldNodesBoundTheScaledJacobian) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> shift(-0.15, 0.15);
  const auto displace = [&](Vec3& x) { x = x + Vec3{shift(random), shift(random), shift(random)}; };
  const std::array<Index, 4> tet{0, 1, 2, 3};
  HeldNodes held{{1, 1, 1, 1}, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}}};
  for (int i = 0; i < 200; ++i) {
    TenNodes nodes = straight(kUnitTet);
    for (std::size_t k = 4; k < 10; ++k) displace(nodes[k]);
    const double bound = bound_by_held(tet, nodes, held);
    // The two faces at edge 01 are held, and with them what the determinant is there.
    for (const double s : {0.0, 0.25, 1.0}) EXPECT_LE(bound, plain_determinant(nodes, {1 - s, s, 0, 0}) + 1e-12);
    displace(nodes[9]);
    EXPECT_NEAR(bound_by_held(tet, nodes, held), bound, 1e-12);
    EXPECT_LE(measure_nodes(nodes).scaled_jacobian(), bound + 1e-12);
  }
  held.edges.erase(held.edges.begin());
  EXPECT_EQ(bound_by_held(tet, straight(kUnitTet), held), kInfinity);
}

/// A ball whose mid-side nodes of the surface are on the sphere: elements at former edges of the cube have two faces
/// there.
TetMesh curved_ball() {
  TetMesh m = test::ball(2, 0);
  m.second_order = true;
  std::set<std::array<Index, 2>> edges;
  for (const auto& face : test::skin(m)) {
    for (std::size_t k = 0; k < 3; ++k) edges.insert(ascending(face.v[k], face.v[(k + 1) % 3]));
  }
  for (const auto& edge : edges) {
    const Vec3 middle = test::at(m, edge[0]) + test::at(m, edge[1]);
    const Vec3 on_sphere = (1 / norm(middle)) * middle;
    m.curved_edges.push_back({edge, {on_sphere.x, on_sphere.y, on_sphere.z}});
  }
  return m;
}

TEST(Curved, ElementsWithTwoFacesOnASmoothSurfaceAreSplit) {
  const TetMesh before = curved_ball();
  Options options;
  options.untangle = true;
  options.max_growth = 3;
  TetMesh m = before;
  m.point_data.push_back({"id", 1, std::vector<std::int32_t>(m.points.size(), 7)});
  const Report report = optimize(m, options);
  EXPECT_TRUE(validate(m).ok());
  EXPECT_TRUE(quality(m).curved.all_valid());
  EXPECT_GT(quality(m).curved.min_scaled_jacobian, 0.2);
  EXPECT_GT(m.points.size(), before.points.size());
  EXPECT_EQ(report.tets_after, std::ssize(m.tets));
  ASSERT_EQ(report.tet2original.size(), m.tets.size());
  ASSERT_EQ(report.vertex2original.size(), m.points.size());
  EXPECT_EQ(std::get<std::vector<std::int32_t>>(m.point_data[0].values), std::vector<std::int32_t>(m.points.size(), 7));
  std::int64_t inserted = 0;
  for (std::size_t v = 0; v < m.points.size(); ++v) inserted += report.vertex2original[v] < 0 ? 1 : 0;
  EXPECT_EQ(inserted, std::ssize(m.points) - std::ssize(before.points));
  EXPECT_EQ(report.vertices_inserted, inserted);
  options.keep_vertices = true;
  m = before;
  EXPECT_THROW(optimize(m, options), UntangleError);
  EXPECT_EQ(m.curved_edges, before.curved_edges);
}

TEST(Curved, ElementsOfAValidMeshAreSplitWithTheirData) {
  TetMesh m = test::ball(3, 0);
  curve(m);
  ASSERT_TRUE(quality(m).curved.all_valid());
  const std::size_t vertices = m.points.size();
  m.point_data.push_back({"id", 1, std::vector<std::int32_t>(vertices, 7)});
  Options options;
  options.untangle = true;
  options.flips = false;
  const Report report = optimize(m, options);
  EXPECT_TRUE(quality(m).curved.all_valid());
  EXPECT_GT(m.points.size(), vertices);
  EXPECT_EQ(report.vertices_inserted, std::ssize(m.points) - static_cast<std::int64_t>(vertices));
  EXPECT_EQ(std::get<std::vector<std::int32_t>>(m.point_data[0].values), std::vector<std::int32_t>(m.points.size(), 7));
}

TEST(Curved, SplitsCountAsGrowth) {
  TetMesh before = test::ball(3, 0);
  curve(before);
  std::vector<std::size_t> tets;
  for (const Effort effort : {Effort::standard, Effort::best}) {
    for (const double growth : {1.0, 1.05, 2.0}) {
      TetMesh m = before;
      Options options;
      options.untangle = true;
      options.flips = false;
      options.effort = effort;
      options.max_growth = growth;
      const Report report = optimize(m, options);
      EXPECT_TRUE(quality(m).curved.all_valid());
      EXPECT_LE(double(m.tets.size()), growth * double(before.tets.size()));
      EXPECT_TRUE(report.warnings.empty());
      if (effort == Effort::standard) tets.push_back(m.tets.size());
    }
  }
  EXPECT_EQ(tets[0], before.tets.size());
  EXPECT_LT(tets[0], tets[1]);
  EXPECT_LT(tets[1], tets[2]);
}

/// The message of the refusal; empty if the mesh is optimized.
std::string curved_refusal(TetMesh m, const Options& options) {
  try {
    optimize(m, options);
    return "";
  } catch (const MeshError& e) {
    EXPECT_NE(std::string(e.what()).find("second-order tetrahedra that are not proved valid"), std::string::npos);
    return e.what();
  }
}

TEST(Curved, RefusalsSayWhatHelps) {
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  const TetMesh ball = curved_ball();
  Options helped;
  helped.untangle = true;
  helped.max_growth = 1;
  EXPECT_EQ(curved_refusal(ball, helped), "") << "splits that make elements valid are not limited";
  Options options = helped;
  options.data = DataTransfer::interpolate;
  EXPECT_TRUE(has(curved_refusal(ball, options), "inserted (data=carry)")) << curved_refusal(ball, options);
  options = helped;
  options.keep_vertices = true;
  const std::string kept = curved_refusal(ball, options);
  EXPECT_TRUE(has(kept, "inserted (without keep_vertices), ")) << kept;
  EXPECT_TRUE(has(kept, "straighten=true")) << kept;
  EXPECT_FALSE(has(kept, "free frozen")) << kept;
  EXPECT_FALSE(has(kept, "boundary=slide")) << kept;
  options.straighten = true;
  EXPECT_EQ(curved_refusal(ball, options), "");
  options.frozen_regions = {ball.tet_tags[0]};
  const std::string frozen = curved_refusal(ball, options);
  EXPECT_TRUE(has(frozen, "free frozen and required entities there")) << frozen;
  EXPECT_FALSE(has(frozen, "straighten=true")) << frozen;
}

std::int64_t vertices_by_freedom(const Report& r) {
  return r.free_vertices + r.plane_vertices + r.line_vertices + r.fixed_vertices + r.surface_vertices +
         r.curve_vertices;
}

TEST(Curved, TheReportIsOfTheInputAndTheResult) {
  TetMesh jittered = test::ball(3, 0.15);
  curve(jittered);
  for (const TetMesh& before : {curved_ball(), jittered}) {
    for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
      Options options;
      options.untangle = true;
      options.max_growth = 3;
      options.boundary = boundary;
      TetMesh m = before;
      const Report report = optimize(m, options);
      EXPECT_GT(report.vertices_inserted, 0);
      EXPECT_EQ(report.vertices, std::ssize(before.points));
      EXPECT_EQ(vertices_by_freedom(report), std::ssize(before.points));
      const bool slides = boundary == Boundary::slide;
      EXPECT_EQ(report.surface_vertices > 0, slides);
      EXPECT_EQ(report.energy_before, quality(before).shape_sum);
      EXPECT_EQ(report.energy_after, quality(m).shape_sum);
    }
  }
}

TEST(Curved, EdgesThatAreStraightToTheRoundingOfTheirCoordinatesHoldNoVertex) {
  // Coordinates of 15 digits, as in files.
  const auto rounded = [](double x) { return std::round(x * 1e8) / 1e8; };
  TetMesh m = test::cube(3, 0.15);
  for (Point3& p : m.points) p = {rounded(1e6 + p[0]), rounded(1e6 + p[1]), rounded(1e6 + p[2])};
  TetMesh straight = m;
  std::set<std::array<Index, 2>> edges;
  for (const auto& face : test::skin(m)) {
    for (std::size_t k = 0; k < 3; ++k) edges.insert(ascending(face.v[k], face.v[(k + 1) % 3]));
  }
  m.second_order = true;
  for (const auto& edge : edges) {
    const Vec3 middle = 0.5 * (test::at(m, edge[0]) + test::at(m, edge[1]));
    const Point3 in_file{rounded(middle.x), rounded(middle.y), rounded(middle.z)};
    if (vec(in_file).x != middle.x || vec(in_file).y != middle.y || vec(in_file).z != middle.z) {
      m.curved_edges.push_back({edge, in_file});
    }
  }
  ASSERT_GT(m.curved_edges.size(), 50U);
  const Report expected = optimize(straight);
  const Report report = optimize(m);
  EXPECT_GT(report.plane_vertices, 0);
  EXPECT_EQ(report.plane_vertices, expected.plane_vertices);
  EXPECT_EQ(report.fixed_vertices, expected.fixed_vertices);
}

TEST(Curved, VerticesThatSlideDoNotHoldElements) {
  TetMesh m = test::ball(4, 0.15);
  curve(m);
  Options options;
  options.boundary = Boundary::slide;
  options.targets = {{Measure::scaled_jacobian, 0.7}};
  const Report report = optimize(m, options);
  ASSERT_GT(report.surface_vertices, 0);
  ASSERT_EQ(report.fixed_vertices, 0);
  const auto held_by = [&](LimitingConstraint c) { return report.targets.at(0).held_by[std::size_t(c)]; };
  EXPECT_GT(held_by(LimitingConstraint::boundary), 0);
  EXPECT_EQ(held_by(LimitingConstraint::fixed_vertices), 0);
  EXPECT_EQ(held_by(LimitingConstraint::feature_corner), 0);
  EXPECT_EQ(held_by(LimitingConstraint::feature_line), 0);
}

TEST(Curved, TargetsAreThoseOfTheResult) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide}) {
    TetMesh m = test::ball(4, 0.15);
    curve(m);
    Options options;
    options.boundary = boundary;
    options.targets = {{Measure::min_dihedral, 30}, {Measure::min_dihedral, 5}};
    const Report report = optimize(m, options);
    const double smallest = quality(m).dihedral_min;
    ASSERT_EQ(report.targets.size(), 2U);
    for (const TargetReport& t : report.targets) {
      EXPECT_EQ(t.met(), smallest >= t.target.value) << smallest;
      if (t.met()) continue;
      EXPECT_NEAR(t.worst.front().value, smallest, 1e-9);
    }
  }
}

TEST(Curved, FoldedSurfaceIsStraightenedWhereAsked) {
  const TetMesh before = folded_cube();
  TetMesh m = before;
  Options options;
  options.untangle = true;
  options.straighten = true;
  options.keep_vertices = true;
  options.max_iterations = 0;
  const Report report = optimize(m, options);
  EXPECT_TRUE(validate(m).ok());
  EXPECT_TRUE(quality(m).curved.all_valid());
  // The other edges of the surface have all of their curvature.
  ASSERT_EQ(report.straightened.size(), 1U);
  const StraightenedEdge& e = report.straightened[0];
  EXPECT_EQ(e.vertices, before.curved_edges[3].vertices);
  EXPECT_GT(e.kept, 0.1);
  EXPECT_LT(e.kept, 1);
  const auto full = before.curved_edges[3].middle;
  double moved = 0;
  for (const CurvedEdge& c : m.curved_edges) {
    if (c.vertices == e.vertices) {
      moved = std::hypot(c.middle[0] - full[0], c.middle[1] - full[1], c.middle[2] - full[2]);
    }
  }
  EXPECT_NEAR(moved, e.moved, 1e-12);

  options.frozen_regions = {before.tet_tags[0]};
  TetMesh frozen = before;
  EXPECT_THROW(optimize(frozen, options), MeshError);
  EXPECT_EQ(frozen.curved_edges, before.curved_edges);
}

}  // namespace
}  // namespace tetune
