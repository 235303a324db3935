// SPDX-License-Identifier: Apache-2.0
#include "mesh/transfer/point_locator.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_set>

namespace tetune {
namespace {

/// A barycentric coordinate above minus this counts as inside: those of a point on a face have rounding errors.
constexpr double kInside = 1e-13;
/// The largest number of steps of the walk, which can run in a circle.
constexpr int kMaxWalk = 300;
/// Weights that do not reproduce a point to this part of the longest edge are rejected: in a tetrahedron that is flat
/// to rounding they are noise.
constexpr double kPlaceRounding = 1e-10;
/// The largest number of tetrahedra that are searched around the start.
constexpr std::size_t kMaxSearch = 2000;

double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return dot(cross(b - a, c - a), d - a); }

/// The weight 1 for the vertex nearest to the point.
std::array<double, 4> nearest_corner(const Vec3& p, const std::array<Vec3, 4>& x) {
  std::size_t nearest = 0;
  for (std::size_t k = 1; k < 4; ++k) {
    if (dot(x[k] - p, x[k] - p) < dot(x[nearest] - p, x[nearest] - p)) nearest = k;
  }
  std::array<double, 4> weights{};
  weights[nearest] = 1;
  return weights;
}

}  // namespace

std::array<double, 4> volumes_at(const Vec3& p, const std::array<Vec3, 4>& x) {
  return {volume(p, x[1], x[2], x[3]), volume(x[0], p, x[2], x[3]), volume(x[0], x[1], p, x[3]),
          volume(x[0], x[1], x[2], p)};
}

PointLocator::PointLocator(HostMesh mesh) : mesh_(std::move(mesh)), vertex2tet_(mesh_.points.size(), -1) {
  for (Index slot = 0; slot < std::ssize(mesh_.tet2vertex); ++slot) {
    const Tet& tet = span_of(mesh_.tet2vertex)[slot];
    if (tet[0] == kFreeSlot) continue;
    for (const Index v : tet.v) span_of(vertex2tet_)[v] = slot;
  }
}

TetPoint PointLocator::locate(const Vec3& p, Index start) const {
  const Index first = span_of(vertex2tet_)[start];
  Hit hit = closest_in(p, first);
  Index slot = first;
  bool is_outside = false;
  for (int step = 0; hit.distance2 > 0 && step < kMaxWalk; ++step) {
    const std::array<double, 4> volumes = volumes_at(p, corners(slot));
    // Across the face that separates most, among those with a tetrahedron behind them.
    int face = -1;
    for (int k = 0; k < 4; ++k) {
      if (span_of(mesh_.tet2tet)[slot][k] == kNoHalfFace || volumes[to_size_t(k)] >= 0) continue;
      if (face < 0 || volumes[to_size_t(k)] < volumes[to_size_t(face)]) face = k;
    }
    is_outside = face < 0;
    if (is_outside) break;
    slot = tet_of(span_of(mesh_.tet2tet)[slot][face]);
    hit = closest_in(p, slot);
  }
  if (hit.distance2 > 0) {
    const Hit walked = hit;
    bool is_complete = true;
    hit = search(p, first, is_complete);
    if (!is_complete && !touches(hit)) hit = look_up(p, walked.distance2 < hit.distance2 ? walked : hit, is_outside);
  }
  return {span_of(mesh_.tet2vertex)[hit.slot], hit.weights};
}

std::array<Vec3, 4> PointLocator::corners(Index slot) const {
  std::array<Vec3, 4> x{};
  for (int k = 0; k < 4; ++k) x[to_size_t(k)] = vec(span_of(mesh_.points)[span_of(mesh_.tet2vertex)[slot][k]]);
  return x;
}

PointLocator::Hit PointLocator::closest_in(const Vec3& p, Index slot) const {
  const std::array<Vec3, 4> x = corners(slot);
  Hit hit{slot, volumes_at(p, x), 0};
  const double outside = -kInside * std::accumulate(hit.weights.begin(), hit.weights.end(), 0.0);
  const bool inside = std::all_of(hit.weights.begin(), hit.weights.end(), [=](double v) { return v >= outside; });
  double sum = 0;
  for (double& w : hit.weights) sum += w = std::max(w, 0.0);
  if (sum > 0) {
    for (double& w : hit.weights) w /= sum;
  } else {
    hit.weights = nearest_corner(p, x);
  }
  constexpr double kSmallest = 1e-300;  // 0 is the distance of points inside alone
  Vec3 q{0, 0, 0};
  for (std::size_t k = 0; k < 4; ++k) q = q + hit.weights[k] * x[k];
  hit.distance2 = dot(q - p, q - p);
  if (inside && touches(hit)) {
    hit.distance2 = 0;
  } else {
    hit.distance2 = std::max(hit.distance2, kSmallest);
  }
  return hit;
}

/// Whether the point is outside the tetrahedron by rounding only, as one that has moved within the surface.
bool PointLocator::touches(const Hit& hit) const {
  const std::array<Vec3, 4> x = corners(hit.slot);
  double longest2 = 0;
  for (std::size_t k = 1; k < 4; ++k) longest2 = std::max(longest2, dot(x[k] - x[0], x[k] - x[0]));
  return hit.distance2 <= kPlaceRounding * kPlaceRounding * longest2;
}

/// Breadth-first search through faces. `is_complete` becomes false where it ends at kMaxSearch.
PointLocator::Hit PointLocator::search(const Vec3& p, Index slot, bool& is_complete) const {
  std::vector<Index> queue{slot};
  std::unordered_set<Index> seen{slot};
  Hit best = closest_in(p, slot);
  for (std::size_t i = 0; i < queue.size() && best.distance2 > 0; ++i) {
    const Hit hit = closest_in(p, queue[i]);
    if (hit.distance2 < best.distance2) best = hit;
    for (int f = 0; f < 4; ++f) {
      const HalfFace across = span_of(mesh_.tet2tet)[queue[i]][f];
      if (queue.size() >= kMaxSearch) is_complete = false;
      if (across == kNoHalfFace || !is_complete) continue;
      if (seen.insert(tet_of(across)).second) queue.push_back(tet_of(across));
    }
  }
  return best;
}

void PointLocator::build_tree() const {
  std::vector<Box> boxes;
  for (Index slot = 0; slot < std::ssize(mesh_.tet2vertex); ++slot) {
    if (span_of(mesh_.tet2vertex)[slot][0] == kFreeSlot) continue;
    const std::array<Vec3, 4> x = corners(slot);
    Box box{x[0], x[0]};
    for (const Vec3& p : x) box.include(p);
    boxes.push_back(box);
    tree2slot_.push_back(slot);
  }
  tree_.emplace(boxes);
}

/// The tetrahedron that contains the point, wherever it is. If there is none, the closest one of all, but the known one
/// where the walk has ended at the surface: others may be across a gap.
PointLocator::Hit PointLocator::look_up(const Vec3& p, const Hit& known, bool is_outside) const {
  std::call_once(is_tree_built_, [this] { build_tree(); });
  Hit best = known;
  tree_->for_meeting(Box{p, p}, [&](Index i) {
    if (best.distance2 == 0) return;
    const Hit hit = closest_in(p, span_of(tree2slot_)[i]);
    if (hit.distance2 == 0) best = hit;
  });
  if (best.distance2 == 0 || is_outside) return best;
  tree_->for_closer(p, best.distance2, [&](Index i) {
    const Hit hit = closest_in(p, span_of(tree2slot_)[i]);
    if (hit.distance2 < best.distance2) best = hit;
  });
  return best;
}

}  // namespace tetune
