// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <petscsf.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "communicate.hpp"
#include "part.hpp"

namespace tetune::mpi {

/// The length of a list as PETSc's integer.
template <class List>
PetscInt petsc_size(const List& list) {
  return static_cast<PetscInt>(list.size());
}

/// Divides ids into one block per rank, the owner rank of these ids.
class Blocks {
 public:
  Blocks(Id count, int ranks) : count_(count), each_(std::max<Id>(1, (count + ranks - 1) / ranks)) {}
  int owner(Id id) const { return int(id / each_); }
  Id begin(int rank) const { return std::min(count_, rank * each_); }

 private:
  Id count_, each_;
};

/// Throws Error where the code of a PETSc call is not 0.
void check_petsc(PetscErrorCode code);

/// A PetscSF: its leaves are copies of entities on any ranks, its roots the positions of the entities in the blocks of
/// their owner ranks.
class StarForest {
 public:
  /// A rank has each id at most once.
  StarForest(MPI_Comm comm, const std::vector<Id>& ids, const Blocks& blocks);
  ~StarForest() { PetscSFDestroy(&sf_); }
  StarForest(const StarForest&) = delete;
  StarForest& operator=(const StarForest&) = delete;

  /// The number of copies of each entity of this rank's block.
  std::vector<int> copies() const;
  /// Calls f(rank, position) for each copy of an entity of this rank's block.
  template <class F>
  void for_each_copy(F f) const {
    PetscInt count = 0;
    const PetscMPIInt* ranks = nullptr;
    const PetscInt* begin = nullptr;
    const PetscInt* places = nullptr;
    check_petsc(PetscSFGetLeafRanks(sf_, &count, &ranks, &begin, &places));
    for (PetscInt r = 0; r < count; ++r) {
      for (PetscInt i = begin[r]; i < begin[r + 1]; ++i) f(int{ranks[r]}, std::size_t(places[i]));
    }
  }
  /// Sends a value per entity of the block to each of its copies. T is trivially copyable.
  template <class T>
  std::vector<T> fetch(const std::vector<T>& at_owner) const {
    std::vector<T> copies(leaves_);
    const Datatype type(sizeof(T));
    check_petsc(PetscSFBcastBegin(sf_, type.get(), at_owner.data(), copies.data(), MPI_REPLACE));
    check_petsc(PetscSFBcastEnd(sf_, type.get(), at_owner.data(), copies.data(), MPI_REPLACE));
    return copies;
  }
  /// For each copy the minimum of the values of all copies of its entity.
  std::vector<int> minima(const std::vector<int>& values) const;

 private:
  PetscSF sf_ = nullptr;
  std::size_t roots_ = 0, leaves_ = 0;
};

}  // namespace tetune::mpi
