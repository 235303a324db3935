// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mesh/half_face.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// A copy of a work mesh on the host.
struct HostMesh {
  std::vector<Point> points;
  std::vector<Tet> tets;
  std::vector<FaceAdjacency> tet2tet;

  HostMesh() = default;
  template <class Backend>
  explicit HostMesh(const WorkMesh<Backend>& mesh)
      : points(mesh.points.download()), tets(mesh.tet2vertex.download()), tet2tet(mesh.tet2tet.download()) {}
};

}  // namespace tetune
