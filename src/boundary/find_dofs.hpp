// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "boundary/classify.hpp"
#include "boundary/sliding/features.hpp"
#include "boundary/sliding/flat_patches.hpp"
#include "boundary/sliding/slide_surface.inl"
#include "boundary/sliding/thin_sheets.hpp"
#include "boundary/surface.hpp"
#include "boundary/vertex_dofs.hpp"
#include "mesh/constrained_edges.hpp"
#include "mesh/work_mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// The input of find_dofs().
template <class Backend>
struct DofInput {
  const Options& options;
  const Surface<Backend>& surface;
  /// The constrained edges, as pairs of work vertices; the first `ridges` of them are ridges or required edges.
  const std::vector<Index>& edge_ends;
  std::size_t ridges;
  const EdgeSet<Backend>& edges;
  const std::vector<VertexConstraint>& constraints;  ///< per work vertex
  double scale;                                      ///< coordinates of the work mesh per unit of the caller's
  double max_deviation;                              ///< of the surface by moves of vertices, in the caller's unit
  const SlideSurface* slides_on;                     ///< the surface for Boundary::slide; null: the mesh's own
  bool keeps_flat_patches;                           ///< vertices in flat patches of it move in their planes
  bool keeps_thin_sheets;                            ///< vertices of thin sheets move in planes and along lines
  const std::vector<Index>& original2vertex;
};

/// Where each vertex may go with Boundary::preserve, by `constraints` in place of those of the input. Requires the
/// numbers of corners, edges and ends that are not held in the report.
template <class Backend>
std::vector<MotionSpace> spaces_in_planes(const Backend& backend, WorkMesh<Backend>& mesh,
                                          const DofInput<Backend>& input,
                                          const std::vector<VertexConstraint>& constraints, const Report& report) {
  const Size vertices = mesh.vertices();
  BufferOf<Backend, VertexDof> dof(backend, vertices);
  BufferOf<Backend, Vec3> axis(backend, vertices);
  backend.fill(axis.span(), Vec3{});
  const DeviceViewOf<Backend, VertexConstraint> view(backend, constraints);
  const auto classify = [&](const EdgeSet<Backend>& features) {
    const ConstrainedSurface<Backend> constrained{input.surface, features, view.span()};
    classify_vertices(backend, mesh, constrained, SurfaceRule::keeps_shape, dof.span(), axis.span());
  };
  if (report.edges_not_held == 0) {
    classify(input.edges);
  } else {
    const Span<const Index> ends = span_of(input.edge_ends);
    classify(EdgeSet<Backend>(backend, {ends.data(), ends.data() + 2 * Size(input.ridges)}, vertices));
  }
  const std::vector<VertexDof> dofs = dof.download();
  const std::vector<Vec3> axes = axis.download();
  std::vector<MotionSpace> spaces;
  for (std::size_t v = 0; v < dofs.size(); ++v) {
    const bool is_corner =
        (constraints[v] == VertexConstraint::corner && report.corners_not_held == 0) ||
        (constraints[v] == VertexConstraint::line_end && report.edges_not_held == 0 && report.line_ends_not_held == 0);
    spaces.push_back({is_corner ? VertexDof::fixed : dofs[v], axes[v]});
  }
  return spaces;
}

