// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <petscviewer.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "files.hpp"
#include "shared_temporary.hpp"
#include "star_forest.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

/// DMPlex in HDF5, as DMView() writes it and DMLoad() reads it, and XDMF beside it.
namespace tetune::mpi {
namespace {

/// PETSc's tetrahedra have the opposite orientation.
template <class Cells>
void reverse(Cells& cells) {
  for (auto& tet : cells) std::swap(tet[2], tet[3]);
}

class Viewer {
 public:
  Viewer(MPI_Comm comm, const std::string& path, PetscFileMode mode) {
    check_petsc(PetscViewerCreate(comm, &viewer_));
    check_petsc(PetscViewerSetType(viewer_, PETSCVIEWERHDF5));
    check_petsc(PetscViewerFileSetMode(viewer_, mode));
    check_petsc(PetscViewerFileSetName(viewer_, path.c_str()));
  }
  ~Viewer() { PetscViewerDestroy(&viewer_); }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;
  PetscViewer get() const { return viewer_; }
  void close() { check_petsc(PetscViewerDestroy(&viewer_)); }

 private:
  PetscViewer viewer_ = nullptr;
};

/// Names the file in errors of HDF5 and PETSc, which occur on all ranks.
template <class F>
void with_file_name(const std::string& path, const char* what, F work) {
  try {
    work();
  } catch (const FileError&) {
    throw;
  } catch (const MeshError& e) {
    throw FileError(path + ": " + e.what());
  } catch (const Error& e) {
    throw FileError(path + ": " + what + " (" + e.what() + ")");
  }
}

void require_hdf5(const std::string& path) {
#ifndef PETSC_HAVE_HDF5
  throw FileError(path + ": this PETSc was built without HDF5; give another format");
#else
  (void)path;
#endif
}

std::filesystem::path with_ending(const std::string& path, const char* ending) {
  return std::filesystem::path(path).replace_extension(ending);
}

/// Writes the tags of the cells of all ranks as a data set.
void write_tags(MPI_Comm comm, const std::vector<int>& tags, const Viewer& viewer) {
  Vec values = nullptr;
  check_petsc(VecCreateMPI(comm, petsc_size(tags), PETSC_DETERMINE, &values));
  check_petsc(PetscObjectSetName(reinterpret_cast<PetscObject>(values), "tags"));
  PetscScalar* to = nullptr;
  check_petsc(VecGetArrayWrite(values, &to));
  std::copy(tags.begin(), tags.end(), to);
  check_petsc(VecRestoreArrayWrite(values, &to));
  check_petsc(VecView(values, viewer.get()));
  check_petsc(VecDestroy(&values));
}

void write_xdmf(const std::string& path, const std::string& h5, Id cells, Id vertices) {
  const std::string text = fmt::format(
      R"(<?xml version="1.0"?>
<Xdmf Version="3.0">
  <Domain>
    <Grid Name="mesh" GridType="Uniform">
      <Topology TopologyType="Tetrahedron" NumberOfElements="{0}">
        <DataItem Dimensions="{0} 4" NumberType="Int" Precision="{3}" Format="HDF">{2}:/viz/topology/cells</DataItem>
      </Topology>
      <Geometry GeometryType="XYZ">
        <DataItem Dimensions="{1} 3" NumberType="Float" Precision="8" Format="HDF">{2}:/geometry/vertices</DataItem>
      </Geometry>
      <Attribute Name="tags" AttributeType="Scalar" Center="Cell">
        <DataItem Dimensions="{0}" NumberType="Float" Precision="8" Format="HDF">{2}:/tags</DataItem>
      </Attribute>
    </Grid>
  </Domain>
</Xdmf>
)",
      cells, vertices, h5, sizeof(PetscInt));
  write_text(path, text);
}

}  // namespace

bool is_plex_file(const std::string& path) {
  const auto ending = std::filesystem::path(path).extension();
  return ending == ".h5" || ending == ".xmf";
}

