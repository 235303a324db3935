// SPDX-License-Identifier: Apache-2.0
#include "second_order.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "tetune/error.hpp"

namespace tetune::plugin {
namespace {

/// Nodes this far from the middle, as a part of the edge, are there but for rounding.
constexpr double kStraight = 1e-4;

std::array<Index, 2> sorted(Index a, Index b) { return a < b ? std::array{a, b} : std::array{b, a}; }

double distance(const Point3& p, const Point3& q) { return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]); }

template <class Function>
void for_each_list(TetMesh& mesh, const Function& f) {
  for (auto& tet : mesh.tets) f(tet.data(), tet.size());
  for (auto& triangle : mesh.triangles) f(triangle.data(), triangle.size());
  for (auto& edge : mesh.edges) f(edge.data(), edge.size());
  for (ElementBlock& block : mesh.others) f(block.element2vertex.data(), block.element2vertex.size());
  f(mesh.corners.data(), mesh.corners.size());
  f(mesh.required_vertices.data(), mesh.required_vertices.size());
}

}  // namespace

void leave_out(const std::vector<Middle>& middles, TetMesh& mesh) {
  if (middles.empty()) return;
  mesh.second_order = true;
  std::vector<Index> old2new(mesh.points.size(), 0);
  for (const Middle& m : middles) {
    const auto at = [&mesh](Index v) -> const Point3& { return mesh.points[static_cast<std::size_t>(v)]; };
    const Point3& p = at(m.ends[0]);
    const Point3& q = at(m.ends[1]);
    const Point3 middle{(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2};
    if (!(distance(middle, at(m.node)) <= kStraight * distance(p, q))) {
      throw FileError("it has curved second-order elements: node " + std::to_string(m.node + 1) +
                      " is not in the middle of its edge; tetune takes straight ones (in Gmsh, set "
                      "Mesh.SecondOrderLinear=1 before making them)");
    }
    old2new[static_cast<std::size_t>(m.node)] = -1;
  }
  const auto drop = [&](const Index* ids, std::size_t n) {
    if (std::any_of(ids, ids + n, [&](Index v) { return old2new[static_cast<std::size_t>(v)] < 0; })) {
      throw FileError("a node is in the middle of one element's edge and a vertex of another element");
    }
  };
  for_each_list(mesh, drop);
  std::vector<Index> new2old;
  for (std::size_t v = 0; v < old2new.size(); ++v) {
    if (old2new[v] < 0) continue;
    old2new[v] = static_cast<Index>(new2old.size());
    new2old.push_back(static_cast<Index>(v));
  }
  const auto take = [&new2old](auto& values, std::size_t each) {
    for (std::size_t v = 0; v < new2old.size(); ++v) {
      for (std::size_t c = 0; c < each; ++c) {
        values[v * each + c] = values[static_cast<std::size_t>(new2old[v]) * each + c];
      }
    }
    values.resize(new2old.size() * each);
  };
  take(mesh.points, 1);
  take(mesh.point_tags, 1);
  for (DataArray& array : mesh.point_data) {
    std::visit([&](auto& values) { take(values, static_cast<std::size_t>(array.components)); }, array.values);
  }
  for_each_list(mesh, [&](Index* ids, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) ids[i] = old2new[static_cast<std::size_t>(ids[i])];
  });
}

Middles::Middles(TetMesh& mesh) : first_(static_cast<Index>(mesh.points.size())) {
  const auto add = [this](const Index* v, const auto& pairs) {
    for (const Pair& p : pairs) edges_.push_back(sorted(v[p[0]], v[p[1]]));
  };
  for (const auto& tet : mesh.tets) add(tet.data(), kTetEdges);
  for (const auto& triangle : mesh.triangles) add(triangle.data(), kTriangleEdges);
  for (const auto& edge : mesh.edges) add(edge.data(), kEdgeEdges);
  std::sort(edges_.begin(), edges_.end());
  edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  for (const auto& [a, b] : edges_) {
    const Point3& p = mesh.points[static_cast<std::size_t>(a)];
    const Point3& q = mesh.points[static_cast<std::size_t>(b)];
    const Point3 middle{(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2};
    mesh.points.push_back(middle);
  }
  mesh.point_tags.resize(mesh.points.size(), 0);
  for (DataArray& array : mesh.point_data) {
    const auto each = static_cast<std::size_t>(array.components);
    std::visit(
        [&](auto& values) {
          using T = typename std::remove_cvref_t<decltype(values)>::value_type;
          values.reserve(mesh.points.size() * each);
          for (const auto& [a, b] : edges_) {
            for (std::size_t c = 0; c < each; ++c) {
              const T x = values[static_cast<std::size_t>(a) * each + c];
              const T y = values[static_cast<std::size_t>(b) * each + c];
              values.push_back(std::is_floating_point_v<T> ? static_cast<T>((x + y) / 2) : x);
            }
          }
        },
        array.values);
  }
}

Index Middles::of(Index a, Index b) const {
  return first_ + static_cast<Index>(std::lower_bound(edges_.begin(), edges_.end(), sorted(a, b)) - edges_.begin());
}

}  // namespace tetune::plugin