namespace find_dofs_detail {

/// The radius of the displacement bound, in mean lengths of the edges at the vertex on the surface: for motion in
/// planes and along lines, and for motion on a curved surface.
inline constexpr double kMaxDisplacement = 0.5;
inline constexpr double kMaxSlideDisplacement = 0.75;

/// The vertices of a flat patch are within this part of the bound of their plane.
inline constexpr double kFlatShare = 1e-4;

struct FindDisplacementBound {
  Span<const Point> points;
  Span<const SurfaceTriangle> triangles;
  CsrView vertex2corner;
  double relative_radius;
  Span<DisplacementBound> displacement_bound;
  TETUNE_HD void operator()(Size v) const {
    const Vec3 center = vec(points[v]);
    double sum = 0;
    Size edges = 0;
    for (Size c = vertex2corner.begin(v); c < vertex2corner.end(v); ++c) {
      for (const Index other : triangles[vertex2corner.items[c] / 3].v) {
        if (other == v) continue;
        sum += norm(vec(points[other]) - center);
        ++edges;
      }
    }
    displacement_bound[v] = {
        center, edges > 0 ? relative_radius * sum / static_cast<double>(edges) : DisplacementBound::kUnbounded};
  }
};

/// Puts each vertex on its own reference vertex.
struct StartSurfacePoint {
  Span<SurfacePoint> surface_point;
  TETUNE_HD void operator()(Size v) const { surface_point[v] = {SurfacePointKind::vertex, to_index(v)}; }
};

template <class Backend>
void classify_own_surface(const Backend& backend, WorkMesh<Backend>& mesh, const DofInput<Backend>& input,
                          Span<const VertexConstraint> constraints, VertexDofs<Backend>& dofs, Report& report) {
  const Options& options = input.options;
  const bool slides = options.boundary == Boundary::slide;
  const auto classify = [&](const EdgeSet<Backend>& features) {
    const ConstrainedSurface<Backend> constrained{input.surface, features, constraints};
    if (slides) {
      build_reference(backend, mesh, constrained, options.feature_angle, dofs.dof.span(), dofs.reference);
    } else {
      const auto rule = options.boundary == Boundary::fixed ? SurfaceRule::fixed : SurfaceRule::keeps_shape;
      classify_vertices(backend, mesh, constrained, rule, dofs.dof.span(), dofs.axis.span());
    }
  };
  // Ridges and required edges are features. Tagged edges are features too, unless the list cannot be one of lines.
  const Span<const Index> ends = span_of(input.edge_ends);
  const Size ridge_ends = 2 * static_cast<Size>(input.ridges);
  classify(EdgeSet<Backend>(backend, {ends.data(), ends.data() + ridge_ends}, mesh.vertices()));
  const Size tagged = (ends.size() - ridge_ends) / 2;
  std::vector<VertexDof> dof = dofs.dof.download();
  if (tagged > 0 && are_feature_lines(ends, ridge_ends, span_of(dof))) {
    classify(input.edges);
    dof = dofs.dof.download();
  } else {
    report.edges_not_held = tagged;
  }
  report.corners_not_held = fix_corners(span_of(input.constraints), span_of(dof));
  if (report.edges_not_held == 0) report.line_ends_not_held = fix_line_ends(span_of(input.constraints), span_of(dof));
  dofs.dof.upload(backend, dof);
  if (!slides) return;
  dofs.reference.dof.assign(backend, dofs.dof);
  backend.for_each(mesh.vertices(), StartSurfacePoint{dofs.surface_point});
}

/// Lets vertices of thin sheets that slide move in planes and along lines instead; those beside other triangles and at
/// thin rims stay. Returns 1 per triangle of the surface that is of a thin sheet, else 0; nothing where none is.
template <class Backend>
std::vector<std::uint8_t> keep_thin_sheets(const Backend& backend, WorkMesh<Backend>& mesh,
                                           const DofInput<Backend>& input, VertexDofs<Backend>& dofs, Report& report) {
  auto [is_thin, stays] = find_thin_sheets(backend, mesh, dofs.reference);
  const auto has_marks = [](const std::vector<std::uint8_t>& marks) {
    return std::find(marks.begin(), marks.end(), 1) != marks.end();
  };
  if (!has_marks(is_thin) && !has_marks(stays)) return {};
  const std::vector<MotionSpace> spaces = spaces_in_planes(backend, mesh, input, input.constraints, report);
  const std::vector<SurfaceTriangle> triangles = input.surface.triangles.download();
  std::vector<std::uint8_t> has_thin = stays;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const Index v : triangles[t].v) span_of(is_thin[t] != 0 ? has_thin : stays)[v] = 1;
  }
  std::vector<VertexDof> dof = dofs.dof.download();
  std::vector<Vec3> axis = dofs.axis.download();
  for (std::size_t v = 0; v < spaces.size(); ++v) {
    if (has_thin[v] == 0 || (dof[v] != VertexDof::surface && dof[v] != VertexDof::curve)) continue;
    ++report.thin_vertices;
    dof[v] = stays[v] != 0 ? VertexDof::fixed : spaces[v].dof;
    axis[v] = spaces[v].axis;
  }
  dofs.dof.upload(backend, dof);
  dofs.axis.upload(backend, axis);
  return std::move(is_thin);
}

