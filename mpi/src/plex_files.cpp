// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <petscviewer.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <utility>

#include "files.hpp"
#include "shared_temporary.hpp"
#include "star_forest.hpp"
#include "system/file.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"
#include "write_watch.hpp"

/// DMPlex in HDF5, as DMView() writes it and DMLoad() reads it, and XDMF beside it.
namespace tetune::mpi {
namespace {

/// Reverses cells: PETSc's tetrahedra have the opposite orientation.
template <class Cells>
void reverse(Cells& cells) {
  for (auto& tet : cells) std::swap(tet[2], tet[3]);
}

class Viewer {
 public:
  Viewer(MPI_Comm comm, PetscFileMode mode) {
    check_petsc(PetscViewerCreate(comm, &viewer_));
    check_petsc(PetscViewerSetType(viewer_, PETSCVIEWERHDF5));
    check_petsc(PetscViewerFileSetMode(viewer_, mode));
  }
  ~Viewer() { PetscViewerDestroy(&viewer_); }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;
  PetscViewer get() const { return viewer_; }
  PetscErrorCode open(const std::string& path) { return PetscViewerFileSetName(viewer_, path.c_str()); }
  PetscErrorCode close() { return PetscViewerDestroy(&viewer_); }

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

/// Writes the tags of the cells of all ranks as a data set.
void write_tags(MPI_Comm comm, const std::vector<int>& tags, const Viewer& viewer, const WriteWatch& watch) {
  Vec values = nullptr;
  check_petsc(VecCreateMPI(comm, petsc_size(tags), PETSC_DETERMINE, &values));
  check_petsc(PetscObjectSetName(reinterpret_cast<PetscObject>(values), "tags"));
  PetscScalar* to = nullptr;
  check_petsc(VecGetArrayWrite(values, &to));
  std::copy(tags.begin(), tags.end(), to);
  check_petsc(VecRestoreArrayWrite(values, &to));
  watch.check(VecView(values, viewer.get()));
  check_petsc(VecDestroy(&values));
}

/// Gives the tag -1 another number: -1 is the default value of a label, and DMLoad() drops points that have it.
void renumber_default(MPI_Comm comm, const std::string& path, TetMesh& mesh, std::vector<std::string>& warnings) {
  const std::array<std::vector<int>*, 4> tags{&mesh.point_tags, &mesh.edge_tags, &mesh.triangle_tags, &mesh.tet_tags};
  for (std::size_t d = 0; d < 4; ++d) {
    const std::set<int> here(tags[d]->begin(), tags[d]->end());
    const auto all = gather_all(comm, std::vector<int>(here.begin(), here.end()), MPI_INT);
    const std::set<int> used(all.begin(), all.end());
    if (used.count(-1) == 0) continue;
    int number = 1;
    while (used.count(number) > 0) ++number;
    std::replace(tags[d]->begin(), tags[d]->end(), -1, number);
    warnings.push_back(path + ": a label of a DMPlex cannot have the value -1: the tag -1 is " +
                       std::to_string(number) + " in \"" + kSets[d] + "\"");
  }
}

/// The XDMF beside an HDF5 file, which has its name when both are complete.
class XdmfHeader {
 public:
  XdmfHeader(MPI_Comm comm, std::string path, std::string h5)
      : comm_(comm), path_(std::move(path)), h5_(std::move(h5)) {}

  /// `cells`: of this rank; `vertices`: of all. Does nothing where the HDF5 file alone is wanted. Throws FileError on
  /// all ranks.
  void write(Id cells, Id vertices) {
    const Id all = all_reduce(comm_, cells, MPI_SUM);
    collective_try(comm_, [&] {
      if (rank_of(comm_) == 0 && path_ != h5_) file_.emplace(path_).write(text(all, vertices));
    });
  }
  /// Throws FileError on all ranks.
  void commit() {
    collective_try(comm_, [this] {
      if (!file_) return;
      try {
        file_->commit();
      } catch (const FileError& e) {
        throw FileError(std::string(e.what()) + "; " + h5_ + " was written");
      }
    });
  }

 private:
  std::string text(Id cells, Id vertices) const {
    return fmt::format(
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
        cells, vertices, std::filesystem::path(h5_).filename().string(), sizeof(PetscInt));
  }

  MPI_Comm comm_;
  std::string path_, h5_;
  std::optional<FileWriter> file_;  ///< on rank 0
};

}  // namespace

bool is_plex_file(const std::string& path) {
  const std::string ending = ending_of(path);
  return ending == ".h5" || ending == ".xmf";
}

void check_plex_writable(const std::string& path) {
  require_hdf5(path);
  if (path.find_first_of("&<>:") != std::string::npos && ending_of(path) == ".xmf") {
    throw FileError(path + ": XDMF refers to the .h5 beside it, whose name cannot have any of & < > :");
  }
  const TemporaryFile temporary(path);
  if (!std::ofstream(temporary.name())) throw FileError(path + ": cannot be written: " + std::strerror(errno));
}

Input read_plex(MPI_Comm comm, const std::string& path) {
  collective_try(comm, [&] {
    require_hdf5(path);
    if (ending_of(path) != ".h5") {
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
    Viewer viewer(comm, FILE_MODE_READ);
    check_petsc(viewer.open(path));
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
  const auto untagged = std::count(mesh.triangle_tags.begin(), mesh.triangle_tags.end(), 0) +
                        std::count(mesh.edge_tags.begin(), mesh.edge_tags.end(), 0);
  if (all_reduce(comm, Id(untagged), MPI_SUM) > 0) {
    warnings.push_back(path + ": a DMPlex lists no triangles and edges with tag 0");
  }
  if (!labels) renumber_default(comm, path, part.mesh, warnings);
  const std::string h5 = with_ending(path, ".h5");
  SharedTemporary temporary(comm, h5);
  XdmfHeader header(comm, path, h5);
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
    header.write(std::ssize(tags), vertices);
    const WriteWatch watch(comm, h5, temporary.name());
    Viewer viewer(comm, FILE_MODE_WRITE);
    watch.check(viewer.open(temporary.name()));
    watch.check(DMView(dm, viewer.get()));
    write_tags(comm, tags, viewer, watch);
    watch.check(viewer.close());
    check_petsc(DMDestroy(&dm));
  });
  if (vertices < totals.vertices) {
    warnings.push_back(path + ": " + std::to_string(totals.vertices - vertices) +
                       " vertices of no tetrahedron are lost in a DMPlex");
  }
  temporary.replace();
  header.commit();
}

}  // namespace tetune::mpi
