// SPDX-License-Identifier: Apache-2.0
#include "driver/place_tracker.hpp"

#include <numeric>

#include "backend/cpu.hpp"

namespace tetune {
namespace {

bool same(const Vec3& a, const Vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/// For each vertex of `mesh` one that `known` has: itself, or for an inserted vertex one that is connected to it.
std::vector<Index> known_vertices(const HostMesh& mesh, const PointLocator& known) {
  std::vector<Index> near(mesh.points.size(), -1);
  for (Index v = 0; v < std::ssize(near); ++v) {
    if (known.has_tet(v)) span_of(near)[v] = v;
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (const Tet& tet : mesh.tet2vertex) {
      if (tet[0] == kFreeSlot) continue;
      Index found = -1;
      for (const Index v : tet.v) found = std::max(found, span_of(near)[v]);
      for (const Index v : tet.v) {
        if (found < 0 || span_of(near)[v] >= 0) continue;
        span_of(near)[v] = found;
        changed = true;
      }
    }
  }
  return near;
}

}  // namespace

PlaceTracker::PlaceTracker(HostMesh mesh, std::vector<Index> vertex2original, int threads)
    : threads_(threads), input_(std::move(mesh)), vertex2original_(std::move(vertex2original)) {
  for (const Point& p : input_.mesh().points) material_.push_back(vec(p));
  start_.resize(material_.size());
  std::iota(start_.begin(), start_.end(), 0);
}

void PlaceTracker::finish(const HostMesh& mesh) {
  const std::vector<Index> near = known_vertices(mesh, *before_);
  std::vector<Vec3> material(mesh.points.size());
  std::vector<Index> start(mesh.points.size(), 0);
  backend::Cpu(threads_).for_each(
      std::ssize(mesh.points),
      [&, old = span_of(material_), old_start = span_of(start_), to = span_of(material), to_start = span_of(start),
       near = span_of(near), points = span_of(mesh.points), before = span_of(before_->mesh().points)](Size v) {
        if (near[v] < 0) {  // of no tetrahedron
          if (v < old.size()) to[v] = old[v], to_start[v] = old_start[v];
          return;
        }
        to_start[v] = old_start[near[v]];
        if (v < before.size() && same(vec(points[v]), vec(before[v]))) {
          to[v] = old[v];
          return;
        }
        const TetPoint at = before_->locate(vec(points[v]), near[v]);
        Vec3 x{0, 0, 0};
        for (int k = 0; k < 4; ++k) x = x + at.weights[to_size_t(k)] * old[at.vertices[k]];
        to[v] = x;
        int largest = 0;
        for (int k = 1; k < 4; ++k) largest = at.weights[to_size_t(k)] > at.weights[to_size_t(largest)] ? k : largest;
        to_start[v] = old_start[at.vertices[largest]];
      });
  material_.swap(material);
  start_.swap(start);
  before_.reset();
}

std::vector<MeshPlace> PlaceTracker::places(const std::vector<Index>& work2new) const {
  Size count = 0;
  for (const Index v : work2new) count = std::max(count, Size{v} + 1);
  std::vector<MeshPlace> places(to_size_t(count));
  const auto points = span_of(input_.mesh().points);
  const auto original = span_of(vertex2original_);
  backend::Cpu(threads_).for_each(
      std::ssize(work2new), [&, to = span_of(places), ids = span_of(work2new), material = span_of(material_),
                             start = span_of(start_)](Size v) {
        if (ids[v] < 0) return;
        MeshPlace& place = to[ids[v]];
        if (v < points.size() && (same(material[v], vec(points[v])) || !input_.has_tet(start[v]))) {
          place.vertices.fill(original[v]);
          return;
        }
        const TetPoint at = input_.locate(material[v], start[v]);
        for (int k = 0; k < 4; ++k) place.vertices[to_size_t(k)] = original[at.vertices[k]];
        place.weights = at.weights;
      });
  return places;
}

}  // namespace tetune
