// SPDX-License-Identifier: Apache-2.0
#include "pieces.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "plugin.hpp"
#include "vtk_arrays.hpp"

namespace tetune::plugin {
namespace {

/// Points of two pieces that are nearer to each other than this fraction of the diagonal are one whose coordinates were
/// rounded differently.
constexpr double kTornDistance = 1e-9;

/// Calls visit(ids) for the vertices of each element, and the mid-side nodes of each edge with one.
template <class Visit>
void for_each_element(const TetMesh& mesh, const std::vector<Middle>& middles, const Visit& visit) {
  for (const auto& tet : mesh.tets) visit(std::span<const Index>(tet));
  for (const auto& triangle : mesh.triangles) visit(std::span<const Index>(triangle));
  for (const auto& edge : mesh.edges) visit(std::span<const Index>(edge));
  for (const ElementBlock& block : mesh.others) {
    const std::size_t size(block.vertices_per_element);
    for (std::size_t i = 0; i + size <= block.element2vertex.size(); i += size) {
      visit(std::span(block.element2vertex).subspan(i, size));
    }
  }
  for (const Middle& middle : middles) {
    const std::array<Index, 2> ids{middle.node, middle.ends[0]};
    visit(std::span<const Index>(ids));
  }
}

/// Points that elements connect before pieces are merged: those of one set are in one piece.
class ConnectedSets {
 public:
  explicit ConnectedSets(std::size_t points) : parent_(points) { std::iota(parent_.begin(), parent_.end(), Index{0}); }
  Index of(Index v) {
    while (item(parent_, v) != v) {
      item(parent_, v) = item(parent_, item(parent_, v));
      v = item(parent_, v);
    }
    return v;
  }
  void connect(Index a, Index b) {
    a = of(a);
    b = of(b);
    item(parent_, std::max(a, b)) = std::min(a, b);
  }

 private:
  std::vector<Index> parent_;
};

/// The number of points that are nearer to one of another set than kTornDistance. `sets`: -1 for points to leave out.
std::size_t count_torn(const std::vector<Point3>& points, const std::vector<Index>& sets) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Point3 low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  for (const Point3& p : points) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  const double tolerance = kTornDistance * std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  if (!std::isfinite(tolerance)) return 0;
  // The positions along a direction that is oblique to regular meshes: few points have about the same one.
  std::vector<std::pair<double, Index>> order;
  for (Index v = 0; v < index_count(points); ++v) {
    if (item(sets, v) < 0) continue;
    const Point3& p = item(points, v);
    const double along = 0.5773 * (p[0] - low[0]) + 0.6159 * (p[1] - low[1]) + 0.5361 * (p[2] - low[2]);
    if (std::isfinite(along)) order.emplace_back(along, v);
  }
  std::sort(order.begin(), order.end());
  std::vector<bool> torn(points.size(), false);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto [along, a] = order[i];
    for (std::size_t j = i + 1; j < order.size() && order[j].first - along <= tolerance; ++j) {
      const Index b = order[j].second;
      if (item(sets, a) == item(sets, b)) continue;
      const Point3 &p = item(points, a), &q = item(points, b);
      if (std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) > tolerance) continue;
      item(torn, a) = item(torn, b) = true;
    }
  }
  return std::size_t(std::count(torn.begin(), torn.end(), true));
}

template <class Value>
std::vector<Value> gathered(const std::vector<Value>& values, const std::vector<vtkIdType>& positions) {
  std::vector<Value> result;
  for (const vtkIdType p : positions) result.push_back(item(values, p));
  return result;
}

/// The points that merge_points() keeps: per vertex the point whose data it has; and per point its vertex.
struct MergedPoints {
  std::vector<vtkIdType> vertex2point;
  std::vector<Index> point2vertex;
};

/// `ranks`: of the points at a position, the first one of the lowest rank is kept.
MergedPoints merged(const std::vector<Point3>& points, const std::vector<std::uint8_t>& ranks) {
  std::vector<vtkIdType> order(points.size());
  std::iota(order.begin(), order.end(), vtkIdType{0});
  const auto point = [&points](vtkIdType v) -> const Point3& { return item(points, v); };
  std::stable_sort(order.begin(), order.end(), [&](vtkIdType a, vtkIdType b) {
    return point(a) < point(b) || (!(point(b) < point(a)) && item(ranks, a) < item(ranks, b));
  });
  // The order of the vertices is that of the first points at their positions.
  std::vector<vtkIdType> first(order.size()), kept(order.size());
  for (auto begin = order.begin(); begin != order.end();) {
    const auto same = [&](vtkIdType v) { return point(v) == point(*begin); };
    const auto end = std::find_if_not(begin + 1, order.end(), same);
    const vtkIdType lowest = *std::min_element(begin, end);
    item(kept, lowest) = *begin;
    for (; begin != end; ++begin) item(first, *begin) = lowest;
  }
  MergedPoints result;
  result.point2vertex.resize(order.size());
  for (vtkIdType v = 0; v < std::ssize(first); ++v) {
    const bool is_first = item(first, v) == v;
    item(result.point2vertex, v) =
        is_first ? index_count(result.vertex2point) : item(result.point2vertex, item(first, v));
    if (is_first) result.vertex2point.push_back(item(kept, v));
  }
  return result;
}

}  // namespace

std::size_t merge_points(TetMesh& mesh, const std::vector<bool>& duplicates, std::vector<Middle>& middles) {
  constexpr std::uint8_t kUnused = 2, kDuplicate = 1;
  std::vector<std::uint8_t> ranks(mesh.points.size(), kUnused);
  ConnectedSets sets(mesh.points.size());
  for_each_element(mesh, middles, [&](std::span<const Index> ids) {
    for (const Index v : ids) {
      item(ranks, v) = 0;
      sets.connect(ids[0], v);
    }
  });
  for (std::size_t v = 0; v < ranks.size(); ++v) {
    if (duplicates[v]) ranks[v] |= kDuplicate;
  }
  const auto [kept, old2new] = merged(mesh.points, ranks);
  std::vector<Index> vertex2set;
  for (const vtkIdType p : kept) vertex2set.push_back(item(ranks, p) >= kUnused ? -1 : sets.of(Index(p)));
  if (kept.size() == mesh.points.size()) return count_torn(mesh.points, vertex2set);
  mesh.points = gathered(mesh.points, kept);
  mesh.point_tags = gathered(mesh.point_tags, kept);
  for (DataArray& array : mesh.point_data) array = entries(array, kept);
  const auto renumber = [&numbers = old2new](auto& ids) {
    for (Index& v : ids) v = item(numbers, v);
  };
  for (auto& tet : mesh.tets) renumber(tet);
  for (auto& triangle : mesh.triangles) renumber(triangle);
  for (auto& edge : mesh.edges) renumber(edge);
  for (ElementBlock& block : mesh.others) renumber(block.element2vertex);
  for (Middle& middle : middles) {
    middle.node = item(old2new, middle.node);
    renumber(middle.ends);
  }
  for (std::vector<Index>* ids : {&mesh.corners, &mesh.required_vertices}) {
    renumber(*ids);
    std::sort(ids->begin(), ids->end());
    ids->erase(std::unique(ids->begin(), ids->end()), ids->end());
  }
  return count_torn(mesh.points, vertex2set);
}

}  // namespace tetune::plugin
