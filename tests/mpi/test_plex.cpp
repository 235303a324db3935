// SPDX-License-Identifier: Apache-2.0
// tetune::optimize(DM&) keeps the volumes and areas of the sets and labels of a DMPlex. Run by mpiexec; exits with 1
// and names each failure.
#include <petscdmplex.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <tetune/error.hpp>
#include <tetune/mpi.hpp>
#include <utility>
#include <vector>

namespace {

int failures = 0;
void expect(bool ok, const std::string& what) {
  if (ok) return;
  ++failures;
  std::printf("FAILED: %s\n", what.c_str());
}
void check(PetscErrorCode code) { expect(code == 0, "a call of PETSc"); }

double all(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return value;
}

double measure(DM dm, PetscInt point, PetscReal* center) {
  PetscReal size = 0;
  check(DMPlexComputeCellGeometryFVM(dm, point, &size, center, nullptr));
  return static_cast<double>(size);
}

/// The unit cube, with inner vertices displaced, two regions, a patch each side of the boundary, and a label that holds
/// the closure of its faces; distributed.
DM make(PetscInt n) {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  std::vector<PetscReal> points;
  std::vector<PetscInt> cells;
  if (rank == 0) {
    for (PetscInt i = 0; i < (n + 1) * (n + 1) * (n + 1); ++i) {
      const std::array<PetscInt, 3> at{i % (n + 1), i / (n + 1) % (n + 1), i / ((n + 1) * (n + 1))};
      for (std::size_t k = 0; k < 3; ++k) {
        const bool inner = std::all_of(at.begin(), at.end(), [n](PetscInt c) { return c > 0 && c < n; });
        const bool middle = k == 0 && 2 * at[0] == n;  // the interface stays flat
        const double shift =
            inner && !middle ? 0.2 * std::sin(12.9898 * static_cast<double>(3 * i) + static_cast<double>(k)) : 0;
        points.push_back((static_cast<double>(at[k]) + shift) / static_cast<double>(n));
      }
    }
    for (PetscInt cell = 0; cell < n * n * n; ++cell) {
      std::array<int, 3> path{0, 1, 2};
      do {
        std::array<PetscInt, 3> at{cell % n, cell / n % n, cell / (n * n)};
        std::array<PetscInt, 4> tet{};
        const auto vertex = [&] { return (at[2] * (n + 1) + at[1]) * (n + 1) + at[0]; };
        tet[0] = vertex();
        for (std::size_t k = 0; k < 3; ++k) {
          ++at[static_cast<std::size_t>(path[k])];
          tet[k + 1] = vertex();
        }
        if ((path[0] + 1) % 3 == path[1]) std::swap(tet[2], tet[3]);  // as PETSC turns them
        cells.insert(cells.end(), tet.begin(), tet.end());
      } while (std::next_permutation(path.begin(), path.end()));
    }
  }
  DM dm = nullptr;
  check(DMPlexCreateFromCellListPetsc(PETSC_COMM_WORLD, 3, static_cast<PetscInt>(cells.size() / 4),
                                      static_cast<PetscInt>(points.size() / 3), 4, PETSC_TRUE, cells.data(), 3,
                                      points.data(), &dm));
  for (const char* name : {"Cell Sets", "Face Sets", "marker", "my own"}) check(DMCreateLabel(dm, name));
  DMLabel own = nullptr;
  check(DMGetLabel(dm, "my own", &own));
  check(DMLabelSetDefaultValue(own, -4));
  PetscInt begin = 0;
  PetscInt end = 0;
  std::array<PetscReal, 3> x{};
  check(DMPlexGetHeightStratum(dm, 0, &begin, &end));
  for (PetscInt c = begin; c < end; ++c) {
    measure(dm, c, x.data());
    check(DMSetLabelValue(dm, "Cell Sets", c, x[0] < 0.5 ? 1 : 2));
    if (x[2] < 0.5) check(DMSetLabelValue(dm, "my own", c, 7));
    if (x[2] > 0.75) check(DMSetLabelValue(dm, "my own", c, -1));
  }
  check(DMPlexGetHeightStratum(dm, 1, &begin, &end));
  for (PetscInt f = begin; f < end; ++f) {
    PetscInt support = 0;
    check(DMPlexGetSupportSize(dm, f, &support));
    if (support > 1) continue;
    measure(dm, f, x.data());
    for (std::size_t k = 0; k < 3; ++k) {
      if (x[k] < 1e-9) check(DMSetLabelValue(dm, "Face Sets", f, static_cast<PetscInt>(10 + 2 * k)));
      if (x[k] > 1 - 1e-9) check(DMSetLabelValue(dm, "Face Sets", f, static_cast<PetscInt>(11 + 2 * k)));
    }
    check(DMSetLabelValue(dm, "marker", f, 1));
  }
  DMLabel marker = nullptr;
  check(DMGetLabel(dm, "marker", &marker));
  check(DMPlexLabelComplete(dm, marker));
  DM parts = nullptr;
  check(DMPlexDistribute(dm, 0, nullptr, &parts));
  if (parts == nullptr) return dm;
  check(DMDestroy(&dm));
  return parts;
}

/// Measure of what each value of the labels holds, points on several ranks once.
std::map<std::string, double> contents(DM dm) {
  std::map<std::string, double> sums;
  PetscInt begin = 0;
  PetscInt end = 0;
  PetscInt value = 0;
  std::array<PetscReal, 3> x{};
  for (const auto& [name, values] :
       std::map<std::string, std::vector<PetscInt>>{{"Cell Sets", {1, 2}}, {"my own", {7, -1, -4}}}) {
    check(DMPlexGetHeightStratum(dm, 0, &begin, &end));
    for (const PetscInt labeled : values) {
      double sum = 0;
      for (PetscInt c = begin; c < end; ++c) {
        check(DMGetLabelValue(dm, name.c_str(), c, &value));
        if (value == labeled) sum += measure(dm, c, x.data());
      }
      sums[name + " " + std::to_string(labeled)] = all(sum);
    }
  }
  check(DMPlexGetHeightStratum(dm, 1, &begin, &end));
  for (PetscInt labeled = 10; labeled < 16; ++labeled) {
    double sum = 0;
    for (PetscInt f = begin; f < end; ++f) {
      check(DMGetLabelValue(dm, "Face Sets", f, &value));
      if (value == labeled) sum += measure(dm, f, x.data());
    }
    sums["Face Sets " + std::to_string(labeled)] = all(sum);
  }
  IS numbering = nullptr;
  const PetscInt* numbers = nullptr;
  check(DMPlexGetVertexNumbering(dm, &numbering));
  check(ISGetIndices(numbering, &numbers));
  check(DMPlexGetDepthStratum(dm, 0, &begin, &end));
  double marked = 0;
  double owned = 0;
  for (PetscInt v = begin; v < end; ++v) {
    check(DMGetLabelValue(dm, "marker", v, &value));
    if (numbers[v - begin] < 0) continue;
    ++owned;
    if (value == 1) ++marked;
  }
  check(ISRestoreIndices(numbering, &numbers));
  sums["vertices"] = all(owned);
  sums["vertices in marker"] = all(marked);
  return sums;
}

}  // namespace

