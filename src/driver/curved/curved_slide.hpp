// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "curved/quadratic_sheet.hpp"
#include "curved/surface_middles.hpp"
#include "tetune/mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

class ChunkedQueries;

/// New positions of nodes of a surface.
struct LiftedNodes {
  std::vector<Index> vertices;
  std::vector<Point3> points;       ///< of the vertices
  std::vector<CurvedEdge> middles;  ///< of edges, those that are straight now included; sorted by vertices

  void apply(TetMesh& mesh) const;
};

/// An upper bound on the distance between two surfaces, in both directions.
struct SurfaceDeviation {
  double bound = 0;
  std::vector<Index> vertices;  ///< of triangles that may be farther than the limit, in the first mesh; unsorted
};

/// The quadratic surface of a mesh, on which its vertices and mid-side nodes slide. The straight triangles parametrize
/// it: while the straight tetrahedra are optimized, vertices slide on these, and then each node gets the point of the
/// quadratic triangle with the same barycentric coordinates. Thus an edge inside one triangle lies on the
/// surface along its whole length.
///
/// Feature edges are listed lines, those that are not on two triangles of one sheet, and those at whose mid-side node
/// the quadratic surface turns by more than the feature angle; corners are vertices at which a line of them does.
class CurvedSlide {
 public:
  /// `mesh` is valid and has curved edges. It must outlive this object.
  CurvedSlide(const TetMesh& mesh, double feature_angle);

  bool has_edge(const std::array<Index, 2>& edge) const;
  /// Makes the feature edges ridges of a copy of the mesh, and the corners and periodic vertices required. Ridges that
  /// are not listed are added behind all other edges. The copy is to be optimized with a feature angle of 180 degrees.
  void constrain(TetMesh& skeleton) const;
  /// The nodes of the optimized skeleton on the quadratic surface, without those of edges and vertices that are as they
  /// were. Null where `stop` is true before all are found.
  std::optional<LiftedNodes> lift(const TetMesh& slid, const Report& report, int threads,
                                  const std::function<bool()>& stop) const;
  /// The distance of the surface of a result from that of the mesh, as of bound_distances() with
  /// Options::max_deviation.
  SurfaceDeviation deviation(const TetMesh& result, const Report& report, const Options& options,
                             const std::function<bool()>& stop) const;

 private:
  using Edge = std::array<Index, 2>;
  /// The parts of the slid surface: the chains, and behind them the components between features.
  struct SlidSurface {
    std::map<Edge, Index> edge2part;
    std::map<Index, Index> vertex2part;
    std::vector<std::vector<SheetTriangle>> components;
  };
  /// An edge of the skeleton's list.
  Edge listed_edge(Index e) const;
  /// The position of an edge among the features, or -1.
  Index find_feature(const Edge& edge) const;
  void find_features(double feature_angle);
  void find_chains(double feature_angle);
  SlidSurface find_slid_surface(const TetMesh& slid, const Report& report) const;
  std::vector<const QuadraticSheet*> sheets_with(const std::array<int, 3>& sides) const;
  const QuadraticSheet* sheet_of(const TetMesh& slid, const std::vector<SheetTriangle>& component,
                                 ChunkedQueries& queries) const;

  const TetMesh& mesh_;
  std::vector<SheetTriangle> triangles_;
  std::vector<Edge> edges_;           ///< of the triangles, sorted
  std::vector<Edge> features_;        ///< sorted
  std::vector<Edge> added_;           ///< those that the mesh does not list
  std::vector<Index> feature2chain_;  ///< feature edges between two corners, or ends of lines, are a chain
  std::vector<Index> corners_;
  std::vector<QuadraticSheet> sheets_, chains_;
  std::vector<std::array<int, 3>> sheet2sides_;
};

}  // namespace tetune
