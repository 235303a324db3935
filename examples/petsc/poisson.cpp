// SPDX-License-Identifier: Apache-2.0
// A distributed mesh in a solver's memory, optimized in place: Poisson's equation before and after.
//   mpiexec -n 2 example_poisson [-n 24] [PETSc's options]
#include <petscdmplex.h>
#include <petscds.h>
#include <petscsnes.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <numeric>
#include <tetune/mpi.hpp>
#include <vector>

namespace {

/// -laplace u = 1, u = 0 on the boundary.
void load(PetscInt, PetscInt, PetscInt, const PetscInt[], const PetscInt[], const PetscScalar[], const PetscScalar[],
          const PetscScalar[], const PetscInt[], const PetscInt[], const PetscScalar[], const PetscScalar[],
          const PetscScalar[], PetscReal, const PetscReal[], PetscInt, const PetscScalar[], PetscScalar f0[]) {
  f0[0] = -1;
}
void flux(PetscInt dim, PetscInt, PetscInt, const PetscInt[], const PetscInt[], const PetscScalar[],
          const PetscScalar[], const PetscScalar u_x[], const PetscInt[], const PetscInt[], const PetscScalar[],
          const PetscScalar[], const PetscScalar[], PetscReal, const PetscReal[], PetscInt, const PetscScalar[],
          PetscScalar f1[]) {
  for (PetscInt d = 0; d < dim; ++d) f1[d] = u_x[d];
}
void laplace(PetscInt dim, PetscInt, PetscInt, const PetscInt[], const PetscInt[], const PetscScalar[],
             const PetscScalar[], const PetscScalar[], const PetscInt[], const PetscInt[], const PetscScalar[],
             const PetscScalar[], const PetscScalar[], PetscReal, PetscReal, const PetscReal[], PetscInt,
             const PetscScalar[], PetscScalar g3[]) {
  for (PetscInt d = 0; d < dim; ++d) g3[d * dim + d] = 1;
}
PetscErrorCode zero(PetscInt, PetscReal, const PetscReal[], PetscInt, PetscScalar* u, void*) {
  u[0] = 0;
  return 0;
}

/// A unit cube of n^3 cells of six tetrahedra with displaced vertices, on rank 0, then distributed.
PetscErrorCode make_mesh(MPI_Comm comm, PetscInt n, DM* dm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::vector<PetscReal> points;
  std::vector<PetscInt> cells;
  if (rank == 0) {
    std::uint64_t state = 1;
    const auto random = [&state] {  // in [-1, 1]
      state = state * 6364136223846793005U + 1442695040888963407U;
      return static_cast<double>(state >> 11U) / 4503599627370496.0 - 1;
    };
    for (PetscInt i = 0; i < (n + 1) * (n + 1) * (n + 1); ++i) {
      for (PetscInt c : {i % (n + 1), i / (n + 1) % (n + 1), i / ((n + 1) * (n + 1))}) {
        const bool inner = c > 0 && c < n;
        points.push_back((static_cast<double>(c) + (inner ? 0.22 * random() : 0)) / static_cast<double>(n));
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
        // An even permutation of the axes makes a positive tetrahedron, where PETSC's are negative.
        const bool even = (path[0] + 1) % 3 == path[1];
        if (even) std::swap(tet[2], tet[3]);
        cells.insert(cells.end(), tet.begin(), tet.end());
      } while (std::next_permutation(path.begin(), path.end()));
    }
  }
  DM whole = nullptr;
  PetscCall(DMPlexCreateFromCellListPetsc(comm, 3, static_cast<PetscInt>(cells.size() / 4),
                                          static_cast<PetscInt>(points.size() / 3), 4, PETSC_TRUE, cells.data(), 3,
                                          points.data(), &whole));
  DMLabel boundary = nullptr;
  PetscCall(DMCreateLabel(whole, "boundary"));
  PetscCall(DMGetLabel(whole, "boundary", &boundary));
  PetscCall(DMPlexMarkBoundaryFaces(whole, 1, boundary));
  PetscCall(DMPlexLabelComplete(whole, boundary));
  PetscCall(DMPlexDistribute(whole, 0, nullptr, dm));
  if (*dm == nullptr) {
    *dm = whole;
  } else {
    PetscCall(DMDestroy(&whole));
  }
  return 0;
}

/// Sets up linear elements.
PetscErrorCode discretize(DM dm) {
  PetscFE fe = nullptr;
  PetscCall(PetscFECreateLagrange(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), 3, 1, PETSC_TRUE, 1,
                                  PETSC_DETERMINE, &fe));
  PetscCall(DMSetField(dm, 0, nullptr, reinterpret_cast<PetscObject>(fe)));
  PetscCall(PetscFEDestroy(&fe));
  PetscCall(DMCreateDS(dm));
  return 0;
}

PetscErrorCode solve(DM dm, const char* when) {
  PetscDS ds = nullptr;
  DMLabel boundary = nullptr;
  PetscCall(DMGetDS(dm, &ds));
  PetscCall(PetscDSSetResidual(ds, 0, load, flux));
  PetscCall(PetscDSSetJacobian(ds, 0, 0, nullptr, nullptr, nullptr, laplace));
  PetscCall(DMGetLabel(dm, "boundary", &boundary));
  const PetscInt value = 1;
  PetscCall(DMAddBoundary(dm, DM_BC_ESSENTIAL, "wall", boundary, 1, &value, 0, 0, nullptr,
                          reinterpret_cast<void (*)()>(zero), nullptr, nullptr, nullptr));
  SNES snes = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  Vec u = nullptr;
  PetscCall(SNESCreate(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), &snes));
  PetscCall(SNESSetDM(snes, dm));
  PetscCall(DMPlexSetSNESLocalFEM(dm, nullptr, nullptr, nullptr));
  PetscCall(SNESSetType(snes, SNESKSPONLY));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  PetscCall(SNESSetFromOptions(snes));
  PetscCall(DMCreateGlobalVector(dm, &u));
  PetscCall(SNESSolve(snes, nullptr, u));
  PetscInt iterations = 0;
  PetscReal most = 0;
  PetscCall(SNESGetLinearSolveIterations(snes, &iterations));
  PetscCall(VecMax(u, nullptr, &most));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                        "%s: %d iterations of conjugate gradients, largest value %.5f (exact 0.05621)\n", when,
                        static_cast<int>(iterations), static_cast<double>(most)));
  PetscCall(VecDestroy(&u));
  PetscCall(SNESDestroy(&snes));
  return 0;
}

PetscErrorCode run() {
  PetscInt n = 24;
  PetscCall(PetscOptionsGetInt(nullptr, nullptr, "-n", &n, nullptr));
  DM dm = nullptr;
  PetscCall(make_mesh(PETSC_COMM_WORLD, n, &dm));
  DM before = nullptr;
  PetscCall(DMClone(dm, &before));
  PetscCall(discretize(before));
  PetscCall(solve(before, "before"));
  PetscCall(DMDestroy(&before));

  const tetune::DistributedReport report = tetune::optimize(dm);
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "optimized on %d ranks: energy %.0f -> %.0f, %d rounds, %.2f s\n",
                        report.ranks, report.energy_before, report.energy_after, static_cast<int>(report.rounds.size()),
                        report.seconds));
  PetscCall(discretize(dm));
  PetscCall(solve(dm, "after"));
  PetscCall(DMDestroy(&dm));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  try {
    PetscCall(run());
  } catch (const std::exception& e) {
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s\n", e.what()));
    return 1;
  }
  PetscCall(PetscFinalize());
  return 0;
}
