// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <petscsf.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "communicate.hpp"
#include "part.hpp"

namespace tetune::mpi {

/// Cuts a list into one block of ids a rank, its *home*: where all copies of an entity are asked for.
class Blocks {
 public:
  Blocks(Id count, int ranks) : count_(count), each_(std::max<Id>(1, (count + ranks - 1) / ranks)) {}
  int home(Id id) const { return static_cast<int>(id / each_); }
  Id begin(int rank) const { return std::min(count_, rank * each_); }

 private:
  Id count_, each_;
};

/// Throws Error for a code of PETSc's that is one.
void check_petsc(PetscErrorCode code);

/// Copies of entities on any ranks, and the place of each at home: the leaves and roots of a PetscSF.
class Star {
 public:
  /// Each id once on a rank.
  Star(MPI_Comm comm, const std::vector<Id>& ids, const Blocks& blocks);
  ~Star() { PetscSFDestroy(&sf_); }
  Star(const Star&) = delete;
  Star& operator=(const Star&) = delete;

  /// How many ranks have a copy, for each place of this rank's block.
  std::vector<int> copies() const;
  /// Calls f(rank, place) for each copy of what is at home here.
  template <class F>
  void for_each_copy(F f) const {
    PetscInt count = 0;
    const PetscMPIInt* ranks = nullptr;
    const PetscInt* begin = nullptr;
    const PetscInt* places = nullptr;
    check_petsc(PetscSFGetLeafRanks(sf_, &count, &ranks, &begin, &places));
    for (PetscInt r = 0; r < count; ++r) {
      for (PetscInt i = begin[r]; i < begin[r + 1]; ++i)
        f(static_cast<int>(ranks[r]), static_cast<std::size_t>(places[i]));
    }
  }
  /// What is at home, for each copy. Trivially copyable.
  template <class T>
  std::vector<T> fetch(const std::vector<T>& at_home) const {
    std::vector<T> copies(leaves_);
    const Datatype type(sizeof(T));
    check_petsc(PetscSFBcastBegin(sf_, type.get(), at_home.data(), copies.data(), MPI_REPLACE));
    check_petsc(PetscSFBcastEnd(sf_, type.get(), at_home.data(), copies.data(), MPI_REPLACE));
    return copies;
  }
  /// The smallest of the values of all copies, for each copy.
  std::vector<int> least(const std::vector<int>& values) const;

 private:
  PetscSF sf_ = nullptr;
  std::size_t roots_ = 0, leaves_ = 0;
};

}  // namespace tetune::mpi
