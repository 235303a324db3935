// SPDX-License-Identifier: Apache-2.0
#include "curved/relaxation_energy.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "backend/pack.hpp"
#include "math/constants.hpp"

namespace tetune {
namespace {

using Pack = backend::Pack4;

constexpr std::size_t kLanes = 4;
constexpr std::size_t kPacks = 9;  ///< of Jacobian matrices: 35 points, and the straight element in the last lane

/// A 3 x 3 matrix by columns, and one per lane.
using Matrix = std::array<Vec3, 3>;
using MatrixPack = std::array<std::array<Pack, 3>, 3>;

/// The barycentric coordinates 1 to 3 of the points of a lattice with four steps per edge; zero in the last lane.
std::array<std::array<Pack, 3>, kPacks> make_points() {
  std::array<std::array<Pack, 3>, kPacks> points{};
  std::size_t n = 0;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; i + j <= 4; ++j) {
      for (int k = 0; i + j + k <= 4; ++k, ++n) {
        const std::array<int, 3> steps{i, j, k};
        for (std::size_t v = 0; v < 3; ++v) points[n / kLanes][v][n % kLanes] = 0.25 * steps[v];
      }
    }
  }
  return points;
}
const std::array<std::array<Pack, 3>, kPacks> kLattice = make_points();

double component(const Vec3& v, std::size_t c) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }
Pack all(double x) { return Pack{x, x, x, x}; }
double sum(const Pack& x) { return (x[0] + x[1]) + (x[2] + x[3]); }

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c;
  for (std::size_t j = 0; j < 3; ++j) c[j] = b[j].x * a[0] + b[j].y * a[1] + b[j].z * a[2];
  return c;
}

/// A matrix whose rows are given.
Matrix from_rows(const std::array<Vec3, 3>& r) {
  return {Vec3{r[0].x, r[1].x, r[2].x}, Vec3{r[0].y, r[1].y, r[2].y}, Vec3{r[0].z, r[1].z, r[2].z}};
}

/// The Jacobian matrices relative to the ideal shape, which are linear over the element: at vertex 0, the differences
/// of those at the other vertices from it, and that of the straight element.
struct LinearJacobian {
  std::array<Matrix, 4> terms;
  Matrix straight;

  LinearJacobian(const PatchElement& element, const std::vector<Vec3>& nodes) {
    // The derivative by barycentric coordinate k at vertex v: a node's weight is 3 or -1 at vertices, 4 on edges.
    std::array<std::array<Vec3, 4>, 4> by_coordinate;
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t v = 0; v < 4; ++v) {
        const Vec3& x = nodes[element.nodes[k]];
        by_coordinate[k][v] = k == v ? 3.0 * x : 4.0 * nodes[element.nodes[kMiddle[k][v]]] - x;
      }
    }
    const Matrix inverse = from_rows(element.inverse_ideal);
    const auto relative = [&inverse](const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3) {
      return product({x1 - x0, x2 - x0, x3 - x0}, inverse);
    };
    const auto at = [&](std::size_t k) { return nodes[element.nodes[k]]; };
    straight = relative(at(0), at(1), at(2), at(3));
    for (std::size_t v = 0; v < 4; ++v) {
      terms[v] = relative(by_coordinate[0][v], by_coordinate[1][v], by_coordinate[2][v], by_coordinate[3][v]);
      for (std::size_t k = 0; v > 0 && k < 3; ++k) terms[v][k] = terms[v][k] - terms[0][k];
    }
  }

  MatrixPack at(std::size_t pack) const {
    MatrixPack m;
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        m[k][c] = all(component(terms[0][k], c));
        for (std::size_t v = 0; v < 3; ++v) m[k][c] += kLattice[pack][v] * component(terms[v + 1][k], c);
        if (pack + 1 == kPacks) m[k][c][kLanes - 1] = component(straight[k], c);
      }
    }
    return m;
  }

  /// The node on the edge between two vertices.
  static constexpr std::array<std::array<std::size_t, 4>, 4> kMiddle{
      {{0, 4, 6, 7}, {4, 0, 5, 8}, {6, 5, 0, 9}, {7, 8, 9, 0}}};
};

