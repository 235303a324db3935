// SPDX-License-Identifier: Apache-2.0
#include "curved/jacobian.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>

#include "math/constants.hpp"

namespace tetune {
namespace {

constexpr double kRoundoff = std::numeric_limits<double>::epsilon() / 2;

/// A term by the three vertices of its barycentric monomial, in ascending order.
using Triple = std::array<std::size_t, 3>;

constexpr std::array<Triple, kJacobianTerms> make_triples() {
  std::array<Triple, kJacobianTerms> triples{};
  std::size_t n = 0;
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = a; b < 4; ++b) {
      for (std::size_t c = b; c < 4; ++c) triples[n++] = {a, b, c};
    }
  }
  return triples;
}
constexpr std::array<Triple, kJacobianTerms> kTriples = make_triples();

constexpr std::array<std::size_t, 64> make_terms() {
  std::array<std::size_t, 64> terms{};
  for (std::size_t n = 0; n < kJacobianTerms; ++n) {
    const auto& [a, b, c] = kTriples[n];
    for (const Triple& t : {Triple{a, b, c}, {a, c, b}, {b, a, c}, {b, c, a}, {c, a, b}, {c, b, a}}) {
      terms[16 * t[0] + 4 * t[1] + t[2]] = n;
    }
  }
  return terms;
}
/// The term of three vertices in any order.
constexpr std::array<std::size_t, 64> kTerms = make_terms();

/// The multinomial coefficient of a term: the number of different orders of its vertices.
constexpr double multinomial(const Triple& t) {
  if (t[0] == t[2]) return 1;
  return t[0] == t[1] || t[1] == t[2] ? 3 : 6;
}

/// The corners of a part: each is the midpoint of two vertices of the whole, or one of them, listed twice.
using Part = std::array<std::array<std::size_t, 2>, 4>;
/// One part at each vertex, and four around the diagonal of the octahedron between them.
constexpr std::array<Part, 8> kParts{{{{{0, 0}, {0, 1}, {0, 2}, {0, 3}}},
                                      {{{0, 1}, {1, 1}, {1, 2}, {1, 3}}},
                                      {{{0, 2}, {1, 2}, {2, 2}, {2, 3}}},
                                      {{{0, 3}, {1, 3}, {2, 3}, {3, 3}}},
                                      {{{0, 1}, {0, 2}, {0, 3}, {1, 3}}},
                                      {{{0, 1}, {0, 2}, {1, 2}, {1, 3}}},
                                      {{{0, 2}, {0, 3}, {1, 3}, {2, 3}}},
                                      {{{0, 2}, {1, 2}, {1, 3}, {2, 3}}}}};

/// A coefficient of a part is the blossom of the whole at three of its corners: the mean of eight coefficients.
using PartTable = std::array<std::array<std::array<std::size_t, 8>, kJacobianTerms>, 8>;
constexpr PartTable make_part_table() {
  PartTable table{};
  for (std::size_t p = 0; p < 8; ++p) {
    for (std::size_t n = 0; n < kJacobianTerms; ++n) {
      for (std::size_t k = 0; k < 8; ++k) {
        const Triple& t = kTriples[n];
        table[p][n][k] = kTerms[16 * kParts[p][t[0]][k / 4] + 4 * kParts[p][t[1]][k / 2 % 2] + kParts[p][t[2]][k % 2]];
      }
    }
  }
  return table;
}
constexpr PartTable kPartTable = make_part_table();

double det(const Vec3& a, const Vec3& b, const Vec3& c) { return dot(cross(a, b), c); }

struct LocalNodes {
  TenNodes nodes{};
  double scale = 1;
};

/// The nodes relative to the first vertex, scaled so that the largest coordinate is about 1.
LocalNodes localize(const TenNodes& nodes) {
  LocalNodes result;
  TenNodes& local = result.nodes;
  double largest = 0;
  for (std::size_t i = 0; i < 10; ++i) {
    local[i] = nodes[i] - nodes[0];
    largest = std::max({largest, std::fabs(local[i].x), std::fabs(local[i].y), std::fabs(local[i].z)});
  }
  if (largest > 0) result.scale = std::ldexp(1.0, std::clamp(-std::ilogb(largest), -1020, 1020));
  for (Vec3& x : local) x = result.scale * x;
  return result;
}

