// SPDX-License-Identifier: Apache-2.0
#include "mesh/tet_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "backend/span.hpp"

namespace tetune {
namespace {

using Coordinates = std::array<double, 4>;
/// The corners of a tetrahedron.
using Part = std::array<Coordinates, 4>;

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
  Part corners() const {
    Part part;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < 4; ++k) part[i][k] = value[k][i];
    }
    return part;
  }
};

/// The point of the edge between `in` and `out` at which coordinate k is 0.
Coordinates crossing(const Coordinates& in, const Coordinates& out, std::size_t k) {
  const double t = in[k] / (in[k] - out[k]);
  Coordinates c{};
  for (std::size_t i = 0; i < 4; ++i) c[i] = in[i] + t * (out[i] - in[i]);
  c[k] = 0;
  return c;
}

/// The part of a tetrahedron that is in another one: a convex polyhedron with three edges at each corner. Corners may
/// coincide, so that none is a special case (Powell, Abel 2015).
class Polyhedron {
 public:
  explicit Polyhedron(const Part& tet) : size_(4) {
    constexpr Neighbors kNeighbors[4] = {{1, 3, 2}, {2, 3, 0}, {0, 3, 1}, {1, 2, 0}};
    for (std::size_t i = 0; i < 4; ++i) corners_[i] = {tet[i], kNeighbors[i]};
  }

  /// Keeps the part at which coordinate k is not negative. Returns false if nothing is left.
  bool clip(std::size_t k) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size_; ++i) kept += is_in(i, k) ? 1 : 0;
    if (kept == size_) return true;
    const std::size_t old_size = size_;
    for (std::size_t i = 0; i < old_size && kept > 0; ++i) {
      for (std::size_t edge = 0; edge < 3 && is_in(i, k); ++edge) {
        const std::size_t out = corners_[i].neighbors[edge];
        if (out >= old_size || is_in(out, k)) continue;
        corners_[size_] = {crossing(corners_[i].at, corners_[out].at, k), {narrow(i), 0, 0}};
        corners_[i].neighbors[edge] = narrow(size_++);
      }
    }
    for (std::size_t i = old_size; i < size_; ++i) close_face(i, old_size);
    remove_corners(old_size, k);
    return size_ > 0;
  }

  /// Calls visit for the tetrahedra between the first corner and the triangles of the faces that do not have it.
  template <class Visit>
  void for_tets(const Visit& visit) {
    unsigned visited[kMaxCorners] = {};
    const auto ignore = [](std::size_t, std::size_t, std::size_t) {};
    for (std::size_t edge = 0; edge < 3; ++edge) walk_face(0, edge, visited, ignore);
    for (std::size_t i = 1; i < size_; ++i) {
      for (std::size_t edge = 0; edge < 3; ++edge) {
        walk_face(i, edge, visited, [&](std::size_t p, std::size_t q, std::size_t r) {
          visit(Part{corners_[0].at, corners_[p].at, corners_[q].at, corners_[r].at});
        });
      }
    }
  }

 private:
  using Neighbors = std::array<std::uint8_t, 3>;
  struct Corner {
    Coordinates at;
    Neighbors neighbors;
  };
  /// A polyhedron with eight faces has at most 12 corners, and a plane crosses at most as many edges.
  static constexpr std::size_t kMaxCorners = 32;

  static std::uint8_t narrow(std::size_t i) { return std::uint8_t(i); }
  bool is_in(std::size_t i, std::size_t k) const { return corners_[i].at[k] >= 0; }
  std::size_t edge_to(std::size_t from, std::size_t to) const {
    const Neighbors& n = corners_[from].neighbors;
    return n[0] == to ? 0 : n[1] == to ? 1 : 2;
  }

  /// Connects a new corner with the next one around the face that it ends.
  void close_face(std::size_t start, std::size_t old_size) {
    std::size_t at = start;
    std::size_t next = corners_[start].neighbors[0];
    do {
      const std::size_t back = edge_to(next, at);
      at = next;
      next = corners_[at].neighbors[(back + 1) % 3];
    } while (at < old_size);
    corners_[start].neighbors[2] = narrow(at);
    corners_[at].neighbors[1] = narrow(start);
  }

  /// Removes the old corners at which coordinate k is negative.
  void remove_corners(std::size_t old_size, std::size_t k) {
    std::uint8_t place[kMaxCorners];
    std::size_t count = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      if (i < old_size && !is_in(i, k)) continue;
      place[i] = narrow(count);
      corners_[count++] = corners_[i];
    }
    size_ = count;
    for (std::size_t i = 0; i < size_; ++i) {
      for (std::uint8_t& n : corners_[i].neighbors) n = place[n];
    }
  }

  /// Calls visit for the triangles of the face that an edge begins, unless it was walked before.
  template <class Visit>
  void walk_face(std::size_t start, std::size_t edge, unsigned* visited, const Visit& visit) const {
    if ((visited[start] >> edge & 1U) != 0) return;
    std::size_t at = start;
    for (std::size_t steps = 0;; ++steps) {
      visited[at] |= 1U << edge;
      const std::size_t next = corners_[at].neighbors[edge];
      if (next == start) break;
      if (steps > 0) visit(start, at, next);
      edge = (edge_to(next, at) + 1) % 3;
      at = next;
    }
  }

  std::array<Corner, kMaxCorners> corners_;
  std::size_t size_;
};

/// The volume of a part, divided by that of `b`.
double part_volume(const Part& x) {
  const auto edge = [&x](std::size_t k) { return Vec3{x[k][1] - x[0][1], x[k][2] - x[0][2], x[k][3] - x[0][3]}; };
  return std::fabs(dot(cross(edge(1), edge(2)), edge(3)));
}

using Products = std::array<Coordinates, 4>;

/// Adds the integrals of products of the coordinates in `b`, which the values at the corners determine.
void add_products(const Part& x, double volume, Products& result) {
  Coordinates sum{};
  for (std::size_t i = 0; i < 4; ++i) sum[i] = x[0][i] + x[1][i] + x[2][i] + x[3][i];
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      const double product =
          sum[i] * sum[k] + x[0][i] * x[0][k] + x[1][i] * x[1][k] + x[2][i] * x[2][k] + x[3][i] * x[3][k];
      result[i][k] += volume / 20 * product;
    }
  }
}

/// The moments by these integrals, as coordinates in `a` are linear in those in `b`: `b_in_a` are those of its corners.
void set_moments(const Products& products, const PointCoordinates& b_in_a, TetOverlap& result) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t j = 0; j < 4; ++j) result.moments[i][j] += b_in_a.value[i][k] * products[k][j];
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
  const PointCoordinates a_in_b(a.points, b);
  if (a_in_b.are_separated()) return {};
  const PointCoordinates b_in_a(b.points, a);
  if (b_in_a.are_separated()) return {};
  Polyhedron common(a_in_b.corners());
  for (std::size_t k = 0; k < 4; ++k) {
    if (!common.clip(k)) return {};
  }
  double part_of_b = 0;
  Products products{};
  const double scale = std::fabs(b.six / a.six);
  common.for_tets([&](const Part& part) {
    const double volume = part_volume(part);
    part_of_b += volume;
    if (with_moments) add_products(part, scale * volume, products);
  });
  TetOverlap result;
  result.part = scale * part_of_b;
  if (result.part < kRounding || part_of_b < kRounding) return {};
  if (with_moments) set_moments(products, b_in_a, result);
  return result;
}

}  // namespace tetune
