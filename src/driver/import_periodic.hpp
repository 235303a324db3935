// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <span>
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

/// PeriodicImages on the host.
struct HostImages {
  std::vector<PeriodicMember> members;
  std::vector<std::uint32_t> first{0};
  std::vector<Index> vertex2class;

  explicit HostImages(std::size_t vertices) : vertex2class(vertices, -1) {}
  std::size_t classes() const { return first.size() - 1; }
  std::span<const PeriodicMember> of_class(std::size_t c) const {
    return {members.data() + first[c], members.data() + first[c + 1]};
  }
  void add(std::span<const PeriodicMember> added) {
    for (const PeriodicMember& member : added) span_of(vertex2class)[member.vertex] = to_index(classes());
    members.insert(members.end(), added.begin(), added.end());
    first.push_back(std::uint32_t(members.size()));
  }
  template <class Backend>
  void upload(const Backend& backend, PeriodicImages<Backend>& images) const {
    images.members.upload(backend, members);
    images.first.upload(backend, first);
    images.vertex2class.upload(backend, vertex2class);
  }
};

/// The caller's classes, in work vertices and their coordinates.
inline HostImages find_images(const TetMesh& mesh, const std::vector<Index>& original2vertex, double scale,
                              std::size_t vertices) {
  const PeriodicClasses classes = find_periodic_classes(mesh);
  HostImages images(vertices);
  std::vector<PeriodicMember> members;
  for (std::size_t c = 0; c < classes.size(); ++c) {
    members.clear();
    for (std::uint32_t m = classes.first[c]; m < classes.first[c + 1]; ++m) {
      members.push_back({span_of(original2vertex)[classes.members[m]], scale * classes.shifts[m]});
    }
    images.add(members);
  }
  return images;
}

/// The bound of the root, with the smallest radius of the members.
inline DisplacementBound bound_of_class(std::span<const PeriodicMember> members,
                                        const std::vector<DisplacementBound>& bounds) {
  DisplacementBound bound = span_of(bounds)[members.front().vertex];
  for (const PeriodicMember& m : members) bound.radius = std::min(bound.radius, span_of(bounds)[m.vertex].radius);
  return bound;
}

}  // namespace import_periodic_detail

/// Sets WorkingSet::periodic, the classes of linked vertices that may move, and lets the triangles of linked vertices
/// flip with their image. `without_links`: DofInput::constraints without those of periodic links.
template <class Backend>
void import_periodic(const Backend& backend, const TetMesh& mesh, const DofInput<Backend>& input,
                     const std::vector<VertexConstraint>& without_links, WorkingSet<Backend>& work, Report& report) {
  using namespace import_periodic_detail;
  // Within planes and along lines, even with Boundary::slide.
  const std::vector<MotionSpace> spaces = spaces_in_planes(backend, work.mesh, input, without_links, report);
  const HostImages images = find_images(mesh, input.original2vertex, work.scale, spaces.size());
  std::vector<std::uint8_t> stays(spaces.size(), 0);
  // Operations on a curved surface start from the places of its vertices on the reference surface.
  if (input.options.boundary == Boundary::slide) {
    stays = beside_other_surface(input.surface.triangles.download(), images.vertex2class);
  }
  const std::vector<DisplacementBound> bounds = work.dofs.displacement_bound.download();
  HostImages moving(spaces.size());
  std::vector<MotionSpace> space;
  for (std::size_t c = 0; c < images.classes(); ++c) {
    const std::span<const PeriodicMember> members = images.of_class(c);
    MotionSpace motion{VertexDof::free, {}};
    for (const PeriodicMember& member : members) {
      const MotionSpace own = span_of(spaces)[member.vertex];
      motion = intersect(motion, span_of(stays)[member.vertex] != 0 ? MotionSpace{VertexDof::fixed, {}} : own);
    }
    if (motion.dof == VertexDof::fixed) continue;
    if (!bounds.empty()) motion.displacement_bound = bound_of_class(members, bounds);
    moving.add(members);
    space.push_back(motion);
  }
  report.periodic_vertices = std::ssize(moving.members);
  report.fixed_vertices -= report.periodic_vertices;
  moving.upload(backend, work.periodic.images);
  work.periodic.space.upload(backend, space);
  if (work.boundary.triangles.size() == 0) return;
  images.upload(backend, work.boundary.images);
  const DeviceViewOf<Backend, VertexConstraint> constraints(backend, work.vertex_constraints);
  pair_triangles(backend, constraints.span(), work.boundary);
}

}  // namespace tetune
