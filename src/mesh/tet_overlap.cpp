// SPDX-License-Identifier: Apache-2.0
#include "mesh/tet_overlap.hpp"

#include <algorithm>
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

/// The coordinates of four points in a tetrahedron: entry [k][i] is coordinate k of point i. Four points at a time take
/// vector instructions.
struct PointCoordinates {
  std::array<Coordinates, 4> value;

  PointCoordinates(const TetPoints& x, const TetFrame& of) {
    double d[3][4];
    for (std::size_t i = 0; i < 4; ++i) {
      d[0][i] = x[i].x - of.points[0].x;
      d[1][i] = x[i].y - of.points[0].y;
      d[2][i] = x[i].z - of.points[0].z;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& g = of.gradient[k];
      for (std::size_t i = 0; i < 4; ++i) value[k + 1][i] = g.x * d[0][i] + g.y * d[1][i] + g.z * d[2][i];
    }
    for (std::size_t i = 0; i < 4; ++i) value[0][i] = 1 - (value[1][i] + value[2][i] + value[3][i]);
  }
  /// Whether all points are beyond one face.
  bool are_separated() const {
    return std::any_of(value.begin(), value.end(),
                       [](const Coordinates& c) { return std::max(std::max(c[0], c[1]), std::max(c[2], c[3])) <= 0; });
  }
};

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
void set_moments(const Products& products, const PointCoordinates& in_b, TetOverlap& result) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k < 4; ++k) {
        result.moments[i][j] += (k <= i ? products[i][k] : products[k][i]) * in_b.value[j][k];
      }
    }
  }
}

}  // namespace

double six_volume(const TetPoints& x) { return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]); }

TetFrame::TetFrame(const TetPoints& of) : points(of), six(six_volume(of)) {
  const Vec3 e[3] = {of[1] - of[0], of[2] - of[0], of[3] - of[0]};
  gradient = {(1 / six) * cross(e[1], e[2]), (1 / six) * cross(e[2], e[0]), (1 / six) * cross(e[0], e[1])};
}

TetOverlap overlap(const TetFrame& a, const TetFrame& b, bool with_moments) {
  constexpr double kRounding = 1e-14;
  if (a.six == 0 || b.six == 0) return {};
  const PointCoordinates in_b(a.points, b);
  if (in_b.are_separated() || PointCoordinates(b.points, a).are_separated()) return {};
  PartList parts[2];
  for (std::size_t i = 0; i < 4; ++i) {
    Corner& corner = parts[0].parts[0][i];
    corner = {};
    for (std::size_t k = 0; k < 4; ++k) corner.b[k] = in_b.value[k][i];
    corner.a[i] = 1;
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
  if (result.part < kRounding || result.part * std::fabs(a.six) < kRounding * std::fabs(b.six)) return {};
  if (with_moments) set_moments(products, in_b, result);
  return result;
}

}  // namespace tetune
