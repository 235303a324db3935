// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mesh/half_face.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// A copy of the geometry and the connectivity of a work mesh, in the host's memory.
struct HostMesh {
  std::vector<Point> points;
  std::vector<Tet> tet2vertex;
  std::vector<FaceAdjacency> tet2tet;

  HostMesh() = default;
  template <class Backend>
  explicit HostMesh(const WorkMesh<Backend>& mesh)
      : points(mesh.points.download()), tet2vertex(mesh.tet2vertex.download()), tet2tet(mesh.tet2tet.download()) {}
};

/// A copy of a whole work mesh, which may be written back.
struct MeshSnapshot : HostMesh {
  std::vector<Index> tet2original, vertex2original;
  std::vector<Index> free_slots;

  MeshSnapshot() = default;
  template <class Backend>
  explicit MeshSnapshot(const WorkMesh<Backend>& mesh)
      : HostMesh(mesh),
        tet2original(mesh.tet2original.download()),
        vertex2original(mesh.vertex2original.download()),
        free_slots(mesh.free_slots.download()) {
    free_slots.resize(to_size_t(mesh.free_count));
  }
  template <class Backend>
  void upload(const Backend& backend, WorkMesh<Backend>& mesh) const {
    mesh.points.upload(backend, points);
    mesh.tet2vertex.upload(backend, tet2vertex);
    mesh.tet2tet.upload(backend, tet2tet);
    mesh.tet2original.upload(backend, tet2original);
    mesh.vertex2original.upload(backend, vertex2original);
    mesh.free_slots.upload(backend, free_slots);
    mesh.free_count = std::ssize(free_slots);
  }
};

}  // namespace tetune
