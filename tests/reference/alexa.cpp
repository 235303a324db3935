// SPDX-License-Identifier: Apache-2.0
#include "reference/alexa.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "energy/harmonic.hpp"
#include "math/brent.hpp"
#include "math/closest_triangle.hpp"
#include "reference/ordered_flips.hpp"

namespace tetune::reference {
namespace {

/// tr(L) = eta / 9.
constexpr double kTracePerEta = 1.0 / 9;
/// The descent has converged when kMaxIdleIterations consecutive iterations lower the energy by less than this factor
/// of it each: a single tetrahedron can prevent the progress of one step.
constexpr double kMinRelativeDecrease = 1e-4;
constexpr int kMaxIdleIterations = 5;

std::vector<Vec3> to_vectors(const TetMesh& mesh) {
  std::vector<Vec3> points;
  points.reserve(mesh.points.size());
  for (const Point3& p : mesh.points) points.push_back(vec(p));
  return points;
}

void store_tets(const OrderedFlips& flips, TetMesh& mesh) {
  mesh.tets.clear();
  mesh.tet_tags.clear();
  for (Index t = 0; t < flips.tets().size(); ++t) {
    if (!flips.alive(t)) continue;
    const Tet& tet = flips.tets()[t];
    mesh.tets.push_back({tet[0], tet[1], tet[2], tet[3]});
    mesh.tet_tags.push_back(flips.tag(t));
  }
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Gradient descent of all vertices with one step size.
class Descent {
 public:
  Descent(std::vector<Vec3>& points, const OrderedFlips& flips, const TetMesh& mesh)
      : points_(points), flips_(flips), fixed_(points.size(), 0), on_surface_(points.size(), 0), surface_({}) {
    for (const Index v : mesh.required_vertices) span_of(fixed_)[v] = 1;
    std::vector<TrianglePoints> triangles;
    for (Index t = 0; t < flips.tets().size(); ++t) {
      for (int f = 0; f < 4; ++f) {
        if (!is_locked(flips.across(t, f))) continue;
        const Tet& tet = flips.tets()[t];
        const Index v[3] = {tet[face_vertex(f, 0)], tet[face_vertex(f, 1)], tet[face_vertex(f, 2)]};
        const TrianglePoints triangle{at(v[0]), at(v[1]), at(v[2])};
        for (const Index corner : v) span_of(on_surface_)[corner] = 1;
        triangles.push_back(triangle);
        if (edge_length_ == 0) edge_length_ = norm(triangle[1] - triangle[0]);
      }
    }
    surface_ = ClosestTriangle(std::move(triangles));
  }

  /// Returns the squared norm of the gradient of the trace before the step.
  double step(AlexaReport& report) {
    const auto start = std::chrono::steady_clock::now();
    const double gradient2 = assemble_gradient();
    const double lambda = inversion_free_step();
    before_ = points_;
    max_eta_ = 0;
    for_each_tet([this](const Tet& t) { max_eta_ = std::max(max_eta_, energy_of(t).energy); });
    const auto energy_after = [this](double alpha) {
      move(alpha);
      return energy();
    };
    if (lambda > 0) move(brent_minimum(energy_after, 0, lambda));
    report.descent_seconds += seconds_since(start);
    const auto projection = std::chrono::steady_clock::now();
    project_to_surface();
    revert_damaged_tets();
    report.projection_seconds += seconds_since(projection);
    return kTracePerEta * kTracePerEta * gradient2;
  }

  double energy() const {
    double sum = 0;
    for_each_tet([this, &sum](const Tet& t) { sum += energy_of(t).energy; });
    return sum;
  }

 private:
  const Vec3& at(Index v) const { return span_of(points_)[v]; }
  template <class F>
  void for_each_tet(const F& f) const {
    for (Index t = 0; t < flips_.tets().size(); ++t) {
      if (flips_.alive(t)) f(flips_.tets()[t]);
    }
  }
  TetEnergy energy_of(const Tet& t) const {
    return tet_energy(kHarmonicObjective, at(t[0]), at(t[1]), at(t[2]), at(t[3]));
  }

  double assemble_gradient() {
    gradient_.assign(points_.size(), Vec3{0, 0, 0});
    for_each_tet([this](const Tet& t) {
      for (int k = 0; k < 4; ++k) {
        const OppositeFace<double> f =
            opposite_face(at(t[face_vertex(k, 0)]), at(t[face_vertex(k, 1)]), at(t[face_vertex(k, 2)]));
        const Vec3 y = at(t[k]) - f.p0;
        const AreaTerm<double> term = area_term_gradient(f, y);
        const double w = std::max(dot(f.n, y), kOrientBound * permanent(f.a, f.b, y));
        Vec3& g = span_of(gradient_)[t[k]];
        g = g + (2 * kHarmonicObjective.factor / w) * (term.h - (0.5 * term.q / w) * f.n);
      }
    });
    double sum = 0;
    for (std::size_t v = 0; v < points_.size(); ++v) {
      if (fixed_[v] != 0) gradient_[v] = {0, 0, 0};
      sum += dot(gradient_[v], gradient_[v]);
    }
    return sum;
  }

  void move(double alpha) {
    for (std::size_t v = 0; v < points_.size(); ++v) points_[v] = before_[v] - alpha * gradient_[v];
  }

  bool has_inverted_tet() const {
    for (Index t = 0; t < flips_.tets().size(); ++t) {
      if (flips_.alive(t) && !energy_of(flips_.tets()[t]).certified) return true;
    }
    return false;
  }

  /// A step size that inverts no tetrahedron, by binary search: halved from one that moves some vertex by an edge
  /// length until no tetrahedron is inverted, then refined.
  double inversion_free_step() {
    before_ = points_;
    double largest = 0;
    for (const Vec3& g : gradient_) largest = std::max(largest, norm(g));
    if (largest == 0) return 0;
    double high = edge_length_ / largest;
    double low = 0;
    constexpr int kMaxTrials = 60;
    constexpr int kMaxRefinements = 4;
    int refinements = 0;
    for (int i = 0; i < kMaxTrials && refinements < kMaxRefinements; ++i) {
      const double middle = low > 0 ? 0.5 * (low + high) : high;
      move(middle);
      if (has_inverted_tet()) {
        high = low > 0 ? middle : 0.5 * high;
      } else {
        if (low == middle) break;
        low = middle;
        if (i == 0) break;  // the first trial succeeded
        if (refinements == 0) high = 2 * middle;
      }
      if (low > 0) ++refinements;
    }
    points_ = before_;
    return low;
  }

  /// Moves boundary vertices to the closest point of the input surface.
  void project_to_surface() {
    for (std::size_t v = 0; v < points_.size(); ++v) {
      if (on_surface_[v] != 0 && fixed_[v] == 0) points_[v] = surface_.closest(points_[v]).point;
    }
  }

  /// Whether a tetrahedron is inverted, or worse than the worst one before the step.
  bool is_damaged(const Tet& t) const {
    const TetEnergy e = energy_of(t);
    return !e.certified || e.energy > max_eta_;
  }

  /// Moves the vertices of tetrahedra that the projection damaged back to their positions before the step: first those
  /// on the boundary, then all.
  void revert_damaged_tets() {
    for (const bool boundary_only : {true, false}) {
      for (bool changed = true; changed;) {
        changed = false;
        for_each_tet([&](const Tet& t) {
          if (!is_damaged(t)) return;
          for (const Index v : t.v) {
            if (boundary_only && span_of(on_surface_)[v] == 0) continue;
            const Vec3 displacement = at(v) - span_of(before_)[v];
            if (dot(displacement, displacement) == 0) continue;
            span_of(points_)[v] = span_of(before_)[v];
            changed = true;
          }
        });
      }
    }
  }

  std::vector<Vec3>& points_;
  const OrderedFlips& flips_;
  std::vector<char> fixed_, on_surface_;
  ClosestTriangle surface_;
  double edge_length_ = 0;
  double max_eta_ = 0;  ///< before the step
  std::vector<Vec3> gradient_, before_;
};

}  // namespace

FlipResult flip_in_order(TetMesh& mesh) {
  const std::vector<Vec3> points = to_vectors(mesh);
  OrderedFlips flips(points, mesh);
  const FlipResult result = flips.run();
  store_tets(flips, mesh);
  return result;
}

AlexaReport optimize(TetMesh& mesh, AlexaEnd end, int max_iterations) {
  const auto start = std::chrono::steady_clock::now();
  AlexaReport report;
  std::vector<Vec3> points = to_vectors(mesh);
  OrderedFlips flips(points, mesh);
  Descent descent(points, flips, mesh);
  report.energy_before = descent.energy();
  int idle = 0;
  for (int i = 0; i < max_iterations; ++i) {
    Iteration iteration;
    const auto flip_start = std::chrono::steady_clock::now();
    const FlipResult pass = flips.run();
    const double seconds = seconds_since(flip_start);
    report.flip_seconds += seconds;
    if (i == 0) report.first_flip_seconds = seconds;
    report.flips23 += pass.flips23;
    report.flips32 += pass.flips32;
    iteration.flips = pass.flips23 + pass.flips32;
    if (i > 0 && iteration.flips == 0 && (end == AlexaEnd::no_flips || idle >= kMaxIdleIterations)) {
      report.finished = true;
      break;
    }
    const double before = i > 0 ? report.iterations.back().energy : report.energy_before;
    iteration.gradient_norm = descent.step(report);
    iteration.energy = descent.energy();
    idle = before - iteration.energy < kMinRelativeDecrease * iteration.energy ? idle + 1 : 0;
    report.iterations.push_back(iteration);
  }
  report.energy_after = descent.energy();
  store_tets(flips, mesh);
  for (std::size_t v = 0; v < points.size(); ++v) mesh.points[v] = {points[v].x, points[v].y, points[v].z};
  report.seconds = seconds_since(start);
  return report;
}

}  // namespace tetune::reference
