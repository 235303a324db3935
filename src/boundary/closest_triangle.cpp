// SPDX-License-Identifier: Apache-2.0
#include "boundary/closest_triangle.hpp"

#include <algorithm>
#include <limits>

namespace tetune {
namespace {

constexpr std::size_t kLeaf = 4;

double clamp01(double t) { return t < 0 ? 0 : t > 1 ? 1 : t; }

using Hit = ClosestTriangle::Hit;

Hit on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length2 = dot(ab, ab);
  const Vec3 q = a + (length2 > 0 ? clamp01(dot(p - a, ab) / length2) : 0) * ab;
  return {q, dot(p - q, p - q)};
}

/// Inside the prism over the triangle the plane is nearest, elsewhere an edge is.
Hit on_triangle(const Vec3& p, const TrianglePoints& t) {
  const Vec3 e1 = t[1] - t[0];
  const Vec3 e2 = t[2] - t[0];
  const Vec3 n = cross(e1, e2);
  const double n2 = dot(n, n);
  // A normal that rounding made says nothing.
  bool inside = n2 > 1e-28 * dot(e1, e1) * dot(e2, e2);
  for (std::size_t k = 0; k < 3 && inside; ++k) {
    inside = dot(cross(t[(k + 1) % 3] - t[k], p - t[k]), n) >= 0;
  }
  if (inside) {
    const double height = dot(p - t[0], n);
    return {p - (height / n2) * n, height * height / n2};
  }
  Hit best = on_segment(p, t[0], t[1]);
  for (const Hit& hit : {on_segment(p, t[1], t[2]), on_segment(p, t[2], t[0])}) {
    if (hit.distance2 < best.distance2) best = hit;
  }
  return best;
}

double axis(const Vec3& v, int k) { return k == 0 ? v.x : k == 1 ? v.y : v.z; }

}  // namespace

ClosestTriangle::ClosestTriangle(std::vector<TrianglePoints> triangles) : triangles_(std::move(triangles)) {
  nodes_.reserve(2 * (triangles_.size() / kLeaf + 1));
  if (!triangles_.empty()) build(0, triangles_.size());
}

int ClosestTriangle::build(std::size_t begin, std::size_t end) {
  Node node;
  node.begin = begin;
  node.end = end;
  node.low = node.high = triangles_[begin][0];
  for (std::size_t i = begin; i < end; ++i) {
    for (const Vec3& p : triangles_[i]) {
      node.low = {std::min(node.low.x, p.x), std::min(node.low.y, p.y), std::min(node.low.z, p.z)};
      node.high = {std::max(node.high.x, p.x), std::max(node.high.y, p.y), std::max(node.high.z, p.z)};
    }
  }
  const auto id = static_cast<int>(nodes_.size());
  nodes_.push_back(node);
  if (end - begin <= kLeaf) return id;
  const Vec3 extent = node.high - node.low;
  const int k = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [this](std::size_t i) { return triangles_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [k](const TrianglePoints& a, const TrianglePoints& b) {
    return axis(a[0], k) + axis(a[1], k) + axis(a[2], k) < axis(b[0], k) + axis(b[1], k) + axis(b[2], k);
  });
  const int left = build(begin, middle);
  const int right = build(middle, end);
  nodes_[static_cast<std::size_t>(id)].left = left;
  nodes_[static_cast<std::size_t>(id)].right = right;
  return id;
}

ClosestTriangle::Hit ClosestTriangle::closest(const Vec3& p, double enough) const {
  Hit best{p, std::numeric_limits<double>::infinity()};
  if (nodes_.empty()) return best;
  const auto box_distance2 = [&p](const Node& n) {
    const double x = std::max({n.low.x - p.x, p.x - n.high.x, 0.0});
    const double y = std::max({n.low.y - p.y, p.y - n.high.y, 0.0});
    const double z = std::max({n.low.z - p.z, p.z - n.high.z, 0.0});
    return x * x + y * y + z * z;
  };
  // Halving leaves no tree deeper than the bits of a size.
  struct Open {
    int node;
    double distance2;
  };
  std::array<Open, 8 * sizeof(std::size_t)> stack;
  std::size_t open = 0;
  stack[open++] = {0, box_distance2(nodes_[0])};
  while (open > 0 && best.distance2 > enough) {
    const Open at = stack[--open];
    if (at.distance2 >= best.distance2) continue;
    const Node& node = nodes_[static_cast<std::size_t>(at.node)];
    if (node.left < 0) {
      for (std::size_t i = node.begin; i < node.end; ++i) {
        const Hit hit = on_triangle(p, triangles_[i]);
        if (hit.distance2 < best.distance2) best = hit;
      }
      continue;
    }
    // The nearer child on top.
    Open near{node.left, box_distance2(nodes_[static_cast<std::size_t>(node.left)])};
    Open far{node.right, box_distance2(nodes_[static_cast<std::size_t>(node.right)])};
    if (far.distance2 < near.distance2) std::swap(near, far);
    stack[open++] = far;
    stack[open++] = near;
  }
  return best;
}

}  // namespace tetune
