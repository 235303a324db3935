// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numeric>
#include <vector>

#include "mesh/work_mesh.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Uploads points, multiplied by `scale`, and tetrahedra in the caller's order. Requires indices in range.
template <class Backend>
WorkMesh<Backend> upload_mesh(const Backend& backend, const TetMesh& mesh, double scale = 1) {
  WorkMesh<Backend> work;
  std::vector<Point> points;
  points.reserve(mesh.points.size());
  for (const Point3& p : mesh.points) points.push_back(point(scale * vec(p)));
  work.points.upload(backend, points);
  static_assert(sizeof(Tet) == sizeof(mesh.tets[0]));
  work.tet2vertex.resize(backend, std::ssize(mesh.tets));
  backend.memory().upload(work.tet2vertex.span().data(), mesh.tets.data(), mesh.tets.size() * sizeof(Tet));
  std::vector<Index> ids(mesh.tets.size());
  std::iota(ids.begin(), ids.end(), 0);
  work.tet2original.upload(backend, ids);
  return work;
}

}  // namespace tetune
