// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/work_mesh.hpp"

namespace tetune {

/// Points (times `scale`), tetrahedra and their tags in a backend's memory, in the caller's order. Indices must be in
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
  work.tet_tags.upload(mesh.tet_tags);
  return work;
}

}  // namespace tetune
