// SPDX-License-Identifier: Apache-2.0
#include "mesh/transfer/tet_overlap.hpp"

#include <cmath>

#include "backend/pack.hpp"

namespace tetune {
namespace {

using backend::Pack4;
using Lane = decltype(Pack4{} < Pack4{});

/// A point by its four barycentric coordinates in one of the tetrahedra.
using Corner = Pack4;

bool any(const Lane& lanes) { return (lanes[0] | lanes[1] | lanes[2] | lanes[3]) != 0; }

/// The coordinates of four points in a tetrahedron: pack k has coordinate k of each.
std::array<Pack4, 4> coordinates(const TetPoints& x, const TetFrame& of) {
  const Pack4 d[3] = {Pack4{x[0].x, x[1].x, x[2].x, x[3].x} - of.points[0].x,
                      Pack4{x[0].y, x[1].y, x[2].y, x[3].y} - of.points[0].y,
                      Pack4{x[0].z, x[1].z, x[2].z, x[3].z} - of.points[0].z};
  std::array<Pack4, 4> result;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& g = of.gradient[k];
    result[k + 1] = g.x * d[0] + g.y * d[1] + g.z * d[2];
  }
  result[0] = 1 - (result[1] + result[2] + result[3]);
  return result;
}
/// Whether all points are beyond one face.
bool are_separated(const std::array<Pack4, 4>& c) {
  return !any(c[0] > 0.0) || !any(c[1] > 0.0) || !any(c[2] > 0.0) || !any(c[3] > 0.0);
}

using Part = std::array<Corner, 4>;

/// Clipping by one plane makes at most three tetrahedra of one.
constexpr std::size_t kMaxParts = 81;

struct PartList {
  std::array<Part, kMaxParts> parts;
  std::size_t size = 0;
  void add(const Corner& p, const Corner& q, const Corner& r, const Corner& s) { parts[size++] = {p, q, r, s}; }
};

/// The point of the edge between `in` and `out` at which coordinate k is 0.
Corner crossing(const Corner& in, const Corner& out, std::size_t k) {
  const double t = in[k] / (in[k] - out[k]);
  Corner c = in + t * (out - in);
  c[k] = 0;
  return c;
}

/// Adds the part of a tetrahedron at which coordinate k is not negative.
void clip(const Part& x, std::size_t k, PartList& result) {
  std::array<const Corner*, 4> c{};
  std::size_t in = 0;
  std::size_t out = 4;
  for (const Corner& corner : x) (corner[k] >= 0 ? c[in++] : c[--out]) = &corner;
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

/// The volume of a part, divided by that of the tetrahedron of the coordinates.
double part_volume(const Part& x) {
  const auto edge = [&x](std::size_t k) { return Vec3{x[k][1] - x[0][1], x[k][2] - x[0][2], x[k][3] - x[0][3]}; };
  return std::fabs(dot(cross(edge(1), edge(2)), edge(3)));
}

/// Entry [i] has the integrals of the products of coordinate i with all four.
using Products = std::array<Pack4, 4>;

void add_products(const Part& x, double volume, Products& result) {
  const Pack4 corner[4] = {x[0], x[1], x[2], x[3]};
  const Pack4 sum = (corner[0] + corner[1]) + (corner[2] + corner[3]);
  const double weight = volume / 20;
  for (std::size_t i = 0; i < 4; ++i) {
    Pack4 product = sum[i] * sum;
    for (const Pack4& c : corner) product += c[i] * c;
    result[i] += weight * product;
  }
}

/// Clips `a`, with its coordinates in `b`, by the planes of `b`.
const PartList& clip_all(const std::array<Pack4, 4>& in_b, PartList (&lists)[2]) {
  for (std::size_t i = 0; i < 4; ++i) lists[0].parts[0][i] = Corner{in_b[0][i], in_b[1][i], in_b[2][i], in_b[3][i]};
  lists[0].size = 1;
  std::size_t now = 0;
  for (std::size_t k = 0; k < 4 && lists[now].size > 0; ++k) {
    if (!any(in_b[k] < 0.0)) continue;
    PartList& next = lists[1 - now];
    next.size = 0;
    for (std::size_t i = 0; i < lists[now].size; ++i) clip(lists[now].parts[i], k, next);
    now = 1 - now;
  }
  return lists[now];
}

}  // namespace

double six_volume(const TetPoints& x) { return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]); }

TetFrame::TetFrame(const TetPoints& of) : points(of), six(six_volume(of)) {
  const Vec3 e[3] = {of[1] - of[0], of[2] - of[0], of[3] - of[0]};
  gradient = {(1 / six) * cross(e[1], e[2]), (1 / six) * cross(e[2], e[0]), (1 / six) * cross(e[0], e[1])};
}

TetOverlap overlap(const TetFrame& a, const TetFrame& b, Moments moments) {
  constexpr double kRounding = 1e-14;
  if (a.six == 0 || b.six == 0) return {};
  const std::array<Pack4, 4> in_b = coordinates(a.points, b);
  if (are_separated(in_b)) return {};
  const std::array<Pack4, 4> in_a = coordinates(b.points, a);
  if (are_separated(in_a)) return {};
  PartList lists[2];
  const PartList& parts = clip_all(in_b, lists);
  double sum = 0;
  Products products{};
  for (std::size_t i = 0; i < parts.size; ++i) {
    const double volume = part_volume(parts.parts[i]);
    sum += volume;
    if (moments == Moments::computed) add_products(parts.parts[i], volume, products);
  }
  const double ratio = std::fabs(b.six / a.six);
  TetOverlap result;
  result.part = sum * ratio;
  if (sum < kRounding || result.part < kRounding) return {};
  if (moments == Moments::omitted) return result;
  // Coordinates in `a` are linear in those in `b`: in_a has them at the corners.
  for (std::size_t i = 0; i < 4; ++i) {
    const Pack4 row =
        in_a[i][0] * products[0] + in_a[i][1] * products[1] + in_a[i][2] * products[2] + in_a[i][3] * products[3];
    for (std::size_t j = 0; j < 4; ++j) result.moments[i][j] = ratio * row[j];
  }
  return result;
}

}  // namespace tetune
