// SPDX-License-Identifier: Apache-2.0
#include "driver/result_mesh.hpp"

#include <algorithm>
#include <optional>
#include <type_traits>

#include "backend/cpu.hpp"
#include "boundary/constraints.hpp"
#include "driver/carry_vertex_sets.hpp"
#include "driver/transfer_stop.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/keep_entities.hpp"
#include "mesh/transfer/conserve.hpp"
#include "tetune/error.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// The positions of all vertices by extended id, in the caller's unit. Vertices that did not move keep the bits of
/// their coordinates; removed ones keep their last position.
std::vector<Point3> extended_points(const std::vector<Point3>& before, const std::vector<Point>& work_points,
                                    const VertexNumbering& numbering, double scale) {
  std::vector<Point3> points = before;
  points.resize(numbering.extended2new.size());
  auto extended = numbering.work2extended.begin();
  for (const Point& now : work_points) {
    const Index id = *extended++;
    if (id == kRemoved) continue;
    Point3& p = span_of(points)[id];
    const Vec3 old = scale * vec(p);
    if (old.x == now.x && old.y == now.y && old.z == now.z) continue;
    p = {now.x / scale, now.y / scale, now.z / scale};
  }
  return points;
}

/// Data of the vertices of the result.
std::vector<DataArray> carried_point_data(const TetMesh& mesh, const HostResult& result,
                                          const std::vector<Point3>& extended) {
  const VertexNumbering& numbering = result.numbering;
  if (mesh.point_data.empty() || numbering.new2original.empty()) return mesh.point_data;
  std::vector<Index> extended2original = identity_map(mesh.points.size());
  extended2original.resize(extended.size(), -1);
  return take_entries(carry_point_data(mesh.point_data, extended2original, extended, result.tets),
                      kept_of(numbering.extended2new));
}

std::vector<std::array<Index, 4>> tets_in_new_ids(const HostResult& result) {
  std::vector<std::array<Index, 4>> tets = result.tets;
  for (auto& tet : tets) {
    for (Index& v : tet) v = span_of(result.numbering.extended2new)[v];
  }
  return tets;
}

/// Sets the data of vertices and tetrahedra of the result, whose points are those by extended id.
void transfer_data(const TetMesh& mesh, const HostResult& result, const ExportRules& rules, TetMesh& next,
                   Report& report) {
  const Options& options = rules.options;
  const bool has_data = !mesh.point_data.empty() || !mesh.tet_data.empty();
  if (options.data == DataTransfer::conserve && has_data) {
    std::optional<ConservedData> data =
        conserve_data_until_stopped(backend::Cpu(options.threads, rules.stop_transfer), mesh, tets_in_new_ids(result),
                                    result.tet2original, report.places);
    if (data) {
      next.point_data = std::move(data->point_data);
      next.tet_data = std::move(data->tet_data);
      report.uncovered = data->uncovered;
      return;
    }
    report_transfer_given_up(report);
  }
  next.point_data = report.places.empty() ? carried_point_data(mesh, result, next.points)
                                          : interpolate_point_data(mesh.point_data, report.places);
  next.tet_data = take_entries(mesh.tet_data, result.tet2original);
}

/// Carries sets of nodes, and gives inserted vertices tags. The points of `next` are those by extended id, its data
/// those of the result. The shape of the result says where inserted vertices are, unless it has moved from the input's.
void carry_sets(const TetMesh& mesh, const HostResult& result, const ExportRules& rules, const Report& report,
                TetMesh& next) {
  const std::vector<Index>& extended2new = result.numbering.extended2new;
  std::function<TetMesh()> make_shape;
  if (!rules.is_moved || !report.places.empty()) {
    make_shape = [&] {
      TetMesh shape;
      shape.points = gather_entries(next.points, kept_of(extended2new));
      shape.tets = tets_in_new_ids(result);
      shape.tet_tags = regions_of(result.tet2original, mesh);
      return shape;
    };
  }
  const std::vector<int> tags =
      carry_vertex_sets(mesh, result.numbering.new2original, report.places, make_shape, next.point_data);
  auto tag = tags.begin();
  for (Size v = std::ssize(mesh.points); v < std::ssize(extended2new); ++v) {
    if (span_of(extended2new)[v] >= 0) span_of(next.point_tags)[v] = *tag++;
  }
}

/// Throws OverlapError, with the tetrahedra at faces of three or more, which flips have made.
[[noreturn]] void refuse_overlaps(const HostResult& result, const std::vector<Point3>& extended, int threads) {
  TetMesh mesh;
  mesh.points = extended;
  mesh.point_tags.resize(extended.size());
  mesh.tets = result.tets;
  mesh.tet_tags.resize(result.tets.size());
  std::vector<Index> overlapping;
  for (const Finding& finding : validate(mesh, threads).findings) {
    overlapping.insert(overlapping.end(), finding.first.begin(), finding.first.end());
  }
  throw OverlapError(translated_ids(std::move(overlapping), result.tet2original));
}

