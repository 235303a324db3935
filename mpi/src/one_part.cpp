// SPDX-License-Identifier: Apache-2.0
#include "one_part.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "communicate.hpp"
#include "driver/distributed_interface.hpp"
#include "tetune/error.hpp"

namespace tetune::mpi {
namespace {

/// Removes the triangles of list_cut(), which are the last ones of the mesh.
void drop_cut(TetMesh& mesh, std::size_t count) {
  mesh.triangles.resize(mesh.triangles.size() - count);
  mesh.triangle_tags.resize(mesh.triangles.size());
  mesh.required_triangles.resize(mesh.required_triangles.size() - count);
}

/// Erases the vertices [first, end) of a mesh before its optimization, which were appended to it.
void drop_appended(TetMesh& mesh, std::vector<Index>& vertex2original, std::size_t first, std::size_t end) {
  if (first == end) return;
  if (vertex2original.empty()) {
    mesh.points.resize(first);
    mesh.point_tags.resize(first);
    return;
  }
  const auto appended = [&](Index v) { return v >= to_index(first) && v < to_index(end); };
  Marks keep;
  for (const Index v : vertex2original) keep.push_back(appended(v) ? 0 : 1);
  erase_vertices(mesh, keep);
  std::erase_if(vertex2original, appended);
}

std::vector<int> present(const std::vector<int>& wanted, const std::vector<int>& tags) {
  std::vector<int> result;
  for (const int tag : wanted) {
    if (std::find(tags.begin(), tags.end(), tag) != tags.end()) result.push_back(tag);
  }
  return result;
}

/// The ids of the first `entries` of a list after an optimization. The map of a report is empty for all and for none.
std::vector<Id> ids_left(const std::vector<Id>& ids, const std::vector<Index>& new2original, std::size_t entries) {
  const std::vector<Index> original = explicit_map(new2original, entries);
  return gather_entries(ids, std::span(original).first(entries));
}

/// Replaces the ids of a part by those of the entities that the optimization left.
void update_ids(Part& part, const Report& report) {
  if (!report.vertex2original.empty()) {
    part.vertex_id = gather_entries_or(part.vertex_id, report.vertex2original, Id{-1});
    part.vertex_flags = gather_entries_or(part.vertex_flags, report.vertex2original, std::uint8_t{0});
  }
  part.tet_id = gather_entries(part.tet_id, report.tet2original);
  // The map has the triangles of list_cut(), too.
  part.triangle_id = ids_left(part.triangle_id, report.triangle2original, part.mesh.triangles.size());
  part.edge_id = ids_left(part.edge_id, report.edge2original, part.mesh.edges.size());
}

/// Whether a message can have the id, whose numbers have 32 bits.
bool has_32_bits(Id id) { return id < std::numeric_limits<Index>::max(); }

/// The findings of validate() about a part, in the ids of the whole mesh. Ids beyond 32 bits are left out.
ValidationReport findings_of(const Part& part, int threads) {
  ValidationReport report = validate(part.mesh, threads);
  for (Finding& f : report.findings) {
    const std::vector<Id>* ids = f.where == "tetrahedra" ? &part.tet_id
                                 : f.where == "vertices" ? &part.vertex_id
                                                         : nullptr;
    if (ids == nullptr) continue;
    std::erase_if(f.first, [ids](Index i) { return !has_32_bits(item(*ids, i)); });
    for (Index& i : f.first) i = Index(item(*ids, i));
  }
  return report;
}

/// A tetrahedron of a finding, and the place of the first one of that.
struct Offender {
  Id id;
  std::optional<Point3> place;
};

/// A message lists as many ids as one of validate().
constexpr std::size_t kMaxListed = 5;

}  // namespace

Options options_for(const Options& all_options, const TetMesh& mesh) {
  Options options = all_options;
  options.surface_vertices = SurfaceVertices::keep;  // triangles keep their ids
  options.frozen_regions = present(options.frozen_regions, mesh.tet_tags);
  options.frozen_patches = present(options.frozen_patches, mesh.triangle_tags);
  return options;
}

std::string defects_of(const Part& part, int threads, const MessageForm& form, const MeshError& error) {
  const ValidationReport report = findings_of(part, threads);
  return report.ok() ? error.what() : report.message(form.one_based, form.advice);
}

std::string defects_of_all(MPI_Comm comm, const Part& part, int threads, const MessageForm& form,
                           const MeshError& error) {
  const ValidationReport own = findings_of(part, threads);
  ValidationReport all;
  std::int64_t others = std::ssize(own.findings);
  for (const Defect defect : {Defect::inverted_tet, Defect::flat_tet}) {
    Finding sum{defect, 0, {}, "tetrahedra"};
    std::vector<Offender> offenders;
    for (const Finding& f : own.findings) {
      if (f.defect != defect) continue;
      --others;
      sum.count += f.count;
      for (const Index id : f.first) offenders.push_back({id, f.place});
    }
    sum.count = all_reduce(comm, sum.count, MPI_SUM);
    offenders = gather_all(comm, offenders, Datatype(sizeof(Offender)).get());
    if (sum.count == 0) continue;
    std::sort(offenders.begin(), offenders.end(), [](const Offender& a, const Offender& b) { return a.id < b.id; });
    if (offenders.size() > kMaxListed) offenders.resize(kMaxListed);
    for (const Offender& o : offenders) sum.first.push_back(Index(o.id));
    if (!offenders.empty()) sum.place = offenders[0].place;
    all.findings.push_back(std::move(sum));
  }
  if (all_reduce(comm, others, MPI_SUM) > 0 || all.ok()) return error.what();
  return all.message(form.one_based, form.advice);
}

Report optimize_part(Part& part, Marks frozen, const Options& all_options, const Context& context,
                     InputSurface* surface, const MessageForm& form) {
  TetMesh& mesh = part.mesh;
  Options options = options_for(all_options, mesh);
  const std::size_t vertices = mesh.points.size();
  const std::size_t cut_triangles = list_cut(mesh, frozen);
  InputSurface::Piece piece;
  if (surface != nullptr) piece = surface->under(part, options.max_deviation > 0, frozen);
  options.frozen_vertices = std::move(frozen);
  Report report;
  try {
    report = surface != nullptr ? tetune::optimize(mesh, options, context, piece.surface)
                                : tetune::optimize(mesh, options, context);
  } catch (const OverlapError& e) {
    std::vector<Index> tets = e.tets;
    std::erase_if(tets, [&part](Index t) { return !has_32_bits(item(part.tet_id, t)); });
    throw MeshError(OverlapError(translated_ids(tets, part.tet_id)).message(form.one_based));
  } catch (const MeshError& e) {
    drop_cut(mesh, cut_triangles);
    drop_appended(mesh, report.vertex2original, vertices, mesh.points.size());
    throw MeshError(defects_of(part, options.threads, form, e));
  }
  drop_cut(mesh, cut_triangles);
  if (surface != nullptr) {
    surface->write_back(piece);
    drop_appended(mesh, report.vertex2original, vertices, piece.id.size());
  }
  update_ids(part, report);
  return report;
}

}  // namespace tetune::mpi
