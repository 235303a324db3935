// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <variant>

#include "boundary/sliding/reference_surface.hpp"
#include "driver/move_job.hpp"
#include "energy/ring.hpp"
#include "mesh/transfer/floating_data.hpp"
#include "phases/tuning.hpp"
#include "tetune/optimize.hpp"

namespace tetune {
namespace {

std::size_t bytes_of(const std::vector<DataArray>& data) {
  std::size_t bytes = 0;
  for (const DataArray& array : data) {
    bytes += std::visit([](const auto& v) { return v.size() * sizeof v[0]; }, array.values);
  }
  return bytes;
}

/// The joint rings of linked vertices, and the arrays that find them. A vertex of a face has a ring of about ten faces.
std::size_t periodic_bytes(const TetMesh& mesh) {
  std::size_t pairs = 0;
  for (const PeriodicLink& link : mesh.periodic) pairs += link.pairs.size();
  return 2 * 10 * (3 * sizeof(Point) + 2 * sizeof(LinkFace)) * pairs;
}

/// The checked surface of a bound on the deviation, and the edited one.
std::size_t checked_surface_bytes(const TetMesh& mesh, const Options& options) {
  if (!has_deviation_bound(options)) return 0;
  const std::size_t edited = edits_surface(options) ? sizeof(Point) + 1 : 0;
  return (sizeof(Point) + sizeof(SurfacePoint) + edited) * mesh.points.size();
}

/// The copy of the mesh on the host that restarts work on.
std::size_t restart_bytes(const TetMesh& mesh, const Options& options) {
  const bool restarts = improves_worst(options) && restart_rounds(options, double(mesh.tets.size())) > 0;
  return restarts ? 52 * mesh.tets.size() + 140 * mesh.points.size() + checked_surface_bytes(mesh, options) : 0;
}

/// Floating-point components of data of the vertices, each of which a conservative transfer projects.
std::size_t projected_components(const TetMesh& mesh) {
  std::size_t components = 0;
  for (const DataArray& array : mesh.point_data) {
    if (is_floating(array)) components += std::size_t(std::max(0, array.components));
  }
  return components;
}

/// The copy of the input that places are found in; and the overlaps of tetrahedra, of which there are up to twice as
/// many where a curved surface slides.
std::size_t transfer_bytes(const TetMesh& mesh, const Options& options) {
  if (options.data == DataTransfer::carry) return 0;
  const bool has_data = !mesh.point_data.empty() || !mesh.tet_data.empty();
  if (options.data == DataTransfer::interpolate || !has_data) return 45 * mesh.tets.size();
  const std::size_t overlaps = options.boundary == Boundary::slide ? 1620 : 960;
  return (overlaps + 48 * projected_components(mesh)) * mesh.tets.size();
}

/// The copies of a curved mesh, and the arrays of its relaxation and of the sheets of its surface.
std::size_t curved_bytes(const TetMesh& mesh, const Options& options) {
  if (mesh.curved_edges.empty()) return 0;
  return options.boundary == Boundary::slide ? 160 * mesh.tets.size() + 520 * mesh.curved_edges.size()
                                             : 75 * mesh.tets.size() + 470 * mesh.curved_edges.size();
}

}  // namespace

std::size_t memory_needed(const TetMesh& mesh, const Options& options) {
  // Bytes, fitted to measured peaks: docs/command-line.md, "Memory".
  std::size_t bytes = (std::size_t{4} << 20) + 930 * mesh.points.size() + 84 * mesh.tets.size() +
                      40 * mesh.triangles.size() + 40 * mesh.edges.size();
  bytes += periodic_bytes(mesh) + restart_bytes(mesh, options);
  for (const ElementBlock& block : mesh.others) bytes += 8 * (block.element2vertex.size() + block.tags.size());
  if (options.boundary == Boundary::slide) bytes += bytes / 4;  // the reference surface
  bytes += checked_surface_bytes(mesh, options);
  if (options.effort == Effort::best) bytes += bytes / 16;  // room for inserted vertices
  bytes += bytes / 32;
  // Two copies of the data exist during export, and a third of vertex data if vertices are inserted or removed.
  bytes += 2 * (bytes_of(mesh.tet_data) + bytes_of(mesh.triangle_data) + bytes_of(mesh.edge_data));
  const bool inserts = edits_vertices(options);
  bytes += (inserts ? 3 : 2) * bytes_of(mesh.point_data);
  for (const ElementBlock& block : mesh.others) bytes += bytes_of(block.data);
  return bytes + transfer_bytes(mesh, options) + curved_bytes(mesh, options);
}

std::size_t memory_needed_to_move(const TetMesh& mesh, std::size_t targets, const Options& options) {
  return memory_needed(mesh, options) + motion_memory(mesh, options) + targets * mesh.points.size() * sizeof(Point3);
}

std::size_t memory_needed_on_device(const TetMesh& mesh, const Options& options) {
  // Bytes, fitted to the peaks of the pool, plus a tenth: docs/benchmarks/gpu-memory.md. The weight of vertices is
  // larger than their own memory, because meshes with many vertices per tetrahedron have much surface.
  const std::size_t vertices = mesh.points.size();
  const std::size_t tets = mesh.tets.size();
  std::size_t loop = 104 * tets + 310 * vertices;
  if (options.boundary == Boundary::slide) loop += 100 * vertices;  // the reference surface
  loop += checked_surface_bytes(mesh, options);
  if (options.effort == Effort::best) loop += loop / 4;  // room for inserted vertices
  const std::size_t load = 70 * tets + 100 * vertices + 24 * mesh.triangles.size();
  // Of small meshes most is the candidates of a batch of proposals, up to 15 MiB where vertices are inserted on the
  // surface.
  const std::size_t candidates = std::size_t{options.effort == Effort::best ? 15U : 4U} << 20;
  const std::size_t bytes = candidates + std::max(loop, load) + 32 * mesh.edges.size() + periodic_bytes(mesh);
  return bytes + bytes / 10;
}

}  // namespace tetune