/// Replaces the listed triangles by those of the result. Those inside one region that lock nothing are dropped and
/// counted, unless they are sides of other elements. Those that other triangles have replaced on the boundary are not
/// counted. Returns the original of each.
std::vector<Index> replace_triangles(const TetMesh& mesh, const HostResult& result, const OtherElements& others,
                                     TetMesh& next, Report& report) {
  const ChangedTriangles changed = follow_changes(result.boundary, result.numbering.work2extended, mesh.triangles);
  std::vector<std::uint8_t> keep;
  auto state = result.listed_triangles.begin();
  for (const auto& triangle : mesh.triangles) {
    keep.push_back(*state++ != Listed::loose || others.have(triangle) ? 1 : 0);
  }
  report.triangles_dropped = std::count(keep.begin(), keep.end(), 0);
  for (const Index entry : result.listed_boundary) {
    if (span_of(changed.is_present)[entry] == 0) span_of(keep)[entry] = 0;
  }
  const std::vector<Index> triangle2new = positions_of_kept(keep);
  std::vector<Index> triangle2original = kept_of(triangle2new);
  next.triangles = gather_entries(mesh.triangles, triangle2original);
  for (const auto& [entry, triangle] : changed.changes) {
    const Index kept = span_of(triangle2new)[entry];
    if (kept >= 0) span_of(next.triangles)[kept] = triangle;
  }
  next.triangles.insert(next.triangles.end(), changed.more.begin(), changed.more.end());
  triangle2original.insert(triangle2original.end(), changed.origin.begin(), changed.origin.end());
  next.triangle_tags = gather_entries(mesh.triangle_tags, triangle2original);
  next.triangle_data = take_entries(mesh.triangle_data, triangle2original);
  next.required_triangles = mesh.required_triangles;
  for (Index& triangle : next.required_triangles) triangle = span_of(triangle2new)[triangle];
  return triangle2original;
}

/// The required tetrahedra of the result: they never left their slots, and compaction kept the order of the slots.
std::vector<Index> new_required_tets(const std::vector<Index>& required_slots, const std::vector<Index>& slot_of_tet) {
  std::vector<Index> tets;
  for (const Index slot : required_slots) {
    const auto at = std::lower_bound(slot_of_tet.begin(), slot_of_tet.end(), slot);
    tets.push_back(to_index(at - slot_of_tet.begin()));
  }
  return tets;
}

/// Moves the parts that an optimization leaves as they are from `mesh` to its result.
void move_unchanged(TetMesh& mesh, TetMesh& result) noexcept {
  result.others.swap(mesh.others);
  result.groups.swap(mesh.groups);
  result.periodic.swap(mesh.periodic);
  result.deck.swap(mesh.deck);
  result.point_tags_name.swap(mesh.point_tags_name);
  result.cell_tags_name.swap(mesh.cell_tags_name);
  result.dialect.swap(mesh.dialect);
  result.second_order = mesh.second_order;
  result.listed_inside_out = mesh.listed_inside_out;
}

}  // namespace

VertexNumbering number_vertices(std::vector<Index> vertex2original, std::size_t originals) {
  VertexNumbering numbering;
  numbering.work2extended = std::move(vertex2original);
  std::vector<std::uint8_t> keep(originals, 0);
  for (Index& v : numbering.work2extended) {
    if (v == kInserted) {
      v = to_index(keep.size());
      keep.push_back(1);
    } else if (v != kRemoved) {
      span_of(keep)[v] = 1;
    }
  }
  numbering.has_removed = std::find(keep.begin(), keep.end(), 0) != keep.end();
  numbering.extended2new = positions_of_kept(keep);
  if (!numbering.has_removed && keep.size() == originals) return numbering;
  for (std::size_t v = 0; v < keep.size(); ++v) {
    if (keep[v] != 0) numbering.new2original.push_back(v < originals ? to_index(v) : -1);
  }
  return numbering;
}

std::vector<Index> VertexNumbering::work2new() const {
  std::vector<Index> ids = work2extended;
  for (Index& v : ids) v = v == kRemoved ? v : span_of(extended2new)[v];
  return ids;
}

std::vector<int> regions_of(const std::vector<Index>& tet2original, const TetMesh& mesh) {
  return gather_entries(mesh.tet_tags, tet2original);
}

void replace_mesh(TetMesh& mesh, HostResult result, const ExportRules& rules, Report& report) {
  VertexNumbering& numbering = result.numbering;
  TetMesh next;
  next.points = extended_points(mesh.points, result.points, numbering, result.scale);
  if (!result.is_manifold) refuse_overlaps(result, next.points, rules.options.threads);
  next.point_tags = mesh.point_tags;
  next.point_tags.resize(next.points.size(), 0);
  next.deck_nodes = mesh.deck_nodes;
  if (!mesh.deck_nodes.empty()) next.deck_nodes.resize(next.points.size(), 0);
  transfer_data(mesh, result, rules, next, report);
  carry_sets(mesh, result, rules, report, next);
  next.tet_tags = regions_of(result.tet2original, mesh);
  next.required_tets = new_required_tets(result.required_slots, result.slot_of_tet);
  next.corners = mesh.corners;
  next.required_vertices = mesh.required_vertices;

  const OtherElements others(mesh);
  std::vector<Index> triangle2original = replace_triangles(mesh, result, others, next, report);

  const std::vector<Index> edge2new = positions_of_kept(lasting_edges(mesh, result.tets, others));
  std::vector<Index> edge2original = kept_of(edge2new);
  next.edges = mesh.edges;
  next.edge_tags = mesh.edge_tags;
  next.edge_data = take_entries(mesh.edge_data, edge2original);
  next.ridges = mesh.ridges;
  next.required_edges = mesh.required_edges;
  report.edges_dropped = keep_edges(next, edge2new);

  report.triangle2original = empty_if_identity(std::move(triangle2original), mesh.triangles.size());
  report.edge2original = empty_if_identity(std::move(edge2original), mesh.edges.size());
  report.vertex2original = std::move(numbering.new2original);
  report.tet2original = std::move(result.tet2original);

  // From here on nothing can fail.
  next.tets.swap(result.tets);
  move_unchanged(mesh, next);
  if (numbering.has_removed) keep_vertices(next, numbering.extended2new);
  static_assert(std::is_nothrow_move_assignable_v<TetMesh>);
  mesh = std::move(next);
}

}  // namespace tetune
