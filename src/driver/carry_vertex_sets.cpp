// SPDX-License-Identifier: Apache-2.0
#include "driver/carry_vertex_sets.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "math/box_tree.hpp"
#include "mesh/node_sets.hpp"
#include "mesh/sorted.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/transfer/point_locator.hpp"

namespace tetune {
namespace {

/// A vertex of a tetrahedron supports a point whose barycentric coordinate for it is above this.
constexpr double kTolerance = 1e-6;

/// A vertex that a run has inserted.
struct InsertedVertex {
  Index id;
  std::vector<Index> support;  ///< the vertices of the input that decide its sets and its tag

  /// The value that all of the support have; 0 where they differ.
  template <class ValueOf>
  int common_value(const ValueOf& value_of) const {
    const int value = support.empty() ? 0 : value_of(support.front());
    for (const Index v : support) {
      if (value_of(v) != value) return 0;
    }
    return value;
  }
};

/// Whether the mesh has tags of vertices or sets of nodes.
bool has_vertex_sets(const TetMesh& mesh) {
  return std::any_of(mesh.point_tags.begin(), mesh.point_tags.end(), [](int tag) { return tag != 0; }) ||
         std::any_of(mesh.point_data.begin(), mesh.point_data.end(), is_node_set);
}

std::vector<std::uint8_t> find_surface_vertices(const TetMesh& mesh) {
  std::vector<std::uint8_t> on_surface(mesh.points.size(), 0);
  for_each_surface_face(mesh, 1, [&](const SortedHalfFace& face, bool) {
    for (const Index v : face.vertices) span_of(on_surface)[v] = 1;
  });
  return on_surface;
}

std::vector<Index> support_of(const MeshPlace& place) {
  std::vector<Index> support;
  for (std::size_t k = 0; k < 4; ++k) {
    if (place.weights[k] > kTolerance) support.push_back(place.vertices[k]);
  }
  return support;
}

/// Finds the places of points in a mesh.
class TetSearch {
 public:
  explicit TetSearch(const TetMesh& mesh) : view_(mesh, unit_scale(mesh)), tree_(boxes()) {}

  /// Of the tetrahedra that contain the point, but for rounding, the one that it is farthest inside; empty support
  /// where there is none.
  MeshPlace find(const Point3& p) const {
    // In units of about the size of the mesh.
    constexpr double kReach = 1e-9;
    const Vec3 x = view_.scale * vec(p);
    const Vec3 reach{kReach, kReach, kReach};
    MeshPlace place;
    place.weights.fill(0);
    double least = -kTolerance;
    tree_.for_meeting({x - reach, x + reach}, [&](Index t) {
      const std::array<Vec3, 4> at = corners(t);
      std::array<double, 4> weights = volumes_at(x, at);
      const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
      for (double& w : weights) w /= sum;
      const double lowest = *std::min_element(weights.begin(), weights.end());
      if (!(lowest > least) || !reproduce(weights, at, x)) return;
      least = lowest;
      place = {view_.tets[t], weights};
    });
    return place;
  }

 private:
  std::vector<Box> boxes() const {
    std::vector<Box> boxes;
    boxes.reserve(to_size_t(view_.tets.size()));
    for (Size t = 0; t < view_.tets.size(); ++t) {
      const auto& tet = view_.tets[t];
      Box box{view_.position(tet[0]), view_.position(tet[0])};
      for (const Index v : tet) box.include(view_.position(v));
      boxes.push_back(box);
    }
    return boxes;
  }
  std::array<Vec3, 4> corners(Index t) const {
    std::array<Vec3, 4> corners{};
    for (std::size_t k = 0; k < 4; ++k) corners[k] = view_.position(view_.tets[t][k]);
    return corners;
  }
  /// Whether the weights are those of the point: in a tetrahedron that is flat to rounding they are noise.
  static bool reproduce(const std::array<double, 4>& weights, const std::array<Vec3, 4>& corners, const Vec3& x) {
    Vec3 difference = x;
    double longest2 = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      difference = difference - weights[k] * corners[k];
      const Vec3 edge = corners[k] - corners[0];
      longest2 = std::max(longest2, dot(edge, edge));
    }
    return dot(difference, difference) <= kTolerance * kTolerance * longest2;
  }

