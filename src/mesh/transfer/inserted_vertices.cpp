// SPDX-License-Identifier: Apache-2.0
#include "mesh/transfer/inserted_vertices.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "math/box_tree.hpp"
#include "mesh/sorted.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/transfer/point_locator.hpp"

namespace tetune {
namespace {

/// A vertex of a tetrahedron supports a point whose barycentric coordinate for it is above this.
constexpr double kTolerance = 1e-6;

/// Finds the places of points in a mesh.
class TetSearch {
 public:
  explicit TetSearch(const TetMesh& mesh) : view_(mesh, unit_scale(mesh)), tree_(boxes()) {}

  /// The place of a point in the tetrahedron in which its smallest barycentric coordinate is largest. Rounding may make
  /// that negative. All weights are 0 where no tetrahedron contains the point.
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
  constexpr std::size_t kMaxNeighbors = 32;  // of a vertex: some have thousands
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
      const auto of_vertex = pairs_from(neighbors, v);
      for (const auto& pair : of_vertex.first(std::min(of_vertex.size(), kMaxNeighbors))) inside.push_back(pair.second);
    }
    if (inside.empty()) i->support.clear();
    i->support.insert(i->support.end(), inside.begin(), inside.end());
  }
}

}  // namespace

std::vector<Index> support_of(const MeshPlace& place) {
  std::vector<Index> support;
  for (std::size_t k = 0; k < 4; ++k) {
    if (place.weights[k] > kTolerance) support.push_back(place.vertices[k]);
  }
  return support;
}

std::vector<MeshPlace> find_places(const TetMesh& mesh, const TetMesh& result, const std::vector<Index>& ids) {
  MeshPlace nowhere;
  nowhere.weights.fill(0);
  std::vector<MeshPlace> places(result.points.size(), nowhere);
  const TetSearch search(mesh);
  for (const Index id : ids) span_of(places)[id] = search.find(span_of(result.points)[id]);
  return places;
}

std::vector<std::uint8_t> mark_vertices(const std::vector<std::array<Index, 3>>& faces, std::size_t count) {
  std::vector<std::uint8_t> marks(count, 0);
  for (const auto& face : faces) {
    for (const Index v : face) span_of(marks)[v] = 1;
  }
  return marks;
}

std::vector<InsertedVertex> find_inserted(const TetMesh& mesh, const TetMesh& result,
                                          const std::vector<std::uint8_t>& on_surface, const std::vector<Index>& ids,
                                          const std::vector<MeshPlace>& places) {
  std::vector<InsertedVertex> inserted;
  for (const Index id : ids) inserted.push_back({id, {}, {}});
  if (inserted.empty()) return inserted;
  if (places.empty()) return find_inserted(mesh, result, on_surface, ids, find_places(mesh, result, ids));
  for (InsertedVertex& i : inserted) i.place = span_of(places)[i.id];
  for (InsertedVertex& i : inserted) i.support = support_of(i.place);
  const std::vector<std::uint8_t> on_old_surface = mark_vertices(find_surface_faces(mesh), mesh.points.size());
  std::vector<InsertedVertex*> between_surfaces;
  for (InsertedVertex& i : inserted) {
    const auto is_on_surface = [&](Index v) { return span_of(on_old_surface)[v] != 0; };
    const bool is_inside = span_of(on_surface)[i.id] == 0;
    if (is_inside && std::all_of(i.support.begin(), i.support.end(), is_on_surface)) between_surfaces.push_back(&i);
  }
  if (!between_surfaces.empty()) add_inner_neighbors(mesh, on_old_surface, between_surfaces);
  return inserted;
}

}  // namespace tetune