/// The derivatives of the energy with respect to the matrices of LinearJacobian.
struct JacobianGradient {
  std::array<MatrixPack, 4> terms{};
  Matrix straight;

  void add(std::size_t pack, MatrixPack derivatives) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t v = 0; v < 3; ++v) terms[v + 1][k][c] += kLattice[pack][v] * derivatives[k][c];
      }
    }
    if (pack + 1 == kPacks) {
      const auto last = [](const std::array<Pack, 3>& v) {
        return Vec3{v[0][kLanes - 1], v[1][kLanes - 1], v[2][kLanes - 1]};
      };
      straight = {last(derivatives[0]), last(derivatives[1]), last(derivatives[2])};
      for (auto& column : derivatives) {
        for (Pack& x : column) x[kLanes - 1] = 0;
      }
    }
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t c = 0; c < 3; ++c) terms[0][k][c] += derivatives[k][c];
    }
  }

  void add_to_nodes(const PatchElement& element, std::vector<Vec3>& gradient) const {
    const Matrix transposed = element.inverse_ideal;  // whose columns are the rows
    const auto add = [&](std::size_t n, double factor, const Vec3& f) {
      gradient[element.nodes[n]] = gradient[element.nodes[n]] + factor * f;
    };
    std::array<Matrix, 4> at_vertex;
    for (std::size_t v = 0; v < 4; ++v) {
      const auto column = [&](std::size_t k) {
        return Vec3{sum(terms[v][k][0]), sum(terms[v][k][1]), sum(terms[v][k][2])};
      };
      at_vertex[v] = product({column(0), column(1), column(2)}, transposed);
    }
    // The matrices at the other vertices are differences from that at vertex 0.
    for (std::size_t v = 1; v < 4; ++v) {
      for (std::size_t k = 0; k < 3; ++k) at_vertex[0][k] = at_vertex[0][k] - at_vertex[v][k];
    }
    const auto by_coordinates = [](const Matrix& m) {
      return std::array<Vec3, 4>{-1.0 * (m[0] + m[1] + m[2]), m[0], m[1], m[2]};
    };
    const std::array<Vec3, 4> of_straight = by_coordinates(product(straight, transposed));
    for (std::size_t k = 0; k < 4; ++k) add(k, 1, of_straight[k]);
    for (std::size_t v = 0; v < 4; ++v) {
      const std::array<Vec3, 4> f = by_coordinates(at_vertex[v]);
      for (std::size_t k = 0; k < 4; ++k) {
        add(k, k == v ? 3 : -1, f[k]);
        if (k != v) add(LinearJacobian::kMiddle[k][v], 4, f[k]);
      }
    }
  }
};

/// The matrix of the cofactors.
MatrixPack cofactors_of(const MatrixPack& j) {
  MatrixPack c;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& a = j[(k + 1) % 3];
    const auto& b = j[(k + 2) % 3];
    c[k][0] = a[1] * b[2] - a[2] * b[1];
    c[k][1] = a[2] * b[0] - a[0] * b[2];
    c[k][2] = a[0] * b[1] - a[1] * b[0];
  }
  return c;
}

Pack dot(const std::array<Pack, 3>& a, const std::array<Pack, 3>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

bool all_positive(const Pack& x) { return x[0] > 0 && x[1] > 0 && x[2] > 0 && x[3] > 0; }

/// a^(-1/3) of positive numbers, to some roundings: a third of the exponent, and two steps of order four.
Pack inverse_cube_root(const Pack& a) {
  constexpr std::uint64_t kBias = 0x553ef0ff'289dd796;  // four thirds of the bias of exponents, with the mean error
  backend::Bits4 bits;
  std::memcpy(&bits, &a, sizeof bits);
  bits = kBias - bits / 3;
  Pack root;
  std::memcpy(&root, &bits, sizeof root);
  for (int i = 0; i < 2; ++i) {
    const Pack rest = 1 - a * root * root * root;
    root *= 1 + rest * (1.0 / 3 + rest * (2.0 / 9 + rest * (14.0 / 81)));
  }
  return root;
}

Pack power_of(Pack x, int n) {
  Pack result = all(1);
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) result *= x;
    x *= x;
  }
  return result;
}

