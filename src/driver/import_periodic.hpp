// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "boundary/classify.hpp"
#include "boundary/find_dofs.hpp"
#include "boundary/motion_intersection.hpp"
#include "mesh/periodic.hpp"
#include "phases/tuning.hpp"
#include "phases/working_set.hpp"

namespace tetune {

/// Whether vertices of periodic links may move.
inline bool moves_periodic(const TetMesh& mesh, const Options& options) {
  // The bound on the deviation needs the place of each surface vertex on the reference surface.
  return !mesh.periodic.empty() && options.boundary != Boundary::fixed && options.max_iterations > 0 &&
         !has_deviation_bound(options);
}

namespace import_periodic_detail {

/// Where each vertex may go if periodic links do not count: within planes and along lines, even with Boundary::slide.
template <class Backend>
std::vector<MotionSpace> spaces_without_links(const Backend& backend, WorkMesh<Backend>& mesh,
                                              const DofInput<Backend>& input, const Report& report) {
  const Size vertices = mesh.vertices();
  BufferOf<Backend, VertexDof> dof(backend, vertices);
  BufferOf<Backend, Vec3> axis(backend, vertices);
  backend.fill(axis.span(), Vec3{});
  const DeviceViewOf<Backend, std::uint8_t> frozen(backend, input.frozen);
  const auto classify = [&](const EdgeSet<Backend>& features) {
    classify_vertices(backend, mesh, input.surface, features, frozen.span(), false, dof.span(), axis.span());
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
    const bool is_corner = input.frozen[v] == kCorner && report.corners_not_held == 0;
    spaces.push_back({is_corner ? VertexDof::fixed : dofs[v], axes[v]});
  }
  return spaces;
}

/// 1 for each vertex of a surface triangle with a vertex that is in no class.
inline std::vector<std::uint8_t> beside_other_surface(const std::vector<SurfaceTriangle>& triangles,
                                                      const std::vector<Index>& vertex2class) {
  std::vector<std::uint8_t> flags(vertex2class.size(), 0);
  for (const SurfaceTriangle& t : triangles) {
    const bool is_periodic = std::all_of(t.v, t.v + 3, [&](Index v) { return span_of(vertex2class)[v] >= 0; });
    if (is_periodic) continue;
    for (const Index v : t.v) span_of(flags)[v] = 1;
  }
  return flags;
}

/// A set of classes on the host.
struct HostSet {
  std::vector<PeriodicMember> members;
  std::vector<std::uint32_t> first{0};
  std::vector<MotionSpace> space;

  void add(const std::vector<PeriodicMember>& of_class, const MotionSpace& motion) {
    members.insert(members.end(), of_class.begin(), of_class.end());
    first.push_back(std::uint32_t(members.size()));
    space.push_back(motion);
  }
};

/// Uploads all classes.
template <class Backend>
void import_images(const Backend& backend, const PeriodicClasses& classes, const std::vector<Index>& original2vertex,
                   WorkingSet<Backend>& work) {
  std::vector<PeriodicMember> members;
  std::vector<Index> vertex2class(to_size_t(work.mesh.vertices()), -1);
  for (std::size_t c = 0; c < classes.size(); ++c) {
    for (std::uint32_t m = classes.first[c]; m < classes.first[c + 1]; ++m) {
      const Index v = span_of(original2vertex)[classes.members[m]];
      members.push_back({v, work.scale * classes.shifts[m]});
      span_of(vertex2class)[v] = to_index(c);
    }
  }
  PeriodicImages<Backend>& images = work.boundary.images;
  images.members.upload(backend, members);
  images.first.upload(backend, classes.first);
  images.vertex2class.upload(backend, vertex2class);
}

}  // namespace import_periodic_detail

/// Sets WorkingSet::periodic, the classes of linked vertices that may move, and lets the triangles of linked vertices
/// flip with their image. `input` has the caller's constraints without those of periodic links.
template <class Backend>
void import_periodic(const Backend& backend, const TetMesh& mesh, const DofInput<Backend>& input,
                     WorkingSet<Backend>& work, Report& report) {
  using namespace import_periodic_detail;
  const PeriodicClasses classes = find_periodic_classes(mesh);
  const std::vector<MotionSpace> spaces = spaces_without_links(backend, work.mesh, input, report);
  std::vector<Index> vertex2class(spaces.size(), -1);
  for (std::size_t c = 0; c < classes.size(); ++c) {
    for (std::uint32_t m = classes.first[c]; m < classes.first[c + 1]; ++m) {
      span_of(vertex2class)[span_of(input.original2vertex)[classes.members[m]]] = to_index(c);
    }
  }
  std::vector<std::uint8_t> held(spaces.size(), 0);
  // Operations on a curved surface start from the places of its vertices on the reference surface.
  if (input.options.boundary == Boundary::slide) {
    held = beside_other_surface(input.surface.triangles.download(), vertex2class);
  }
  const std::vector<DisplacementBound> bounds = work.dofs.displacement_bound.download();
  HostSet set;
  std::fill(vertex2class.begin(), vertex2class.end(), -1);
  for (std::size_t c = 0; c < classes.size(); ++c) {
    std::vector<PeriodicMember> members;
    MotionSpace motion{VertexDof::free, {}};
    DisplacementBound bound;
    for (std::uint32_t m = classes.first[c]; m < classes.first[c + 1]; ++m) {
      const Index v = span_of(input.original2vertex)[classes.members[m]];
      members.push_back({v, work.scale * classes.shifts[m]});
      const MotionSpace own = span_of(spaces)[v];
      motion = intersect(motion, span_of(held)[v] != 0 ? MotionSpace{VertexDof::fixed, {}} : own);
      if (bounds.empty()) continue;
      const DisplacementBound& b = span_of(bounds)[v];
      bound = {members.size() == 1 ? b.center : bound.center, std::min(bound.radius, b.radius)};
    }
    if (motion.dof == VertexDof::fixed) continue;
    motion.displacement_bound = bound;
    for (const PeriodicMember& member : members) span_of(vertex2class)[member.vertex] = to_index(set.space.size());
    set.add(members, motion);
  }
  report.periodic_vertices = std::ssize(set.members);
  report.fixed_vertices -= report.periodic_vertices;
  work.periodic.members.upload(backend, set.members);
  work.periodic.first.upload(backend, set.first);
  work.periodic.space.upload(backend, set.space);
  work.periodic.vertex2class.upload(backend, vertex2class);
  if (work.boundary.triangles.size() == 0) return;
  import_images(backend, classes, input.original2vertex, work);
  const DeviceViewOf<Backend, std::uint8_t> frozen(backend, work.frozen);
  pair_triangles(backend, frozen.span(), work.boundary);
}

}  // namespace tetune
