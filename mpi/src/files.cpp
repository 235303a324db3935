// SPDX-License-Identifier: Apache-2.0
#include "files.hpp"

#include <set>
#include <utility>

#include "io/medit/medit_codec.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune::mpi {
namespace {

/// Refuses meshes with data or in a deck, which are not sent between ranks: no output is better than one without them.
void refuse_data(const std::string& path, const TetMesh& mesh) {
  if (!mesh.periodic.empty()) {
    throw FileError(path + ": has periodic links, which a distributed mesh does not carry; optimize it on one machine");
  }
  if (!mesh.curved_edges.empty()) {
    throw FileError(path + ": has curved edges, which a distributed mesh does not carry; optimize it on one machine");
  }
  if (mesh.deck != nullptr) {
    throw FileError(path +
                    ": is a deck, which a distributed mesh does not carry; optimize it on one machine, or convert " +
                    "its mesh to .meshb");
  }
  for (const auto* data : {&mesh.point_data, &mesh.tet_data, &mesh.triangle_data, &mesh.edge_data}) {
    if (data->empty()) continue;
    throw FileError(
        path + ": has the data \"" + data->front().name +
        "\", which a distributed mesh does not carry; optimize it on one machine, or write it without data");
  }
}

template <std::size_t N>
std::vector<Element<N>> elements(std::vector<std::array<Index, N>>& list, std::vector<int>& tags,
                                 const std::vector<Index>& required, const std::vector<Index>& ridges) {
  std::vector<Element<N>> result(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    result[i] = {Id(i), {}, tags[i], 0};
    for (std::size_t k = 0; k < N; ++k) result[i].v[k] = list[i][k];
  }
  for (const Index i : required) item(result, i).flags |= kRequired;
  for (const Index i : ridges) item(result, i).flags |= kRidge;
  list = {};
  tags = {};
  return result;
}

/// Erases arrays that readers make of numbers in files, by which writers restore them: a distributed mesh does not
/// carry them.
void erase_numbers_of_files(const std::string& path, TetMesh& mesh, std::vector<std::string>& warnings) {
  std::set<std::string> erased;
  for (auto* data : {&mesh.point_data, &mesh.tet_data, &mesh.triangle_data, &mesh.edge_data}) {
    std::erase_if(*data, [&erased](const DataArray& array) {
      const bool is_of_file = array.name.starts_with("gmsh:") || array.name.starts_with("netgen:");
      if (is_of_file) erased.insert(array.name);
      return is_of_file;
    });
  }
  for (const std::string& name : erased) warnings.push_back(path + ": the numbers " + name + " are not kept");
}

Input entities_of(TetMesh mesh) {
  Input input;
  input.totals = {std::ssize(mesh.points), std::ssize(mesh.tets), std::ssize(mesh.triangles), std::ssize(mesh.edges)};
  auto& vertices = input.pieces.vertices;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    vertices.push_back({Id(v), mesh.points[v], mesh.point_tags[v], 0});
  }
  for (const Index v : mesh.corners) item(vertices, v).flags |= kCorner;
  for (const Index v : mesh.required_vertices) item(vertices, v).flags |= kRequired;
  for (const ElementBlock& block : mesh.others) {
    for (const Index v : block.element2vertex) item(vertices, v).flags |= kHeld;
  }
  mesh.points = {};
  mesh.point_tags = {};
  input.pieces.cells = elements(mesh.tets, mesh.tet_tags, mesh.required_tets, {});
  input.pieces.sides = elements(mesh.triangles, mesh.triangle_tags, mesh.required_triangles, {});
  input.pieces.lines = elements(mesh.edges, mesh.edge_tags, mesh.required_edges, mesh.ridges);
  for (auto* list : {&mesh.corners, &mesh.required_vertices, &mesh.required_tets, &mesh.required_triangles,
                     &mesh.required_edges, &mesh.ridges}) {
    list->clear();
  }
  input.frame = std::move(mesh);
  return input;
}

}  // namespace

Input read_pieces(MPI_Comm comm, const std::string& path) {
  if (is_plex_file(path)) return read_plex(comm, path);
  int plain = 0;
  if (rank_of(comm) == 0) plain = is_plain_meshb(path) ? 1 : 0;
  MPI_Bcast(&plain, 1, MPI_INT, 0, comm);
  if (plain != 0) return read_meshb(comm, path);
  Input input;
  collective_try(comm, [&] {
    if (rank_of(comm) != 0) return;
    std::vector<std::string> warnings;
    TetMesh mesh = read_mesh(path, &warnings);
    erase_numbers_of_files(path, mesh, warnings);
    refuse_data(path, mesh);
    input = entities_of(std::move(mesh));
    input.warnings = std::move(warnings);
  });
  std::array<Id, 4> counts{input.totals.vertices, input.totals.cells, input.totals.sides, input.totals.lines};
  MPI_Bcast(counts.data(), 4, MPI_INT64_T, 0, comm);
  input.totals = {counts[0], counts[1], counts[2], counts[3]};
  return input;
}

void write_pieces(MPI_Comm comm, const std::string& path, Pieces pieces, const Totals& totals, TetMesh frame,
                  std::vector<std::string>& warnings) {
  int others = frame.others.empty() ? 0 : 1;
  MPI_Bcast(&others, 1, MPI_INT, 0, comm);
  int turned = frame.listed_inside_out ? 1 : 0;
  MPI_Bcast(&turned, 1, MPI_INT, 0, comm);
  if (is_meshb(path) && others == 0) {
    if (turned != 0) {
      for (Cell& c : pieces.cells) std::swap(c.v[2], c.v[3]);
    }
    std::vector<std::string> losses;
    if (rank_of(comm) == 0) warn_of_losses_in_medit(frame, {0, &losses});
    for (const std::string& loss : losses) warnings.push_back(path + ": " + loss);
    write_meshb(comm, path, pieces, totals);
    return;
  }
  const auto gather = [comm](auto& items) { items = Route(comm, std::vector<int>(items.size(), 0)).send(items); };
  gather(pieces.vertices);
  gather(pieces.cells);
  gather(pieces.sides);
  gather(pieces.lines);
  collective_try(comm, [&] {
    if (rank_of(comm) != 0) return;
    TetMesh mesh = assemble(std::move(pieces)).mesh;
    mesh.others = std::move(frame.others);
    mesh.groups = std::move(frame.groups);
    mesh.point_tags_name = std::move(frame.point_tags_name);
    mesh.cell_tags_name = std::move(frame.cell_tags_name);
    mesh.dialect = std::move(frame.dialect);
    mesh.second_order = frame.second_order;
    mesh.listed_inside_out = frame.listed_inside_out;
    write_mesh(path, mesh, 0, &warnings);
  });
}

}  // namespace tetune::mpi
