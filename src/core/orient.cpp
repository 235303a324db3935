// SPDX-License-Identifier: Apache-2.0
#include "core/orient.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetune {
namespace {

/// A sum of doubles that is exact: components do not overlap and grow in magnitude.
class Expansion {
 public:
  /// Adds a double (Shewchuk 1997, GROW-EXPANSION).
  void add(double value) {
    double carry = value;
    std::size_t kept = 0;
    for (const double component : components_) {
      const double sum = carry + component;
      const double rounded_off = sum - carry;
      const double error = (carry - (sum - rounded_off)) + (component - rounded_off);
      if (error != 0) components_[kept++] = error;
      carry = sum;
    }
    components_.resize(kept);
    if (carry != 0) components_.push_back(carry);
  }

  /// Adds sign * a * b * c.
  void add_product(double sign, double a, double b, double c) {
    const double ab = a * b;
    const double ab_error = std::fma(a, b, -ab);
    for (const double part : {ab, ab_error}) {
      const double product = part * c;
      add(sign * product);
      add(sign * std::fma(part, c, -product));
    }
  }

  int sign() const { return components_.empty() ? 0 : components_.back() > 0 ? 1 : -1; }

 private:
  std::vector<double> components_;
};

}  // namespace

int orient_sign(const Point3& p0, const Point3& p1, const Point3& p2, const Point3& p3) {
  const Point3* points[4] = {&p0, &p1, &p2, &p3};
  double largest = 0;
  for (const Point3* p : points) {
    for (const double x : *p) largest = std::max(largest, std::fabs(x));
  }
  if (largest == 0) return 0;
  // A power of two brings products of three into range and changes nothing else.
  const int exponent = -std::ilogb(largest);
  double x[4][3];
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) x[i][k] = std::ldexp((*points[i])[static_cast<std::size_t>(k)], exponent);
  }
  // det(p1-p0, p2-p0, p3-p0) is the alternating sum of the determinants of three points each.
  static constexpr int kTriples[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  Expansion sum;
  for (int i = 0; i < 4; ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    const double* a = x[kTriples[i][0]];
    const double* b = x[kTriples[i][1]];
    const double* c = x[kTriples[i][2]];
    for (int k = 0; k < 3; ++k) {
      sum.add_product(sign, a[k], b[(k + 1) % 3], c[(k + 2) % 3]);
      sum.add_product(-sign, a[k], b[(k + 2) % 3], c[(k + 1) % 3]);
    }
  }
  return sum.sign();
}

}  // namespace tetune
