// SPDX-License-Identifier: Apache-2.0
#include "curved/relaxation_energy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "math/elementary.hpp"

namespace tetune {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMatrices = 36;

/// One number per Jacobian matrix: loops over them are vectorized.
using Values = std::array<double, kMatrices>;
/// A vector per matrix, by components.
using VectorValues = std::array<Values, 3>;

/// The derivatives of the shape functions, as polynomials in barycentric coordinates, per matrix: by coordinate a that
/// of vertex a is `vertex[a]`, and that of the mid-side node of ab is `edge[b]`.
struct Weights {
  std::array<Values, 4> vertex, edge;
};

/// At the points of a lattice with four steps per edge; then those of the straight element.
Weights make_weights() {
  Weights weights{};
  std::size_t point = 0;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; i + j <= 4; ++j) {
      for (int k = 0; i + j + k <= 4; ++k) {
        const std::array<int, 4> steps{4 - i - j - k, i, j, k};
        for (std::size_t v = 0; v < 4; ++v) {
          weights.vertex[v][point] = steps[v] - 1;
          weights.edge[v][point] = steps[v];
        }
        ++point;
      }
    }
  }
  for (std::size_t v = 0; v < 4; ++v) weights.vertex[v][point] = 1;
  return weights;
}

const Weights& weights() {
  static const Weights all = make_weights();
  return all;
}

void add_product(VectorValues& sum, const Values& factors, const Vec3& x) {
  for (std::size_t p = 0; p < kMatrices; ++p) {
    sum[0][p] += factors[p] * x.x;
    sum[1][p] += factors[p] * x.y;
    sum[2][p] += factors[p] * x.z;
  }
}

/// Sum over the matrices, in four partial sums.
Vec3 sum_of_products(const Values& factors, const VectorValues& v) {
  static_assert(kMatrices % 4 == 0);
  std::array<std::array<double, 4>, 3> sums{};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t p = 0; p < kMatrices; p += 4) {
      for (std::size_t l = 0; l < 4; ++l) sums[c][l] += factors[p + l] * v[c][p + l];
    }
  }
  const auto total = [](const std::array<double, 4>& s) { return (s[0] + s[1]) + (s[2] + s[3]); };
  return {total(sums[0]), total(sums[1]), total(sums[2])};
}

Values powers_of(Values x, int n) {
  Values result;
  result.fill(1);
  for (; n > 0; n /= 2) {
    for (std::size_t p = 0; p < kMatrices; ++p) {
      if (n % 2 == 1) result[p] *= x[p];
      x[p] *= x[p];
    }
  }
  return result;
}

/// chi and its derivative divided by it.
std::pair<double, double> regularized(double d, double epsilon) {
  const double root = std::sqrt(epsilon * epsilon + d * d);
  const double chi = d > 0 ? 0.5 * (d + root) : 0.5 * epsilon * epsilon / (root - d);
  return {chi, 1 / root};
}

/// Sum of factors[i] * columns[i].
void combine(const std::array<double, 3>& factors, const std::array<VectorValues, 3>& columns, VectorValues& sum) {
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t p = 0; p < kMatrices; ++p) {
      sum[c][p] = factors[0] * columns[0][c][p] + factors[1] * columns[1][c][p] + factors[2] * columns[2][c][p];
    }
  }
}

/// The columns of the Jacobian matrices relative to the ideal shape.
std::array<VectorValues, 3> relative_jacobians(const PatchElement& element, const std::vector<Vec3>& nodes) {
  std::array<VectorValues, 4> by_coordinate{};
  const auto at = [&](std::size_t n) { return nodes[element.nodes[n]]; };
  for (std::size_t v = 0; v < 4; ++v) add_product(by_coordinate[v], weights().vertex[v], at(v));
  for (std::size_t e = 0; e < 6; ++e) {
    const auto& [a, b] = kCurvedTetEdges[e];
    add_product(by_coordinate[a], weights().edge[b], at(4 + e));
    add_product(by_coordinate[b], weights().edge[a], at(4 + e));
  }
  std::array<VectorValues, 3> columns;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t p = 0; p < kMatrices; ++p)
        columns[k][c][p] = by_coordinate[k + 1][c][p] - by_coordinate[0][c][p];
    }
  }
  const auto& [r0, r1, r2] = element.inverse_ideal;
  std::array<VectorValues, 3> relative;
  combine({r0.x, r1.x, r2.x}, columns, relative[0]);
  combine({r0.y, r1.y, r2.y}, columns, relative[1]);
  combine({r0.z, r1.z, r2.z}, columns, relative[2]);
  return relative;
}