Vec3 larger(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, std::fabs(b.x)), std::max(a.y, std::fabs(b.y)), std::max(a.z, std::fabs(b.z))};
}

/// A bound on the rounding errors of a determinant whose vectors have components of at most `largest`, off by at most
/// `off`, computed by dot(cross()): six products of three components, each with the error of its factors and of at most
/// six operations. Twice what the first order gives.
double determinant_error(const Vec3& largest, const Vec3& off) {
  const auto& [x, y, z] = largest;
  return 12 * (off.x * y * z + x * off.y * z + x * y * off.z + 6 * kRoundoff * x * y * z);
}

}  // namespace

double JacobianPolynomial::corner(std::size_t vertex) const { return coefficients[kTerms[21 * vertex]]; }
double JacobianPolynomial::smallest_coefficient() const {
  return *std::min_element(coefficients.begin(), coefficients.end());
}
double JacobianPolynomial::largest_coefficient() const {
  return *std::max_element(coefficients.begin(), coefficients.end());
}

ScaledJacobian jacobian_of(const TenNodes& nodes) {
  const auto [x, scale] = localize(nodes);
  // Twice the Bezier control points of the element: 2 x_i at a vertex, 4 m_ij - x_i - x_j on an edge.
  std::array<std::array<Vec3, 4>, 4> control{};
  for (std::size_t i = 0; i < 4; ++i) control[i][i] = 2.0 * x[i];
  for (std::size_t e = 0; e < 6; ++e) {
    const auto& [i, j] = kCurvedTetEdges[e];
    control[i][j] = control[j][i] = (4.0 * x[4 + e] - x[i]) - x[j];
  }
  // The derivative along edge 0k of the element is linear: its value at vertex j is side[k - 1][j].
  std::array<std::array<Vec3, 4>, 3> side{};
  Vec3 largest_node{0, 0, 0};
  Vec3 largest_side{0, 0, 0};
  for (const Vec3& node : x) largest_node = larger(largest_node, node);
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t j = 0; j < 4; ++j) {
      side[k][j] = control[k + 1][j] - control[0][j];
      largest_side = larger(largest_side, side[k][j]);
    }
  }
  ScaledJacobian result;
  result.scale = scale;
  JacobianCoefficients& sums = result.polynomial.coefficients;
  for (std::size_t i = 0; i < 64; ++i) {
    sums[kTerms[i]] += det(side[0][i / 16], side[1][i / 4 % 4], side[2][i % 4]);
  }
  for (std::size_t n = 0; n < kJacobianTerms; ++n) sums[n] /= multinomial(kTriples[n]);
  // A side is a sum of terms of at most 11 times the largest node in all, each after at most five roundings.
  const Vec3 off = 64 * kRoundoff * largest_node;
  const auto& [sx, sy, sz] = largest_side;
  // The mean of at most six determinants: seven more roundings of at most six products.
  result.polynomial.error = determinant_error(largest_side, off) + 48 * kRoundoff * sx * sy * sz;
  result.straight = det(x[1], x[2], x[3]);
  return result;
}

double signed_volume(const TenNodes& nodes) {
  const ScaledJacobian jacobian = jacobian_of(nodes);
  const JacobianCoefficients& terms = jacobian.polynomial.coefficients;
  // The mean over the element is that of the coefficients.
  const double mean = std::accumulate(terms.begin(), terms.end(), 0.0) / double(kJacobianTerms);
  return mean / 6 / jacobian.scale / jacobian.scale / jacobian.scale;
}

std::array<JacobianPolynomial, 8> subdivide(const JacobianPolynomial& polynomial) {
  std::array<JacobianPolynomial, 8> parts{};
  const double largest =
      std::max(std::fabs(polynomial.smallest_coefficient()), std::fabs(polynomial.largest_coefficient()));
  for (std::size_t p = 0; p < 8; ++p) {
    for (std::size_t n = 0; n < kJacobianTerms; ++n) {
      double sum = 0;
      for (const std::size_t term : kPartTable[p][n]) sum += polynomial.coefficients[term];
      parts[p].coefficients[n] = sum / 8;
    }
    parts[p].error = polynomial.error + 8 * kRoundoff * largest;
  }
  return parts;
}

