// SPDX-License-Identifier: Apache-2.0
#include "curved/vertex_normal.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetune {
namespace {

constexpr std::size_t kUnknowns = 5;
using Row = std::array<double, kUnknowns>;

/// A pivot below this part of its diagonal entry counts as zero.
constexpr double kMinPivot = 1e-6;

/// Solves a symmetric positive definite system, given by its lower triangle, by Cholesky's method. `x`: the right-hand
/// side before, the solution after. Returns false where the matrix is singular.
bool solve(std::array<Row, kUnknowns> matrix, Row& x) {
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    const double diagonal = matrix[i][i];
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = matrix[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= matrix[i][k] * matrix[j][k];
      if (j < i) {
        matrix[i][j] = sum / matrix[j][j];
      } else if (!(sum > kMinPivot * diagonal)) {
        return false;
      } else {
        matrix[i][i] = std::sqrt(sum);
      }
    }
  }
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= matrix[i][k] * x[k];
    x[i] /= matrix[i][i];
  }
  for (std::size_t i = kUnknowns; i-- > 0;) {
    for (std::size_t k = i + 1; k < kUnknowns; ++k) x[i] -= matrix[k][i] * x[k];
    x[i] /= matrix[i][i];
  }
  return true;
}

}  // namespace

Vec3 fit_normal(const std::vector<Vec3>& around, const Vec3& rough) {
  const Vec3 axis = std::fabs(rough.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 across = cross(rough, axis);
  const Vec3 u = (1 / norm(across)) * across;
  const Vec3 v = cross(rough, u);
  double size = 0;
  for (const Vec3& d : around) size = std::max(size, norm(d));
  std::array<Row, kUnknowns> matrix{};
  Row right{};
  for (const Vec3& d : around) {
    const double x = dot(d, u) / size;
    const double y = dot(d, v) / size;
    const double z = dot(d, rough) / size;
    const double weight = 1 / (x * x + y * y + z * z);
    const Row terms{x, y, x * x, x * y, y * y};
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      for (std::size_t j = 0; j <= i; ++j) matrix[i][j] += weight * terms[i] * terms[j];
      right[i] += weight * terms[i] * z;
    }
  }
  if (!(size > 0) || !solve(matrix, right)) return rough;
  const Vec3 normal = rough - right[0] * u - right[1] * v;
  return (1 / norm(normal)) * normal;
}

}  // namespace tetune