/// Lets the vertices of flat patches of the reference surface move in planes and along lines.
template <class Backend>
FlatPatches keep_flat_patches(const Backend& backend, VertexDofs<Backend>& dofs) {
  const ReferenceSurfaceOnHost reference = dofs.reference.download();
  FlatPatches flat(reference, kFlatShare * dofs.max_deviation);
  std::vector<VertexDof> dof = dofs.dof.download();
  std::vector<Vec3> axis = dofs.axis.download();
  flat.restrict_vertices(reference, dof, axis);
  dofs.dof.upload(backend, dof);
  dofs.axis.upload(backend, axis);
  return flat;
}

inline void count_dofs(const std::vector<VertexDof>& dofs, Report& report) {
  for (const VertexDof dof : dofs) {
    ++(dof == VertexDof::free      ? report.free_vertices
       : dof == VertexDof::plane   ? report.plane_vertices
       : dof == VertexDof::line    ? report.line_vertices
       : dof == VertexDof::surface ? report.surface_vertices
       : dof == VertexDof::curve   ? report.curve_vertices
                                   : report.fixed_vertices);
  }
}

}  // namespace find_dofs_detail

/// The parts of a surface that slides whose vertices do not.
struct HeldParts {
  FlatPatches flat;                ///< with DofInput::keeps_flat_patches
  std::vector<std::uint8_t> thin;  ///< with DofInput::keeps_thin_sheets: as keep_thin_sheets() returns it
};

/// Finds where each vertex may go, by Options::boundary, and makes all vertices active. The report receives the
/// numbers of vertices by degrees of freedom, and of listed corners, edges and their ends that are no features.
template <class Backend>
HeldParts find_dofs(const Backend& backend, WorkMesh<Backend>& mesh, const DofInput<Backend>& input,
                    VertexDofs<Backend>& dofs, Report& report) {
  using namespace find_dofs_detail;
  const Options& options = input.options;
  const Size vertices = mesh.vertices();
  const bool slides = options.boundary == Boundary::slide;
  if (slides) check_sliding_vertices(vertices);
  dofs.dof.resize(backend, vertices);
  dofs.axis.resize(backend, vertices);
  dofs.active.resize(backend, vertices);
  backend.fill(dofs.active.span(), std::uint8_t{1});
  if (slides) {
    // Vertices that slide have no axis, but restarts download the axes of all.
    backend.fill(dofs.axis.span(), Vec3{});
    // The bound is slightly smaller than the caller's, against rounding and for the unevenness of flat patches.
    constexpr double kMargin = 1e-5;
    const double margin = input.keeps_flat_patches ? kMargin + 3 * kFlatShare : kMargin;
    dofs.max_deviation = (1 - margin) * input.max_deviation * input.scale;
    // Underflow must not turn a bound into none.
    if (options.max_deviation > 0)
      dofs.max_deviation = std::max(dofs.max_deviation, 2 * std::numeric_limits<double>::min());
    dofs.surface_point.resize(backend, vertices);
  }
  const DeviceViewOf<Backend, VertexConstraint> constraints(backend, input.constraints);
  if (input.slides_on != nullptr) {
    import_slide_surface(backend, *input.slides_on, input.original2vertex, constraints.span(), input.scale, dofs);
  } else {
    classify_own_surface(backend, mesh, input, constraints.span(), dofs, report);
  }
  if (options.energy == Energy::shape && options.boundary != Boundary::fixed) {
    dofs.displacement_bound.resize(backend, vertices);
    backend.for_each(vertices,
                     FindDisplacementBound{mesh.points, input.surface.triangles, input.surface.vertex2corner.view(),
                                           slides ? kMaxSlideDisplacement : kMaxDisplacement, dofs.displacement_bound});
  }
  // Before the first run the surface is the reference surface.
  if (dofs.max_deviation > 0 && dofs.checked.points.size() == 0) {
    dofs.checked.points.assign(backend, mesh.points);
    dofs.checked.surface_points.assign(backend, dofs.surface_point);
  }
  HeldParts held;
  if (input.keeps_flat_patches) held.flat = keep_flat_patches(backend, dofs);
  if (input.keeps_thin_sheets) held.thin = keep_thin_sheets(backend, mesh, input, dofs, report);
  count_dofs(dofs.dof.download(), report);
  return held;
}

}  // namespace tetune