void check_plex_writable(const std::string& path) {
  require_hdf5(path);
  if (path.find_first_of("&<>:") != std::string::npos && std::filesystem::path(path).extension() == ".xmf") {
    throw FileError(path + ": XDMF refers to the .h5 beside it, whose name cannot have any of & < > :");
  }
  const TemporaryFile temporary(path);
  if (!std::ofstream(temporary.name())) throw FileError(path + ": cannot be written: " + std::strerror(errno));
}

Input read_plex(MPI_Comm comm, const std::string& path) {
  collective_try(comm, [&] {
    require_hdf5(path);
    if (std::filesystem::path(path).extension() != ".h5") {
      throw FileError(path + ": XDMF is written, not read; give the .h5 beside it");
    }
    if (rank_of(comm) != 0) return;
    std::ifstream file(path, std::ios::binary);
    if (!file) throw FileError(path + ": cannot be opened: " + std::strerror(errno));
    std::array<char, 8> begin{};
    file.read(begin.data(), begin.size());
    if (std::memcmp(begin.data(), "\x89HDF\r\n\x1a\n", 8) != 0) throw FileError(path + ": is not an HDF5 file");
  });
  Input input;
  DM dm = nullptr;
  with_file_name(path, "no DMPlex could be loaded, as DMView() writes one", [&] {
    Viewer viewer(comm, path, FILE_MODE_READ);
    check_petsc(DMCreate(comm, &dm));
    check_petsc(DMSetType(dm, DMPLEX));
    check_petsc(PetscObjectSetName(reinterpret_cast<PetscObject>(dm), "mesh"));
    check_petsc(DMLoad(dm, viewer.get()));
  });
  Part part;
  with_file_name(path, "this DMPlex cannot be read", [&] { part = part_of(dm, input.totals, input.labels.emplace()); });
  check_petsc(DMDestroy(&dm));
  reverse(part.mesh.tets);
  input.pieces = address(part, std::vector<int>(part.mesh.tets.size(), 0), 0).pieces;
  return input;
}

void write_plex(MPI_Comm comm, const std::string& path, Part part, Totals totals, const std::optional<Labels>& labels,
                std::vector<std::string>& warnings) {
  const TetMesh& mesh = part.mesh;
  const std::size_t dropped = mesh.corners.size() + mesh.ridges.size() + mesh.required_vertices.size() +
                              mesh.required_edges.size() + mesh.required_triangles.size() + mesh.required_tets.size();
  if (all_reduce(comm, Id(dropped), MPI_SUM) > 0) {
    warnings.push_back(path + ": a DMPlex cannot hold corners, ridges and required entities");
  }
  const std::string h5 = with_ending(path, ".h5");
  SharedTemporary temporary(comm, h5);
  const std::vector<int> tags = mesh.tet_tags;
  reverse(part.mesh.tets);
  const Labels all = labels ? *labels : labels_of(comm, part);
  PetscInt vertices = 0;
  with_file_name(h5, "could not be written", [&] {
    DM dm = plex_of(comm, std::move(part), totals, all);
    check_petsc(PetscObjectSetName(reinterpret_cast<PetscObject>(dm), "mesh"));
    Vec points = nullptr;
    check_petsc(DMGetCoordinates(dm, &points));
    check_petsc(VecGetSize(points, &vertices));
    vertices /= 3;
    Viewer viewer(comm, temporary.name(), FILE_MODE_WRITE);
    check_petsc(DMView(dm, viewer.get()));
    write_tags(comm, tags, viewer);
    viewer.close();
    check_petsc(DMDestroy(&dm));
  });
  if (vertices < totals.vertices) {
    warnings.push_back(path + ": " + std::to_string(totals.vertices - vertices) +
                       " vertices of no tetrahedron are lost in a DMPlex");
  }
  const Id cells = all_reduce(comm, std::ssize(tags), MPI_SUM);
  temporary.replace();
  collective_try(comm, [&] {
    if (rank_of(comm) == 0 && h5 != path) write_xdmf(path, std::filesystem::path(h5).filename(), cells, vertices);
  });
}

}  // namespace tetune::mpi