double evaluate(const JacobianPolynomial& polynomial, const std::array<double, 4>& at) {
  double value = 0;
  for (std::size_t n = 0; n < kJacobianTerms; ++n) {
    const Triple& t = kTriples[n];
    value += multinomial(t) * polynomial.coefficients[n] * (at[t[0]] * at[t[1]] * at[t[2]]);
  }
  return value;
}

MinimumBounds bound_minimum(const JacobianPolynomial& polynomial, double tolerance) {
  constexpr int kMaxSubdivisions = 400;
  double upper = kInfinity;
  struct Entry {
    double lower;
    JacobianPolynomial part;
    bool operator<(const Entry& other) const { return lower > other.lower; }
  };
  std::priority_queue<Entry> parts;
  const auto add = [&](const JacobianPolynomial& part) {
    // Values at corners bound the minimum from above, coefficients from below.
    for (std::size_t v = 0; v < 4; ++v) upper = std::min(upper, part.corner(v) + part.error);
    parts.push({part.smallest_coefficient() - part.error, part});
  };
  add(polynomial);
  for (int i = 0; i < kMaxSubdivisions; ++i) {
    const double lower = parts.top().lower;
    const bool is_decided = lower > 0 || upper < 0;
    if (is_decided && upper - lower <= tolerance + 4 * parts.top().part.error) break;
    const JacobianPolynomial part = parts.top().part;
    parts.pop();
    for (const JacobianPolynomial& child : subdivide(part)) add(child);
  }
  return {parts.top().lower, upper};
}

CurvedTet measure_nodes(const TenNodes& nodes) {
  // The accuracy of the bounds, relative to the determinant of the straight element.
  constexpr double kAccuracy = 1e-3;
  CurvedTet result;
  const ScaledJacobian jacobian = jacobian_of(nodes);
  JacobianPolynomial negative = jacobian.polynomial;
  for (double& c : negative.coefficients) c = -c;
  const double straight = std::fabs(jacobian.straight);
  const MinimumBounds low = bound_minimum(jacobian.polynomial, kAccuracy * straight);
  const MinimumBounds high = bound_minimum(negative, kAccuracy * straight);
  result.validity = low.lower > 0   ? CurvedValidity::valid
                    : low.upper < 0 ? CurvedValidity::inverted
                                    : CurvedValidity::undecided;
  if (straight > 0) {
    result.min_lower = low.lower / straight;
    result.min_upper = low.upper / straight;
    result.max_lower = -high.upper / straight;
    result.max_upper = -high.lower / straight;
  } else {
    result.min_lower = result.min_upper = -kInfinity;
    result.max_lower = result.max_upper = kInfinity;
  }
  double min_corner = kInfinity;
  double max_corner = -kInfinity;
  double min_point = kInfinity;
  double max_point = -kInfinity;
  for (std::size_t v = 0; v < 4; ++v) {
    min_corner = std::min(min_corner, jacobian.polynomial.corner(v));
    max_corner = std::max(max_corner, jacobian.polynomial.corner(v));
    // The points of the integration rule of degree 2.
    constexpr double kFar = 0.1381966011250105;
    std::array<double, 4> at{kFar, kFar, kFar, kFar};
    at[v] = 1 - 3 * kFar;
    const double value = evaluate(jacobian.polynomial, at);
    min_point = std::min(min_point, value);
    max_point = std::max(max_point, value);
  }
  result.corner_ratio = min_corner > 0 ? max_corner / min_corner : kInfinity;
  result.integration_ratio = max_point > 0 ? min_point / max_point : -kInfinity;
  for (std::size_t e = 0; e < 6; ++e) {
    const Vec3& p = nodes[kCurvedTetEdges[e][0]];
    const Vec3& q = nodes[kCurvedTetEdges[e][1]];
    result.middle_offset = std::max(result.middle_offset, norm(nodes[4 + e] - 0.5 * (p + q)) / norm(q - p));
  }
  return result;
}

}  // namespace tetune
