// SPDX-License-Identifier: Apache-2.0
#include "reference/alexa.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "boundary/closest_triangle.hpp"
#include "energy/harmonic.hpp"
#include "reference/ordered_flips.hpp"
#include "relocate/brent.hpp"

namespace tetune::reference {
namespace {

constexpr double kTrace = 1.0 / 9;
/// Descent has converged when so many rounds in a row lower the energy by a smaller part of it each. Ours ends at the
/// first such; here one tetrahedron can hold up a step that the next one makes good.
constexpr double kConverged = 1e-4;
constexpr int kIdleRounds = 5;

std::vector<Vec3> to_vectors(const TetMesh& mesh) {
  std::vector<Vec3> points;
  points.reserve(mesh.points.size());
  for (const Point3& p : mesh.points) points.push_back(vec(p));
  return points;
}

void store_tets(const OrderedFlips& flips, TetMesh& mesh) {
  mesh.tets.clear();
  mesh.tet_tags.clear();
  for (std::size_t t = 0; t < flips.tets().size(); ++t) {
    if (!flips.alive(t)) continue;
    const Tet& tet = flips.tets()[t];
    mesh.tets.push_back({tet[0], tet[1], tet[2], tet[3]});
    mesh.tet_tags.push_back(flips.tag(t));
  }
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// One descent step of the whole mesh at a time.
class Descent {
 public:
  Descent(std::vector<Vec3>& points, const OrderedFlips& flips, const TetMesh& mesh)
      : points_(points), flips_(flips), fixed_(points.size(), 0), on_surface_(points.size(), 0), surface_({}) {
    for (const Index v : mesh.required_vertices) fixed_[static_cast<std::size_t>(v)] = 1;
    std::vector<TrianglePoints> triangles;
    for (std::size_t t = 0; t < flips.tets().size(); ++t) {
      for (int f = 0; f < 4; ++f) {
        if (!is_locked(flips.across(t, f))) continue;
        TrianglePoints triangle;
        for (int k = 0; k < 3; ++k) {
          const auto v = static_cast<std::size_t>(flips.tets()[t][face_vertex(f, k)]);
          triangle[static_cast<std::size_t>(k)] = points[v];
          on_surface_[v] = 1;
        }
        triangles.push_back(triangle);
        if (mean_edge_ == 0) mean_edge_ = norm(triangle[1] - triangle[0]);
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
    worst_ = 0;
    for (const Tet& t : flips_.tets()) {
      if (t[0] >= 0) worst_ = std::max(worst_, energy_of(t).energy);
    }
    if (lambda > 0) {
      const double alpha = brent_minimum(Energy{*this}, 0, lambda);
      move(alpha);
    }
    report.descent_seconds += seconds_since(start);
    const auto projection = std::chrono::steady_clock::now();
    put_back();
    take_back_damage();
    report.projection_seconds += seconds_since(projection);
    return kTrace * kTrace * gradient2;
  }

  double energy() const {
    double sum = 0;
    for (const Tet& t : flips_.tets()) {
      if (t[0] >= 0) sum += energy_of(t).energy;
    }
    return sum;
  }

 private:
  /// The energy along the descent, for Brent's method.
  struct Energy {
    Descent& descent;
    double value(double alpha) const {
      descent.move(alpha);
      return descent.energy();
    }
  };

  const Vec3& at(Index v) const { return points_[static_cast<std::size_t>(v)]; }
  TetEnergy energy_of(const Tet& t) const { return tet_energy(kHarmonicLaw, at(t[0]), at(t[1]), at(t[2]), at(t[3])); }

  double assemble_gradient() {
    gradient_.assign(points_.size(), Vec3{0, 0, 0});
    for (const Tet& t : flips_.tets()) {
      if (t[0] < 0) continue;
      for (int k = 0; k < 4; ++k) {
        const OppositeFace<double> f =
            opposite_face(at(t[face_vertex(k, 0)]), at(t[face_vertex(k, 1)]), at(t[face_vertex(k, 2)]));
        const Vec3 y = at(t[k]) - f.p0;
        const AreaTerm<double> term = area_term_gradient(f, y);
        const double w = std::max(dot(f.n, y), kOrientBound * permanent(f.a, f.b, y));
        Vec3& g = gradient_[static_cast<std::size_t>(t[k])];
        g = g + (2 * kHarmonicLaw.factor / w) * (term.h - (0.5 * term.q / w) * f.n);
      }
    }
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

  bool inverted() const {
    return std::any_of(flips_.tets().begin(), flips_.tets().end(),
                       [this](const Tet& t) { return t[0] >= 0 && !energy_of(t).certified; });
  }

  /// A step along the gradient that inverts nothing, by binary search: halved from one that moves some vertex by a mean
  /// edge, then sharpened.
  double inversion_free_step() {
    before_ = points_;
    double largest = 0;
    for (const Vec3& g : gradient_) largest = std::max(largest, norm(g));
    if (largest == 0) return 0;
    double high = mean_edge_ / largest;
    double low = 0;
    constexpr int kHalvings = 60;
    constexpr int kSharpenings = 4;
    int sharpenings = 0;
    for (int i = 0; i < kHalvings && sharpenings < kSharpenings; ++i) {
      const double middle = low > 0 ? 0.5 * (low + high) : high;
      move(middle);
      if (inverted()) {
        high = low > 0 ? middle : 0.5 * high;
      } else {
        if (low == middle) break;
        low = middle;
        if (i == 0) break;  // the first try was free already
        if (sharpenings == 0) high = 2 * middle;
      }
      if (low > 0) ++sharpenings;
    }
    points_ = before_;
    return low;
  }

  /// Boundary vertices go to the closest point of the input surface.
  void put_back() {
    for (std::size_t v = 0; v < points_.size(); ++v) {
      if (on_surface_[v] != 0 && fixed_[v] == 0) points_[v] = surface_.closest(points_[v]).point;
    }
  }

  /// Worse than the worst before the step, or inverted.
  bool damaged(const Tet& t) const {
    const TetEnergy e = energy_of(t);
    return !e.certified || e.energy > worst_;
  }

  /// Vertices of tetrahedra that reprojection damaged go back to where they were: those on the boundary first.
  void take_back_damage() {
    for (const bool boundary_only : {true, false}) {
      for (bool found = true; found;) {
        found = false;
        for (const Tet& t : flips_.tets()) {
          if (t[0] < 0 || !damaged(t)) continue;
          for (int k = 0; k < 4; ++k) {
            const auto v = static_cast<std::size_t>(t[k]);
            if (boundary_only && on_surface_[v] == 0) continue;
            const Vec3 moved = points_[v] - before_[v];
            if (dot(moved, moved) == 0) continue;
            points_[v] = before_[v];
            found = true;
          }
        }
      }
    }
  }

  std::vector<Vec3>& points_;
  const OrderedFlips& flips_;
  std::vector<char> fixed_, on_surface_;
  ClosestTriangle surface_;
  double mean_edge_ = 0;
  double worst_ = 0;  ///< eta before the step
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
    const FlipResult found = flips.run();
    const double seconds = seconds_since(flip_start);
    report.flip_seconds += seconds;
    if (i == 0) report.first_flip_seconds = seconds;
    report.flips23 += found.flips23;
    report.flips32 += found.flips32;
    iteration.flips = found.flips23 + found.flips32;
    if (i > 0 && iteration.flips == 0 && (end == AlexaEnd::no_flips || idle >= kIdleRounds)) {
      report.finished = true;
      break;
    }
    const double before = i > 0 ? report.iterations.back().energy : report.energy_before;
    iteration.gradient_norm = descent.step(report);
    iteration.energy = descent.energy();
    idle = before - iteration.energy < kConverged * iteration.energy ? idle + 1 : 0;
    report.iterations.push_back(iteration);
  }
  report.energy_after = descent.energy();
  store_tets(flips, mesh);
  for (std::size_t v = 0; v < points.size(); ++v) mesh.points[v] = {points[v].x, points[v].y, points[v].z};
  report.seconds = seconds_since(start);
  return report;
}

}  // namespace tetune::reference
