// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <Bnd_Box.hxx>
#include <Extrema_ExtPC.hxx>
#include <Extrema_ExtPS.hxx>
#include <gp_Pnt2d.hxx>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "model.hpp"
#include "trim_table.hpp"

namespace tetune::plugin {

inline constexpr double kAnyRadius = std::numeric_limits<double>::infinity();

/// The nearest point of an edge or a face.
struct Foot {
  gp_Pnt point;
  double distance = kAnyRadius;
  std::optional<gp_Pnt2d> uv{};  ///< of a face; none on its boundary
};

/// Nearest points of the edges and faces of a model, to the last bits. The data of an entity that
/// searches need are prepared by the first search on it. Not for concurrent calls.
class NearestPoints {
 public:
  explicit NearestPoints(const Model& model);

  Foot on_edge(int edge, const gp_Pnt& p);
  /// The nearest point of the trimmed face if it is within `radius`; otherwise only a lower bound of the distance,
  /// above `radius`. A guess near the foot saves a search over the whole face; it may be wrong. `precision`: the foot
  /// may be off along the surface by this part of the distance, so that the distance is off by its square.
  Foot on_face(int face, const gp_Pnt& p, double radius, const std::optional<gp_Pnt2d>& guess = {},
               double precision = 0);

 private:
  struct Edge {
    BRepAdaptor_Curve curve;
    Extrema_ExtPC search;
    Bnd_Box box;
    std::vector<gp_Pnt> samples;  ///< at equal steps of the parameter; empty for lines and circles
    double cell = 0;              ///< largest distance between successive samples
  };
  struct Face {
    BRepAdaptor_Surface surface;
    std::unique_ptr<TrimTable> trim;
    std::unique_ptr<Extrema_ExtPS> search;
    bool is_elementary = false;
    std::vector<gp_Pnt> samples;      ///< on a grid of parameters; empty for elementary surfaces
    std::vector<gp_Pnt2d> sample_uv;  ///< their parameters
    int sample_columns = 0;
    double cell = 0;  ///< largest diagonal of a cell of the grid
  };

  Edge& edge(int i);
  Face& face(int i);
  static std::optional<Foot> refine(const Face& face, const gp_Pnt& p, gp_Pnt2d uv, double precision = 0);
  static bool is_inside(Face& face, const Foot& foot) { return face.trim->is_inside(*foot.uv); }
  static void sample(Edge& edge);
  static void sample(Face& face);
  /// The nearest point of a curve that has samples near `p`, found from those that are nearer than their neighbors.
  static std::optional<Foot> search_from_samples(const Edge& edge, const gp_Pnt& p);
  /// The sample nearest to a point, and its distance.
  static std::pair<gp_Pnt2d, double> nearest_sample(const Face& face, const gp_Pnt& p);
  /// The nearest of the extrema of the surface that are on the face; and a lower bound of all distances in `least`.
  Foot search_surface(Face& face, const gp_Pnt& p, double& least);
  /// The nearest of the extrema within `radius` that are on the face, found from the samples that are nearer than those
  /// around them.
  Foot search_from_samples(Face& face, const gp_Pnt& p, double radius);
  Foot on_boundary(int face, const gp_Pnt& p, double radius);

  const Model& model_;
  std::vector<std::unique_ptr<Edge>> edges_;
  std::vector<std::unique_ptr<Face>> faces_;
};

}  // namespace tetune::plugin
