// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "mesh/transfer/point_locator.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// Follows where the vertices are in the input while a mesh is improved and moved: a motion takes the input along, and
/// an improvement moves vertices through it (docs/method.md, "Data").
class PlaceTracker {
 public:
  /// `mesh` is the input: vertex v is the caller's vertex vertex2original[v].
  PlaceTracker(HostMesh mesh, std::vector<Index> vertex2original, int threads);

  /// To be called before and after each improvement.
  void start(HostMesh mesh) { before_ = std::make_unique<PointLocator>(std::move(mesh)); }
  void finish(const HostMesh& mesh);

  /// The places of all vertices in the input, in the caller's ids: one per entry of `work2new`, the ids in the result,
  /// negative for a vertex that it lacks.
  std::vector<MeshPlace> places(const std::vector<Index>& work2new) const;

 private:
  const int threads_;
  const PointLocator input_;
  const std::vector<Index> vertex2original_;
  std::vector<Vec3> material_;  ///< per vertex: its position in the input
  std::vector<Index> start_;    ///< per vertex: a vertex of the input near it
  std::unique_ptr<PointLocator> before_;
};

}  // namespace tetune