/// chi, and its derivative divided by it.
struct Regularized {
  Pack chi, log_derivative;
};
Regularized regularized(const Pack& d, double epsilon) {
  if (epsilon == 0) return {d, 1 / d};
  Regularized r;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const double root = std::sqrt(epsilon * epsilon + d[l] * d[l]);
    r.chi[l] = d[l] > 0 ? 0.5 * (d[l] + root) : 0.5 * epsilon * epsilon / (root - d[l]);
    r.log_derivative[l] = 1 / root;
  }
  return r;
}

/// Replaces Jacobian matrices with determinants d by the derivatives of the energy mean^power. Returns the energy. The
/// derivatives of its parts by J: d shape = 2/3 chi^(-2/3) J - 2/3 shape chi'/chi cofactors, and
/// d size = (D / chi - size chi'/chi) cofactors.
Pack differentiate(MatrixPack& j, const MatrixPack& cofactors, const Pack& d, double epsilon, int power) {
  const auto [chi, log_derivative] = regularized(d, epsilon);
  const Pack inverse_chi = epsilon == 0 ? log_derivative : 1 / chi;
  const Pack root = inverse_cube_root(chi);
  Pack along_j = root * root * (1.0 / 3);
  const Pack shape = (dot(j[0], j[0]) + dot(j[1], j[1]) + dot(j[2], j[2])) * along_j;
  const Pack size = (d * d + 1) * 0.5 * inverse_chi;
  const Pack mean = 0.5 * (shape + size);
  const Pack outer = power_of(mean, power - 1);
  const Pack factor = power * outer;
  const Pack along_cofactor = factor * (0.5 * (d * inverse_chi - (size + shape * (2.0 / 3)) * log_derivative));
  along_j *= factor;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t c = 0; c < 3; ++c) j[k][c] = along_j * j[k][c] + along_cofactor * cofactors[k][c];
  }
  return outer * mean;
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

const std::vector<Vec3>& RelaxationEnergy::nodes_at(const std::vector<double>& x) {
  for (std::size_t i = 0; i < unknowns_.size(); ++i) nodes_[unknowns_[i]] = {x[3 * i], x[3 * i + 1], x[3 * i + 2]};
  return nodes_;
}

double RelaxationEnergy::operator()(const std::vector<double>& x, std::vector<double>& gradient) {
  nodes_at(x);
  node_gradient_.assign(nodes_.size(), Vec3{0, 0, 0});
  double energy = 0;
  for (const PatchElement& element : elements_) {
    energy += add_element(element);
    if (!(energy < kInfinity)) return kInfinity;
  }
  for (std::size_t i = 0; i < unknowns_.size(); ++i) {
    const Vec3& g = node_gradient_[unknowns_[i]];
    gradient[3 * i] = g.x;
    gradient[3 * i + 1] = g.y;
    gradient[3 * i + 2] = g.z;
  }
  return energy;
}

double RelaxationEnergy::smallest_determinant(const std::vector<double>& x) {
  nodes_at(x);
  double least = kInfinity;
  for (const PatchElement& element : elements_) {
    const LinearJacobian jacobian(element, nodes_);
    for (std::size_t p = 0; p < kPacks; ++p) {
      const MatrixPack j = jacobian.at(p);
      const Pack d = dot(cofactors_of(j)[2], j[2]);
      for (std::size_t l = 0; l < kLanes; ++l) least = std::min(least, d[l]);
    }
  }
  return least;
}

double RelaxationEnergy::add_element(const PatchElement& element) {
  const LinearJacobian jacobian(element, nodes_);
  JacobianGradient gradient;
  Pack energy{};
  for (std::size_t p = 0; p < kPacks; ++p) {
    MatrixPack j = jacobian.at(p);
    const MatrixPack cofactors = cofactors_of(j);
    const Pack d = dot(cofactors[2], j[2]);
    if (epsilon == 0 && !all_positive(d)) return kInfinity;
    energy += differentiate(j, cofactors, d, epsilon, power);
    gradient.add(p, j);
  }
  gradient.add_to_nodes(element, node_gradient_);
  return sum(energy);
}

}  // namespace tetune
