// SPDX-License-Identifier: Apache-2.0
#include "star_forest.hpp"

#include <limits>
#include <string>

#include "tetune/error.hpp"

namespace tetune::mpi {

void check_petsc(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw Error("PETSc error " + std::to_string(int(code)) + ": " + (text != nullptr ? text : "unknown"));
}

StarForest::StarForest(MPI_Comm comm, const std::vector<Id>& ids, const Blocks& blocks)
    : roots_(std::size_t(blocks.begin(rank_of(comm) + 1) - blocks.begin(rank_of(comm)))), leaves_(ids.size()) {
  std::vector<PetscSFNode> roots(leaves_);
  for (std::size_t i = 0; i < leaves_; ++i) {
    const int owner = blocks.owner(ids[i]);
    roots[i] = {owner, PetscInt(ids[i] - blocks.begin(owner))};
  }
  check_petsc(PetscSFCreate(comm, &sf_));
  check_petsc(PetscSFSetGraph(sf_, PetscInt(roots_), PetscInt(leaves_), nullptr, PETSC_COPY_VALUES, roots.data(),
                              PETSC_COPY_VALUES));
  check_petsc(PetscSFSetUp(sf_));
}

std::vector<int> StarForest::copies() const {
  const PetscInt* degree = nullptr;
  check_petsc(PetscSFComputeDegreeBegin(sf_, &degree));
  check_petsc(PetscSFComputeDegreeEnd(sf_, &degree));
  return {degree, degree + roots_};
}

std::vector<int> StarForest::minima(const std::vector<int>& values) const {
  std::vector<int> minima(roots_, std::numeric_limits<int>::max());
  check_petsc(PetscSFReduceBegin(sf_, MPI_INT, values.data(), minima.data(), MPI_MIN));
  check_petsc(PetscSFReduceEnd(sf_, MPI_INT, values.data(), minima.data(), MPI_MIN));
  return fetch(minima);
}

}  // namespace tetune::mpi