/// The slopes of the energy by the columns of the relative Jacobian matrices, per barycentric coordinate.
std::array<VectorValues, 4> slopes_by_coordinate(const PatchElement& element,
                                                 const std::array<VectorValues, 3>& slopes) {
  std::array<VectorValues, 4> by_coordinate;
  const auto& [r0, r1, r2] = element.inverse_ideal;
  combine({r0.x, r0.y, r0.z}, slopes, by_coordinate[1]);
  combine({r1.x, r1.y, r1.z}, slopes, by_coordinate[2]);
  combine({r2.x, r2.y, r2.z}, slopes, by_coordinate[3]);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t p = 0; p < kMatrices; ++p) {
      by_coordinate[0][c][p] = -(by_coordinate[1][c][p] + by_coordinate[2][c][p] + by_coordinate[3][c][p]);
    }
  }
  return by_coordinate;
}

Vec3 value(const VectorValues& v, std::size_t p) { return {v[0][p], v[1][p], v[2][p]}; }

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
    const auto j = relative_jacobians(element, nodes);
    for (std::size_t p = 0; p < kMatrices; ++p) {
      least = std::min(least, dot(cross(value(j[0], p), value(j[1], p)), value(j[2], p)));
    }
  }
  return least;
}

double RelaxationEnergy::add_element(const PatchElement& element, const std::vector<Vec3>& nodes,
                                     std::vector<Vec3>& forces) const {
  const auto j = relative_jacobians(element, nodes);
  std::array<VectorValues, 3> cofactors;
  Values d;
  for (std::size_t p = 0; p < kMatrices; ++p) {
    for (std::size_t k = 0; k < 3; ++k) {
      const VectorValues& a = j[(k + 1) % 3];
      const VectorValues& b = j[(k + 2) % 3];
      cofactors[k][0][p] = a[1][p] * b[2][p] - a[2][p] * b[1][p];
      cofactors[k][1][p] = a[2][p] * b[0][p] - a[0][p] * b[2][p];
      cofactors[k][2][p] = a[0][p] * b[1][p] - a[1][p] * b[0][p];
    }
    d[p] = cofactors[2][0][p] * j[2][0][p] + cofactors[2][1][p] * j[2][1][p] + cofactors[2][2][p] * j[2][2][p];
  }
  if (epsilon == 0 && !(*std::min_element(d.begin(), d.end()) > 0)) return kInfinity;
  Values chi;
  Values log_slope;  // the derivative of chi, divided by it
  Values cube_root;
  for (std::size_t p = 0; p < kMatrices; ++p) std::tie(chi[p], log_slope[p]) = regularized(d[p], epsilon);
  for (std::size_t p = 0; p < kMatrices; ++p) cube_root[p] = elementary::cbrt(chi[p]);
  // The energy is mean^power; the slopes of its parts by the columns of J:
  // d shape = along_j J - 2/3 shape chi'/chi cofactor; d size = (D / chi - size chi'/chi) cofactor.
  Values mean;
  Values along_j;
  Values along_cofactor;
  for (std::size_t p = 0; p < kMatrices; ++p) {
    double norm2 = 0;
    for (const VectorValues& column : j) {
      norm2 += column[0][p] * column[0][p] + column[1][p] * column[1][p] + column[2][p] * column[2][p];
    }
    along_j[p] = 1 / (3 * cube_root[p] * cube_root[p]);
    const double shape = norm2 * along_j[p];
    const double size = (d[p] * d[p] + 1) / (2 * chi[p]);
    mean[p] = 0.5 * (shape + size);
    along_cofactor[p] = 0.5 * (d[p] / chi[p] - (size + 2 * shape / 3) * log_slope[p]);
  }
  const Values outer = powers_of(mean, power - 1);
  double energy = 0;
  for (std::size_t p = 0; p < kMatrices; ++p) energy += outer[p] * mean[p];
  std::array<VectorValues, 3> slopes;  // of the energy by the columns
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t p = 0; p < kMatrices; ++p) {
        slopes[k][c][p] = power * outer[p] * (along_j[p] * j[k][c][p] + along_cofactor[p] * cofactors[k][c][p]);
      }
    }
  }
  const std::array<VectorValues, 4> by_coordinate = slopes_by_coordinate(element, slopes);
  const auto add = [&](std::size_t n, const Vec3& force) {
    forces[element.nodes[n]] = forces[element.nodes[n]] + force;
  };
  for (std::size_t v = 0; v < 4; ++v) add(v, sum_of_products(weights().vertex[v], by_coordinate[v]));
  for (std::size_t e = 0; e < 6; ++e) {
    const auto& [a, b] = kCurvedTetEdges[e];
    add(4 + e,
        sum_of_products(weights().edge[b], by_coordinate[a]) + sum_of_products(weights().edge[a], by_coordinate[b]));
  }
  return energy;
}

}  // namespace tetune
