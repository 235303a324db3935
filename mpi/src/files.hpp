// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "distribute.hpp"
#include "plex.hpp"
#include "tetune/mesh.hpp"

namespace tetune::mpi {

/// A mesh that was read.
struct Input {
  Pieces pieces;  ///< each entity on one rank
  Totals totals;
  /// On rank 0: elements of other kinds, names and all else that belongs to the file as a whole.
  TetMesh frame;
  std::vector<std::string> warnings;
  /// The labels that the tags of a DMPlex stand for.
  std::optional<Labels> labels;
};

/// Reads a mesh: MEDIT binary files by all ranks in parallel, each a part; a DMPlex in HDF5 by PETSc; others by rank 0.
/// Throws FileError on all ranks.
Input read_pieces(MPI_Comm comm, const std::string& path);

/// Writes the result of collect(): MEDIT binary files by all ranks in parallel, others by rank 0, which gathers the
/// mesh; under a temporary name, renamed once complete. Throws FileError on all ranks; the old file is then untouched.
void write_pieces(MPI_Comm comm, const std::string& path, Pieces pieces, const Totals& totals, TetMesh frame,
                  std::vector<std::string>& warnings);

/// Whether the name is that of a MEDIT binary file.
bool is_meshb(const std::string& path);
/// Whether the name is that of a DMPlex in HDF5 (.h5), or of XDMF that refers to one (.xmf).
bool is_plex_file(const std::string& path);
void check_plex_writable(const std::string& path);
Input read_plex(MPI_Comm comm, const std::string& path);
/// Writes by all ranks in parallel, and renames once complete. Without `labels` the tags become labels.
void write_plex(MPI_Comm comm, const std::string& path, Part part, Totals totals, const std::optional<Labels>& labels,
                std::vector<std::string>& warnings);

/// Whether a file is MEDIT binary that read_meshb() reads: version 2, 3 or 4 in this machine's byte order, without
/// elements of other kinds.
bool is_plain_meshb(const std::string& path);
Input read_meshb(MPI_Comm comm, const std::string& path);
void write_meshb(MPI_Comm comm, const std::string& path, const Pieces& pieces, const Totals& totals);

}  // namespace tetune::mpi
