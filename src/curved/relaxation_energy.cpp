// SPDX-License-Identifier: Apache-2.0
#include "curved/relaxation_energy.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "math/elementary.hpp"

namespace tetune {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMatrices = 36;

/// The derivatives of the shape functions with respect to the reference coordinates, per Jacobian matrix and node.
using Derivatives = std::array<std::array<Vec3, 10>, kMatrices>;

/// At the points of a lattice with four steps per edge; then those of the straight element.
Derivatives make_derivatives() {
  const std::array<Vec3, 4> slopes{Vec3{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Derivatives all{};
  std::size_t n = 0;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; i + j <= 4; ++j) {
      for (int k = 0; i + j + k <= 4; ++k) {
        const std::array<double, 4> at{(4 - i - j - k) / 4.0, i / 4.0, j / 4.0, k / 4.0};
        for (std::size_t v = 0; v < 4; ++v) all[n][v] = (4 * at[v] - 1) * slopes[v];
        for (std::size_t e = 0; e < 6; ++e) {
          const auto& [a, b] = kCurvedTetEdges[e];
          all[n][4 + e] = 4 * at[b] * slopes[a] + 4 * at[a] * slopes[b];
        }
        ++n;
      }
    }
  }
  for (std::size_t v = 0; v < 4; ++v) all[n][v] = slopes[v];
  for (std::size_t e = 4; e < 10; ++e) all[n][e] = {0, 0, 0};
  return all;
}

const Derivatives& derivatives() {
  static const Derivatives all = make_derivatives();
  return all;
}

double power_of(double x, int n) {
  double result = 1;
  for (int i = 0; i < n; ++i) result *= x;
  return result;
}

/// chi and its derivative divided by it.
std::pair<double, double> regularized(double d, double epsilon) {
  const double root = std::sqrt(epsilon * epsilon + d * d);
  const double chi = d > 0 ? 0.5 * (d + root) : 0.5 * epsilon * epsilon / (root - d);
  return {chi, 1 / root};
}

/// The columns of the Jacobian matrix relative to the ideal shape.
std::array<Vec3, 3> relative_jacobian(const PatchElement& element, const std::vector<Vec3>& nodes, std::size_t point) {
  std::array<Vec3, 3> columns{Vec3{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  for (std::size_t n = 0; n < 10; ++n) {
    const Vec3& x = nodes[element.nodes[n]];
    const Vec3& g = derivatives()[point][n];
    columns[0] = columns[0] + g.x * x;
    columns[1] = columns[1] + g.y * x;
    columns[2] = columns[2] + g.z * x;
  }
  const auto& [r0, r1, r2] = element.inverse_ideal;
  return {r0.x * columns[0] + r1.x * columns[1] + r2.x * columns[2],
          r0.y * columns[0] + r1.y * columns[1] + r2.y * columns[2],
          r0.z * columns[0] + r1.z * columns[1] + r2.z * columns[2]};
}

}  // namespace

std::array<Vec3, 3> inverse_of_edges(const std::array<Vec3, 4>& vertices) {
  const Vec3 a = vertices[1] - vertices[0];
  const Vec3 b = vertices[2] - vertices[0];
  const Vec3 c = vertices[3] - vertices[0];
  const double inverse = 1 / dot(cross(a, b), c);
  return {inverse * cross(b, c), inverse * cross(c, a), inverse * cross(a, b)};
}

RelaxationEnergy::RelaxationEnergy(std::vector<PatchElement> elements, std::vector<Vec3> nodes,
                                   std::vector<std::size_t> unknowns)
    : elements_(std::move(elements)), nodes_(std::move(nodes)), unknowns_(std::move(unknowns)) {}

std::vector<double> RelaxationEnergy::start() const {
  std::vector<double> x;
  for (const std::size_t n : unknowns_) x.insert(x.end(), {nodes_[n].x, nodes_[n].y, nodes_[n].z});
  return x;
}

std::vector<Vec3> RelaxationEnergy::nodes_at(const std::vector<double>& x) const {
  std::vector<Vec3> nodes = nodes_;
  for (std::size_t i = 0; i < unknowns_.size(); ++i) nodes[unknowns_[i]] = {x[3 * i], x[3 * i + 1], x[3 * i + 2]};
  return nodes;
}

double RelaxationEnergy::operator()(const std::vector<double>& x, std::vector<double>& gradient) const {
  const std::vector<Vec3> nodes = nodes_at(x);
  std::vector<Vec3> forces(nodes.size(), Vec3{0, 0, 0});
  double energy = 0;
  for (const PatchElement& element : elements_) {
    energy += add_element(element, nodes, forces);
    if (!(energy < kInfinity)) return kInfinity;
  }
  for (std::size_t i = 0; i < unknowns_.size(); ++i) {
    const Vec3& f = forces[unknowns_[i]];
    gradient[3 * i] = f.x;
    gradient[3 * i + 1] = f.y;
    gradient[3 * i + 2] = f.z;
  }
  return energy;
}

double RelaxationEnergy::smallest_determinant(const std::vector<double>& x) const {
  const std::vector<Vec3> nodes = nodes_at(x);
  double least = kInfinity;
  for (const PatchElement& element : elements_) {
    for (std::size_t p = 0; p < kMatrices; ++p) {
      const auto j = relative_jacobian(element, nodes, p);
      least = std::min(least, dot(cross(j[0], j[1]), j[2]));
    }
  }
  return least;
}

double RelaxationEnergy::add_element(const PatchElement& element, const std::vector<Vec3>& nodes,
                                     std::vector<Vec3>& forces) const {
  double energy = 0;
  for (std::size_t p = 0; p < kMatrices; ++p) {
    const auto j = relative_jacobian(element, nodes, p);
    const std::array<Vec3, 3> cofactor{cross(j[1], j[2]), cross(j[2], j[0]), cross(j[0], j[1])};
    const double d = dot(cofactor[2], j[2]);
    if (epsilon == 0 && !(d > 0)) return kInfinity;
    const auto [chi, log_slope] = regularized(d, epsilon);
    const double cube_root = elementary::cbrt(chi);
    const double shape = (dot(j[0], j[0]) + dot(j[1], j[1]) + dot(j[2], j[2])) / (3 * cube_root * cube_root);
    const double size = (d * d + 1) / (2 * chi);
    const double mean = 0.5 * (shape + size);
    energy += power_of(mean, power);
    const double outer = 0.5 * power * power_of(mean, power - 1);
    // d shape = along_j J - 2/3 shape chi'/chi cofactor; d size = (D / chi - size chi'/chi) cofactor.
    const double along_j = outer * 2 / (3 * cube_root * cube_root);
    const double along_cofactor = outer * (d / chi - (size + 2 * shape / 3) * log_slope);
    std::array<Vec3, 3> slope{};
    for (std::size_t k = 0; k < 3; ++k) slope[k] = along_j * j[k] + along_cofactor * cofactor[k];
    for (std::size_t n = 0; n < 10; ++n) {
      const Vec3& g = derivatives()[p][n];
      const auto& [r0, r1, r2] = element.inverse_ideal;
      const Vec3 h = g.x * r0 + g.y * r1 + g.z * r2;
      Vec3& force = forces[element.nodes[n]];
      force = force + h.x * slope[0] + h.y * slope[1] + h.z * slope[2];
    }
  }
  return energy;
}

}  // namespace tetune
