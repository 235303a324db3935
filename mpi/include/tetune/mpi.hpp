// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <petscdm.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "tetune/optimize.hpp"

/// Meshes that are distributed over the ranks of MPI. Link with tetune::mpi.
namespace tetune {

/// One round over all parts.
struct RoundReport {
  int round = 0;
  std::int64_t tets = 0;          ///< worked on: all in the first round, those near former interfaces in the others
  std::int64_t tets_moved = 0;    ///< to another rank before the round
  std::int64_t cut_vertices = 0;  ///< in several parts, and therefore frozen in this round
  std::int64_t left_frozen = 0;   ///< of them, frozen in all rounds so far
  double optimizer_seconds = 0;   ///< of the slowest rank
  double seconds = 0;
};

/// The result of optimizing a distributed mesh, over all ranks; the same on every rank. Members as in Report.
struct DistributedReport : OperationCounts {
  int ranks = 0;
  std::int64_t tets_before = 0, tets_after = 0;
  double energy_before = 0, energy_after = 0;
  std::vector<RoundReport> rounds;
  std::int64_t left_frozen = 0;  ///< vertices on an interface of parts in every round; 0 except for extreme shapes
  /// With Boundary::slide on several ranks: the largest number of triangles of the input's surface that a rank had.
  std::int64_t surface_triangles = 0;
  double optimizer_seconds = 0;  ///< in optimize() of the parts: the slowest rank of each round
  double seconds = 0;
  StopReason stop = StopReason::converged;
};

/// Improves a mesh that is a DMPlex of tetrahedra, distributed in any way without overlap. Collective on its
/// communicator.
///
/// `dm` is replaced by a new DMPlex, interpolated if the old one was, with its labels, name, fields and discretizations
/// (DMCopyDisc); vertices and cells have new numbers, and some cells are on another rank. Vectors and sections of the
/// old one are not valid for it. Values of labels survive: cells of different values are different regions, labeled
/// faces and edges constrain as listed triangles and edges do (optimize.hpp). A completed label (DMPlexLabelComplete)
/// is completed in the result as well. Options::frozen_regions are values of "Cell Sets", frozen_patches of "Face
/// Sets".
///
/// The result is valid and conforming across ranks, its smallest angle not below that of the input, the shape of its
/// boundary kept as Options::boundary says; with Boundary::slide all rounds move vertices on the surface of the input,
/// and max_deviation bounds how far the result is from it. The result is bit for bit the same for the same parts, for
/// any number of threads. Options::threads 0: those of a node are shared among its ranks. Options::max_growth limits
/// the growth of the whole mesh.
///
/// `stop`, if given, is called on every rank at its safe points (Context::stop); all ranks end when it returns true on
/// one.
///
/// Throws on all ranks alike: MeshError, OptionError (also for Options::untangle, frozen_vertices, only_below and
/// targets, which are for whole meshes), DeviceError, or Error where the optimizer runs out of memory; `dm` is then as
/// it was. Where a call of PETSc fails, or memory runs out during communication, that rank alone throws Error or
/// std::bad_alloc, and the program should end by MPI_Abort.
DistributedReport optimize(DM& dm, const Options& options = {}, const std::function<bool()>& stop = {});

}  // namespace tetune
