// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "boundary/sliding/slide_surface.hpp"
#include "mesh/tet.hpp"
#include "tetune/move.hpp"

namespace tetune {

/// Whether a vertex has no target; a target has no NaN.
inline bool is_free(const Point3& p) { return std::isnan(p[0]) && std::isnan(p[1]) && std::isnan(p[2]); }
inline bool is_finite(const Point3& p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); }

/// The motion that optimize_on() makes for move().
struct MoveJob {
  std::span<const VertexTargets> targets;
  double scale;                      ///< see unit_scale(): of all targets
  std::vector<std::uint8_t> motion;  ///< per vertex: VertexMotion
  MoveReport& report;
};

/// move() with the surface that vertices slide on, as of optimize_on().
MoveReport move_on(TetMesh& mesh, std::span<const VertexTargets> targets, const Options& options,
                   const Context& context, SlideSurface* surface);

/// The memory of a backend that motion takes in addition, in bytes: the stiffness matrix and the vectors of its solver,
/// and where vertices slide their tangent spaces and the ends of their steps.
inline std::size_t motion_memory(const TetMesh& mesh, const Options& options) {
  constexpr std::size_t kPerTet = 90, kPerVertex = 260, kPerSlidingVertex = 60;
  const std::size_t slides = options.boundary == Boundary::slide ? kPerSlidingVertex * mesh.points.size() : 0;
  return kPerTet * mesh.tets.size() + kPerVertex * mesh.points.size() + slides;
}

/// A target in the order and the unit of the work mesh.
struct WorkTarget {
  std::vector<Vec3> positions;  ///< per work vertex; meaningful where prescribed
  std::vector<std::uint8_t> prescribed;
};
WorkTarget work_target(const VertexTargets& targets, const std::vector<Index>& vertex2original, double scale);

/// The arrays of a work mesh that report_blocking() needs.
struct BlockedMesh {
  std::vector<Tet> tets;                 ///< per slot
  std::vector<Index> slots;              ///< those that a further step would invert, in increasing order
  std::vector<std::uint8_t> unfinished;  ///< per vertex: it is prescribed and not at its target
  std::vector<Index> work2new;           ///< as of VertexNumbering
};

/// Sets MoveReport::blocking_tets and blocking_vertices. The tetrahedra of the result are the occupied slots, in order.
void report_blocking(const BlockedMesh& blocked, MoveReport& report);

}  // namespace tetune
