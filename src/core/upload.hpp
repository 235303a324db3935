// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numeric>
#include <vector>

#include "core/work_mesh.hpp"

namespace tetune {

/// Points (times `scale`) and tetrahedra in a backend's memory, in the caller's order. Indices must be in
/// range.
template <class Backend>
WorkMesh<Backend> upload_mesh(const TetMesh& mesh, double scale = 1) {
  WorkMesh<Backend> work;
  std::vector<Point> points;
  points.reserve(mesh.points.size());
  for (const Point3& p : mesh.points) points.push_back(point(scale * vec(p)));
  work.points.upload(points);
  static_assert(sizeof(Tet) == sizeof(mesh.tets[0]));
  work.tet2vertex.resize(static_cast<Size>(mesh.tets.size()));
  Backend::upload(work.tet2vertex.span().data(), mesh.tets.data(), mesh.tets.size() * sizeof(Tet));
  std::vector<Index> ids(mesh.tets.size());
  std::iota(ids.begin(), ids.end(), 0);
  work.tet2original.upload(ids);
  return work;
}

}  // namespace tetune
