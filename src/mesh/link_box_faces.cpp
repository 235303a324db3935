// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "backend/span.hpp"
#include "mesh/messages.hpp"
#include "mesh/periodic.hpp"
#include "mesh/validate_arrays.hpp"
#include "tetune/error.hpp"
#include "tetune/periodic.hpp"

namespace tetune {
namespace {

/// The vertices of tetrahedra that lie on a plane across an axis, by cells of the two other coordinates.
class FaceVertices {
 public:
  FaceVertices(const std::vector<Point3>& points, const std::vector<Index>& vertices, std::size_t axis,
               double tolerance)
      : points_(points), axis_(axis), tolerance_(tolerance) {
    for (const Index v : vertices) entries_.push_back({cell_of(span_of(points)[v]), v});
    std::sort(entries_.begin(), entries_.end());
  }
  /// The vertex at the position of another one, but for the coordinate of the axis; -1 if there is none.
  Index find(const Point3& at) const {
    for (const double dy : {-tolerance_, tolerance_}) {
      for (const double dz : {-tolerance_, tolerance_}) {
        Point3 corner = at;
        corner[(axis_ + 1) % 3] += dy;
        corner[(axis_ + 2) % 3] += dz;
        const Cell cell = cell_of(corner);
        auto entry = std::lower_bound(entries_.begin(), entries_.end(), std::pair(cell, Index{0}));
        for (; entry != entries_.end() && entry->first == cell; ++entry) {
          if (is_at(span_of(points_)[entry->second], at)) return entry->second;
        }
      }
    }
    return -1;
  }

 private:
  using Cell = std::array<double, 2>;
  Cell cell_of(const Point3& p) const {
    const double size = 4 * tolerance_;
    return {std::floor(p[(axis_ + 1) % 3] / size), std::floor(p[(axis_ + 2) % 3] / size)};
  }
  bool is_at(const Point3& p, const Point3& at) const {
    return std::fabs(p[(axis_ + 1) % 3] - at[(axis_ + 1) % 3]) <= tolerance_ &&
           std::fabs(p[(axis_ + 2) % 3] - at[(axis_ + 2) % 3]) <= tolerance_;
  }
  const std::vector<Point3>& points_;
  std::size_t axis_;
  double tolerance_;
  std::vector<std::pair<Cell, Index>> entries_;
};

[[noreturn]] void fail_to_match(const TetMesh& mesh, Index v, std::size_t axis, std::size_t unmatched) {
  const std::string name(1, "xyz"[axis]);
  throw MeshError("periodic in " + name + ": " + std::to_string(unmatched) +
                  " vertices on the faces of smallest and largest " + name +
                  " have no vertex opposite; the first is vertex " + std::to_string(v + 1) + " (counted from 1) " +
                  place_text(span_of(mesh.points)[v]) +
                  ". The mesh must be a box whose opposite faces have the same vertices: mesh one as a copy of the "
                  "other, or list the pairs in a file");
}

/// The link of the two faces across an axis.
PeriodicLink link_across(const TetMesh& mesh, std::size_t axis, const std::vector<std::uint8_t>& is_used,
                         double tolerance) {
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  for (std::size_t v = 0; v < is_used.size(); ++v) {
    if (is_used[v] == 0) continue;
    low = std::min(low, mesh.points[v][axis]);
    high = std::max(high, mesh.points[v][axis]);
  }
  std::vector<Index> masters;
  std::vector<Index> images;
  for (std::size_t v = 0; v < is_used.size(); ++v) {
    if (is_used[v] == 0) continue;
    if (mesh.points[v][axis] <= low + tolerance) masters.push_back(to_index(v));
    if (mesh.points[v][axis] >= high - tolerance) images.push_back(to_index(v));
  }
  const FaceVertices opposite(mesh.points, masters, axis, tolerance);
  PeriodicLink link;
  std::vector<std::uint8_t> is_paired(mesh.points.size(), 0);
  std::vector<Index> unmatched;
  for (const Index v : images) {
    const Index master = opposite.find(span_of(mesh.points)[v]);
    if (master < 0 || span_of(is_paired)[master] != 0) {
      unmatched.push_back(v);
      continue;
    }
    span_of(is_paired)[master] = 1;
    link.pairs.push_back({v, master});
  }
  for (const Index v : masters) {
    if (span_of(is_paired)[v] == 0) unmatched.push_back(v);
  }
  if (!unmatched.empty()) {
    fail_to_match(mesh, *std::min_element(unmatched.begin(), unmatched.end()), axis, unmatched.size());
  }
  return link;
}

}  // namespace

void link_box_faces(TetMesh& mesh, const std::array<bool, 3>& axes) {
  std::vector<std::uint8_t> is_used(mesh.points.size(), 0);
  for (const auto& tet : mesh.tets) {
    for (const Index v : tet) {
      if (v < 0 || v >= std::ssize(is_used)) require_arrays(mesh);  // throws
      span_of(is_used)[v] = 1;
    }
  }
  const double tolerance = kMatchTolerance * extent_of(mesh);
  std::vector<PeriodicLink> links;
  for (std::size_t axis = 0; axis < 3 && !mesh.tets.empty(); ++axis) {
    if (axes[axis]) links.push_back(link_across(mesh, axis, is_used, tolerance));
  }
  mesh.periodic.insert(mesh.periodic.end(), links.begin(), links.end());
}

}  // namespace tetune
