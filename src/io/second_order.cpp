// SPDX-License-Identifier: Apache-2.0
#include "io/second_order.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>

#include "backend/span.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// The largest distance of a node from the middle of its edge, relative to the edge, that rounding explains.
constexpr double kStraight = 1e-4;

std::array<Index, 2> sorted(Index a, Index b) { return a < b ? std::array{a, b} : std::array{b, a}; }

double distance(const Point3& p, const Point3& q) { return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]); }

/// The values of vertex v.
template <class Values>
auto entry_of(Values& values, Index v, std::size_t each) {
  return std::span(values).subspan(to_size_t(v) * each, each);
}

std::size_t components_of(const DataArray& array) { return to_size_t(array.components); }

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

void erase_middles(const std::vector<Middle>& middles, TetMesh& mesh) {
  if (middles.empty()) return;
  mesh.second_order = true;
  std::vector<Index> old2new(mesh.points.size(), 0);
  for (const Middle& m : middles) {
    const Point3& p = span_of(mesh.points)[m.ends[0]];
    const Point3& q = span_of(mesh.points)[m.ends[1]];
    const Point3 middle{(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2};
    if (!(distance(middle, span_of(mesh.points)[m.node]) <= kStraight * distance(p, q))) {
      throw FileError("it has curved second-order elements: node " + std::to_string(m.node + 1) +
                      " is not in the middle of its edge; tetune takes straight ones (in Gmsh, set "
                      "Mesh.SecondOrderLinear=1 before making them)");
    }
    span_of(old2new)[m.node] = -1;
  }
  const auto drop = [&](const Index* ids, std::size_t n) {
    if (std::any_of(ids, ids + n, [&](Index v) { return span_of(old2new)[v] < 0; })) {
      throw FileError("a node is in the middle of one element's edge and a vertex of another element");
    }
  };
  for_each_list(mesh, drop);
  std::vector<Index> new2old;
  for (std::size_t v = 0; v < old2new.size(); ++v) {
    if (old2new[v] < 0) continue;
    old2new[v] = to_index(new2old.size());
    new2old.push_back(Index(v));
  }
  for (PeriodicLink& link : mesh.periodic) {
    std::erase_if(link.pairs,
                  [&](const auto& pair) { return span_of(old2new)[pair[0]] < 0 || span_of(old2new)[pair[1]] < 0; });
    for (auto& pair : link.pairs) pair = {span_of(old2new)[pair[0]], span_of(old2new)[pair[1]]};
  }
  const auto take = [&new2old](auto& values, std::size_t each) {
    for (std::size_t v = 0; v < new2old.size(); ++v) {
      std::copy_n(entry_of(values, new2old[v], each).begin(), each, &values[v * each]);
    }
    values.resize(new2old.size() * each);
  };
  take(mesh.points, 1);
  take(mesh.point_tags, 1);
  for (DataArray& array : mesh.point_data) {
    std::visit([&](auto& values) { take(values, components_of(array)); }, array.values);
  }
  for_each_list(mesh, [&](Index* ids, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) ids[i] = span_of(old2new)[ids[i]];
  });
}

Middles::Middles(TetMesh& mesh) : first_(to_index(mesh.points.size())) {
  const auto add = [this](const Index* v, const auto& pairs) {
    for (const Pair& p : pairs) edges_.push_back(sorted(v[p[0]], v[p[1]]));
  };
  for (const auto& tet : mesh.tets) add(tet.data(), kTetEdges);
  for (const auto& triangle : mesh.triangles) add(triangle.data(), kTriangleEdges);
  for (const auto& edge : mesh.edges) add(edge.data(), kEdgeEdges);
  std::sort(edges_.begin(), edges_.end());
  edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  for (const auto& [a, b] : edges_) {
    const Point3& p = span_of(mesh.points)[a];
    const Point3& q = span_of(mesh.points)[b];
    const Point3 middle{(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2};
    mesh.points.push_back(middle);
  }
  mesh.point_tags.resize(mesh.points.size(), 0);
  for (DataArray& array : mesh.point_data) {
    const std::size_t each = components_of(array);
    std::visit(
        [&](auto& values) {
          using T = typename std::remove_cvref_t<decltype(values)>::value_type;
          values.reserve(mesh.points.size() * each);
          for (const auto& [a, b] : edges_) {
            for (std::size_t c = 0; c < each; ++c) {
              const T x = entry_of(values, a, each)[c];
              const T y = entry_of(values, b, each)[c];
              values.push_back(std::is_floating_point_v<T> ? T((x + y) / 2) : x);
            }
          }
        },
        array.values);
  }
}

Index Middles::of(Index a, Index b) const {
  return first_ + to_index(std::lower_bound(edges_.begin(), edges_.end(), sorted(a, b)) - edges_.begin());
}

void Middles::extend(PeriodicLink& link) const {
  std::map<Index, Index> master_of;
  for (const auto& [vertex, master] : link.pairs) master_of[vertex] = master;
  for (const auto& [a, b] : edges_) {
    const auto p = master_of.find(a);
    const auto q = master_of.find(b);
    if (p == master_of.end() || q == master_of.end()) continue;
    const auto master = sorted(p->second, q->second);
    if (std::binary_search(edges_.begin(), edges_.end(), master))
      link.pairs.push_back({of(a, b), of(master[0], master[1])});
  }
}

}  // namespace tetune
