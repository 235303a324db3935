// SPDX-License-Identifier: Apache-2.0
#include "driver/vertex_numbering.hpp"

#include <algorithm>

#include "boundary/constraints.hpp"

namespace tetune {

VertexNumbering::VertexNumbering(std::vector<Index> vertex2original, std::size_t originals)
    : work2extended(std::move(vertex2original)), originals_(originals) {
  std::vector<std::uint8_t> keep(originals, 0);
  for (Index& v : work2extended) {
    if (v == kInserted) {
      v = to_index(keep.size());
      keep.push_back(1);
    } else if (v != kRemoved) {
      span_of(keep)[v] = 1;
    }
  }
  has_removed_ = std::find(keep.begin(), keep.end(), 0) != keep.end();
  extended2new = positions_of_kept(keep);
  if (!has_removed_ && keep.size() == originals) return;
  for (std::size_t v = 0; v < keep.size(); ++v) {
    if (keep[v] != 0) new2original.push_back(v < originals ? to_index(v) : -1);
  }
}

std::vector<Index> VertexNumbering::work2new() const {
  std::vector<Index> ids = work2extended;
  for (Index& v : ids) v = v == kRemoved ? v : span_of(extended2new)[v];
  return ids;
}

std::vector<Point3> extended_points(const std::vector<Point3>& before, const std::vector<Point>& work_points,
                                    const VertexNumbering& numbering, double scale) {
  std::vector<Point3> points;
  points.reserve(numbering.extended());
  points = before;
  points.resize(numbering.extended());
  auto extended = numbering.work2extended.begin();
  for (const Point& now : work_points) {
    const Index id = *extended++;
    if (id == kRemoved) continue;
    Point3& p = span_of(points)[id];
    const Vec3 old = scale * vec(p);
    if (old.x == now.x && old.y == now.y && old.z == now.z) continue;
    p = {now.x / scale, now.y / scale, now.z / scale};
  }
  return points;
}

}  // namespace tetune