int main(int argc, char** argv) {
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 1;
  DM dm = make(8);
  const auto before = contents(dm);
  const tetune::DistributedReport report = tetune::optimize(dm);
  expect(report.energy_after < 0.95 * report.energy_before, "the energy fell");
  expect(report.left_frozen == 0, "no vertex was frozen in all rounds");
  const auto compare = [&](double of_inner_surface) {
    const auto after = contents(dm);
    for (const auto& [what, size] : before) {
      const double now = after.at(what);
      const double tolerance = what.starts_with("my own") ? of_inner_surface : 1e-10;
      expect(std::abs(now - size) < tolerance * (1 + size),
             what + ": " + std::to_string(size) + " -> " + std::to_string(now));
    }
  };
  compare(1e-10);
  tetune::Options slides;
  slides.boundary = tetune::Boundary::slide;
  const tetune::DistributedReport slid = tetune::optimize(dm, slides);
  compare(1e-3);  // it is not flat
  check(DMPlexCheckSymmetry(dm));
  check(DMPlexCheckSkeleton(dm, 0));
  check(DMPlexCheckFaces(dm, 0));
  check(DMPlexCheckGeometry(dm));
  check(DMPlexCheckPointSF(dm, nullptr, PETSC_FALSE));
  PetscInt begin = 0;
  PetscInt end = 0;
  check(DMPlexGetHeightStratum(dm, 0, &begin, &end));
  expect(static_cast<std::int64_t>(all(end - begin)) == slid.tets_after, "cells as reported");

  tetune::Options frozen;
  frozen.frozen_regions = {99};
  bool refused = false;
  try {
    tetune::optimize(dm, frozen);
  } catch (const tetune::OptionError& e) {
    refused = std::string(e.what()).find("99") != std::string::npos;
  }
  expect(refused, "a region that is not there is refused");
  check(DMDestroy(&dm));
  failures = static_cast<int>(all(failures));
  check(PetscFinalize());
  return failures == 0 ? 0 : 1;
}
