// SPDX-License-Identifier: Apache-2.0
#include "math/closest_triangle.hpp"
#include "math/constants.hpp"

#include <algorithm>

namespace tetune {
namespace {

using Hit = ClosestTriangle::Hit;

constexpr Size kMaxLeafSize = 4;

Hit closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length2 = dot(ab, ab);
  const Vec3 q = a + (length2 > 0 ? std::clamp(dot(p - a, ab) / length2, 0.0, 1.0) : 0) * ab;
  return {q, dot(p - q, p - q)};
}

/// Within the prism over the triangle the closest point is the projection on its plane, elsewhere it is on an edge.
Hit closest_on_triangle(const Vec3& p, const TrianglePoints& t) {
  const Vec3 e1 = t[1] - t[0];
  const Vec3 e2 = t[2] - t[0];
  const Vec3 n = cross(e1, e2);
  const double n2 = dot(n, n);
  bool inside = n2 > kDegenerateSine2 * dot(e1, e1) * dot(e2, e2);
  for (std::size_t k = 0; k < 3 && inside; ++k) {
    inside = dot(cross(t[(k + 1) % 3] - t[k], p - t[k]), n) >= 0;
  }
  if (inside) {
    const double height = dot(p - t[0], n);
    return {p - (height / n2) * n, height * height / n2};
  }
  Hit best = closest_on_segment(p, t[0], t[1]);
  for (const Hit& hit : {closest_on_segment(p, t[1], t[2]), closest_on_segment(p, t[2], t[0])}) {
    if (hit.distance2 < best.distance2) best = hit;
  }
  return best;
}

}  // namespace

/// A triangle while the hierarchy is built: its box, and the sum of its vertices, by which it is placed.
struct ClosestTriangle::Item {
  Item(const TrianglePoints& t, Size at) : box{t[0], t[0]}, sum(t[0] + t[1] + t[2]), position(at) {
    box.include(t[1]);
    box.include(t[2]);
  }

  Box box;
  Vec3 sum;
  Size position;  ///< in the list
};

double distance2(const Vec3& p, const TrianglePoints& t) { return closest_on_triangle(p, t).distance2; }

ClosestTriangle::ClosestTriangle(const std::vector<TrianglePoints>& triangles) {
  const Size count = std::ssize(triangles);
  nodes_.reserve(to_size_t(2 * (count / kMaxLeafSize + 1)));
  std::vector<Item> items;
  items.reserve(triangles.size());
  for (Size i = 0; i < count; ++i) items.emplace_back(span_of(triangles)[i], i);
  if (count > 0) build(items, 0, count);
  triangles_.reserve(triangles.size());
  order_.reserve(triangles.size());
  for (const Item& item : items) {
    triangles_.push_back(span_of(triangles)[item.position]);
    order_.push_back(item.position);
  }
}

Size ClosestTriangle::build(std::vector<Item>& items, Size begin, Size end) {
  const auto first = items.begin() + begin;
  const auto last = items.begin() + end;
  Node node{first->box};
  node.begin = begin;
  node.end = end;
  for (auto item = first; item != last; ++item) node.box.include(item->box);
  const Size id = std::ssize(nodes_);
  nodes_.push_back(node);
  if (end - begin <= kMaxLeafSize) return id;
  const Vec3 extent = node.box.high - node.box.low;
  const auto axis = extent.x >= extent.y && extent.x >= extent.z ? &Vec3::x
                    : extent.y >= extent.z                       ? &Vec3::y
                                                                 : &Vec3::z;
  const Size middle = begin + (end - begin) / 2;
  std::nth_element(first, items.begin() + middle, last,
                   [axis](const Item& a, const Item& b) { return a.sum.*axis < b.sum.*axis; });
  const Size left = build(items, begin, middle);
  const Size right = build(items, middle, end);
  Node& built = span_of(nodes_)[id];
  built.left = left;
  built.right = right;
  return id;
}

ClosestTriangle::Hit ClosestTriangle::closest(const Vec3& p, double sufficient) const {
  Hit best{p, kInfinity};
  if (nodes_.empty()) return best;
  const auto nodes = span_of(nodes_);
  const auto triangles = span_of(triangles_);
  struct Entry {
    Size node;
    double distance2;
  };
  // Each split halves the range: the tree is at most as deep as a size has bits.
  std::array<Entry, 8 * sizeof(Size)> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, nodes[0].box.distance2(p)};
  while (depth > 0 && best.distance2 > sufficient) {
    const Entry entry = stack[--depth];
    if (entry.distance2 >= best.distance2) continue;
    const Node& node = nodes[entry.node];
    if (node.left < 0) {
      for (Size i = node.begin; i < node.end; ++i) {
        Hit hit = closest_on_triangle(p, triangles[i]);
        if (!(hit.distance2 < best.distance2)) continue;
        hit.triangle = span_of(order_)[i];
        best = hit;
      }
      continue;
    }
    // The closer child is visited first.
    Entry closer{node.left, nodes[node.left].box.distance2(p)};
    Entry farther{node.right, nodes[node.right].box.distance2(p)};
    if (farther.distance2 < closer.distance2) std::swap(closer, farther);
    stack[depth++] = farther;
    stack[depth++] = closer;
  }
  if (best.triangle < 0) best = {triangles[0][0], kInfinity, order_[0]};
  return best;
}

}  // namespace tetune
