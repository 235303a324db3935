// SPDX-License-Identifier: Apache-2.0
#include "mesh/tet_overlap.hpp"

#include <cmath>

#include "backend/span.hpp"

namespace tetune {
namespace {

using Coordinates = std::array<double, 4>;

/// A point by its barycentric coordinates in both tetrahedra.
struct Corner {
  Coordinates a, b;
};
using Part = std::array<Corner, 4>;

/// Clipping by one plane makes at most three tetrahedra of one.
constexpr std::size_t kMaxParts = 81;

struct PartList {
  std::array<Part, kMaxParts> parts;
  std::size_t size = 0;
  void add(const Corner& p, const Corner& q, const Corner& r, const Corner& s) { parts[size++] = {p, q, r, s}; }
};

/// The coordinates of the corners of `x` in the tetrahedron `of`.
std::array<Coordinates, 4> coordinates(const TetPoints& x, const TetPoints& of, double six) {
  const Vec3 e[3] = {of[1] - of[0], of[2] - of[0], of[3] - of[0]};
  const Vec3 gradient[3] = {(1 / six) * cross(e[1], e[2]), (1 / six) * cross(e[2], e[0]),
                            (1 / six) * cross(e[0], e[1])};
  std::array<Coordinates, 4> result{};
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3 d = x[k] - of[0];
    const double c[3] = {dot(gradient[0], d), dot(gradient[1], d), dot(gradient[2], d)};
    result[k] = {1 - (c[0] + c[1] + c[2]), c[0], c[1], c[2]};
  }
  return result;
}

/// Whether all points are beyond one face.
bool is_separated(const std::array<Coordinates, 4>& x) {
  for (std::size_t k = 0; k < 4; ++k) {
    if (x[0][k] <= 0 && x[1][k] <= 0 && x[2][k] <= 0 && x[3][k] <= 0) return true;
  }
  return false;
}

/// The point of the edge between `in` and `out` at which coordinate k of `b` is 0.
Corner crossing(const Corner& in, const Corner& out, std::size_t k) {
  const double t = in.b[k] / (in.b[k] - out.b[k]);
  Corner c{};
  for (std::size_t i = 0; i < 4; ++i) {
    c.a[i] = in.a[i] + t * (out.a[i] - in.a[i]);
    c.b[i] = in.b[i] + t * (out.b[i] - in.b[i]);
  }
  c.b[k] = 0;
  return c;
}

/// Adds the part of a tetrahedron at which coordinate k of `b` is not negative.
void clip(const Part& x, std::size_t k, PartList& result) {
  std::array<const Corner*, 4> c{};
  std::size_t in = 0;
  std::size_t out = 4;
  for (const Corner& corner : x) (corner.b[k] >= 0 ? c[in++] : c[--out]) = &corner;
  const auto cut = [&](std::size_t i, std::size_t o) { return crossing(*c[i], *c[o], k); };
  if (in == 4) {
    result.parts[result.size++] = x;
  } else if (in == 1) {
    result.add(*c[0], cut(0, 1), cut(0, 2), cut(0, 3));
  } else if (in == 2) {
    const Corner p[2] = {cut(0, 2), cut(0, 3)};
    const Corner q[2] = {cut(1, 2), cut(1, 3)};
    result.add(*c[0], p[0], p[1], *c[1]);
    result.add(p[0], p[1], *c[1], q[0]);
    result.add(p[1], *c[1], q[0], q[1]);
  } else if (in == 3) {
    const Corner p[3] = {cut(0, 3), cut(1, 3), cut(2, 3)};
    result.add(*c[0], *c[1], *c[2], p[0]);
    result.add(*c[1], *c[2], p[0], p[1]);
    result.add(*c[2], p[0], p[1], p[2]);
  }
}

/// The volume of a part, divided by that of `a`.
double part_volume(const Part& x) {
  const auto edge = [&x](std::size_t k) {
    return Vec3{x[k].a[1] - x[0].a[1], x[k].a[2] - x[0].a[2], x[k].a[3] - x[0].a[3]};
  };
  return std::fabs(dot(cross(edge(1), edge(2)), edge(3)));
}

using Products = std::array<std::array<double, 4>, 4>;

/// Adds the integrals of products of the coordinates in `a`, of i and k <= i, which the values at the corners
/// determine.
void add_products(const Part& x, double volume, Products& result) {
  Coordinates sum{};
  for (std::size_t i = 0; i < 4; ++i) sum[i] = x[0].a[i] + x[1].a[i] + x[2].a[i] + x[3].a[i];
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k <= i; ++k) {
      double product = sum[i] * sum[k];
      for (const Corner& c : x) product += c.a[i] * c.a[k];
      result[i][k] += volume / 20 * product;
    }
  }
}

/// The moments by these integrals, as coordinates in `b` are linear in those in `a`: `in_b` are those of its corners.
void set_moments(const Products& products, const std::array<Coordinates, 4>& in_b, TetOverlap& result) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k < 4; ++k) {
        result.moments[i][j] += (k <= i ? products[i][k] : products[k][i]) * in_b[k][j];
      }
    }
  }
}

}  // namespace

double six_volume(const TetPoints& x) { return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]); }

TetOverlap overlap(const TetPoints& a, const TetPoints& b, bool with_moments) {
  constexpr double kRounding = 1e-14;
  const double six_a = six_volume(a);
  const double six_b = six_volume(b);
  if (six_a == 0 || six_b == 0) return {};
  const std::array<Coordinates, 4> in_b = coordinates(a, b, six_b);
  if (is_separated(in_b) || is_separated(coordinates(b, a, six_a))) return {};
  PartList parts[2];
  for (std::size_t k = 0; k < 4; ++k) {
    Corner& corner = parts[0].parts[0][k];
    corner = {{}, in_b[k]};
    corner.a[k] = 1;
  }
  parts[0].size = 1;
  for (std::size_t k = 0; k < 4; ++k) {
    PartList& next = parts[(k + 1) % 2];
    next.size = 0;
    const PartList& now = parts[k % 2];
    for (std::size_t i = 0; i < now.size; ++i) clip(now.parts[i], k, next);
  }
  TetOverlap result;
  Products products{};
  for (std::size_t i = 0; i < parts[0].size; ++i) {
    const double volume = part_volume(parts[0].parts[i]);
    result.part += volume;
    if (with_moments) add_products(parts[0].parts[i], volume, products);
  }
  if (result.part < kRounding || result.part * std::fabs(six_a) < kRounding * std::fabs(six_b)) return {};
  if (with_moments) set_moments(products, in_b, result);
  return result;
}

}  // namespace tetune
