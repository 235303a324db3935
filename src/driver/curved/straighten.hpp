// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "curved/relaxation.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// The curved edges of a surface, and the part of its curvature that each has.
class SurfaceCurvature {
 public:
  using Edge = std::array<Index, 2>;

  explicit SurfaceCurvature(const std::vector<CurvedEdge>& edges);

  bool has(const Edge& edge) const { return surface_.contains(edge); }
  double kept(const Edge& edge) const { return surface_.at(edge).kept; }
  /// Whether an edge of the surface has none of its curvature.
  bool is_straight(const Edge& edge) const { return has(edge) && kept(edge) == 0; }
  /// Gives an edge of the surface the part `kept` of its curvature.
  void set(const TetMesh& mesh, CurvedEdge& edge, double kept);
  /// Multiplies the curvature of the edges on the surface of listed tetrahedra by `kept`. With 0 these edges become
  /// straight, and so do the inner edges of the tetrahedra that are not held.
  void reduce(TetMesh& mesh, const HeldNodes& held, const std::vector<Index>& tets, double kept);
  /// The edges that do not have all of their curvature.
  std::vector<StraightenedEdge> reduced(const TetMesh& mesh) const;

 private:
  struct State {
    Point3 middle;    ///< on the curved surface
    double kept = 1;  ///< fraction of its curvature
  };
  std::map<Edge, State> surface_;
};

/// Makes invalid elements valid by reducing the curvature of their edges on the surface, by the least amount to within
/// some hundredths, and by relaxation. Edges that the options or the mesh freeze stay. Where this does not suffice,
/// some elements are not valid afterwards. Returns the edges that moved.
std::vector<StraightenedEdge> straighten(TetMesh& mesh, const HeldNodes& held, const Options& options,
                                         const RelaxationGoal& goal);

}  // namespace tetune