  TetMeshView view_;
  BoxTree tree_;
};

/// Extends the support of each inserted vertex by vertices inside the mesh that share a tetrahedron with a vertex of
/// it. A support without such neighbors becomes empty.
void add_inner_neighbors(const TetMesh& mesh, const std::vector<std::uint8_t>& on_surface,
                         const std::vector<InsertedVertex*>& inserted) {
  constexpr Size kMaxNeighbors = 32;  // of a vertex: some have thousands
  std::vector<std::uint8_t> is_supporting(mesh.points.size(), 0);
  for (const InsertedVertex* i : inserted) {
    for (const Index v : i->support) span_of(is_supporting)[v] = 1;
  }
  std::vector<std::pair<Index, Index>> neighbors;  // of a supporting vertex, one inside
  for (const auto& tet : mesh.tets) {
    for (const Index v : tet) {
      if (span_of(is_supporting)[v] == 0) continue;
      for (const Index other : tet) {
        if (span_of(on_surface)[other] == 0) neighbors.emplace_back(v, other);
      }
    }
  }
  sort_unique(neighbors);
  for (InsertedVertex* i : inserted) {
    std::vector<Index> inside;
    for (const Index v : i->support) {
      auto at = std::lower_bound(neighbors.begin(), neighbors.end(), std::pair(v, Index{-1}));
      for (Size k = 0; k < kMaxNeighbors && at != neighbors.end() && at->first == v; ++k)
        inside.push_back((at++)->second);
    }
    if (inside.empty()) i->support.clear();
    i->support.insert(i->support.end(), inside.begin(), inside.end());
  }
}

/// Finds the support of vertices of `result`, at their places in `mesh`; without places, at their positions.
void find_support(const TetMesh& mesh, const TetMesh& result, const std::vector<MeshPlace>& places,
                  std::vector<InsertedVertex>& inserted) {
  if (places.empty()) {
    const TetSearch search(mesh);
    for (InsertedVertex& i : inserted) i.support = support_of(search.find(span_of(result.points)[i.id]));
  } else {
    for (InsertedVertex& i : inserted) i.support = support_of(span_of(places)[i.id]);
  }
  const std::vector<std::uint8_t> on_old_surface = find_surface_vertices(mesh);
  const std::vector<std::uint8_t> on_surface = find_surface_vertices(result);
  std::vector<InsertedVertex*> between_surfaces;
  for (InsertedVertex& i : inserted) {
    const auto is_on_surface = [&](Index v) { return span_of(on_old_surface)[v] != 0; };
    const bool is_inside = span_of(on_surface)[i.id] == 0;
    if (is_inside && std::all_of(i.support.begin(), i.support.end(), is_on_surface)) between_surfaces.push_back(&i);
  }
  if (!between_surfaces.empty()) add_inner_neighbors(mesh, on_old_surface, between_surfaces);
}

/// Sets the sets of nodes of the result, in the order of those before.
void carry_node_sets(const std::vector<DataArray>& before, const std::vector<Index>& new2original,
                     const std::vector<InsertedVertex>& inserted, std::vector<DataArray>& after) {
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!is_node_set(before[i])) continue;
    const auto from = span_of(std::get<std::vector<std::uint8_t>>(before[i].values));
    const auto to = span_of(std::get<std::vector<std::uint8_t>>(after[i].values));
    for (Size v = 0; v < to.size(); ++v) {
      const Size original = new2original.empty() ? v : Size{span_of(new2original)[v]};
      if (original >= 0) to[v] = from[original];
    }
    for (const InsertedVertex& v : inserted) {
      to[v.id] = std::uint8_t(v.common_value([&](Index original) { return int{from[original]}; }));
    }
  }
}

}  // namespace

std::vector<int> carry_vertex_sets(const TetMesh& mesh, const std::vector<Index>& new2original,
                                   const std::vector<MeshPlace>& places, const std::function<TetMesh()>& result,
                                   std::vector<DataArray>& point_data) {
  std::vector<InsertedVertex> inserted;
  for (Index v = 0; v < std::ssize(new2original); ++v) {
    if (span_of(new2original)[v] < 0) inserted.push_back({v, {}});
  }
  std::vector<int> tags(inserted.size(), 0);
  if (!has_vertex_sets(mesh)) return tags;
  if (!result) inserted.clear();
  if (!inserted.empty()) find_support(mesh, result(), places, inserted);
  carry_node_sets(mesh.point_data, new2original, inserted, point_data);
  std::transform(inserted.begin(), inserted.end(), tags.begin(), [&mesh](const InsertedVertex& v) {
    return v.common_value([&mesh](Index original) { return span_of(mesh.point_tags)[original]; });
  });
  return tags;
}

}  // namespace tetune
