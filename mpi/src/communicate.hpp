// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>

#include <cstddef>
#include <exception>
#include <functional>
#include <numeric>
#include <string>
#include <type_traits>
#include <vector>

#include "ids.hpp"

namespace tetune::mpi {

inline int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}
inline int size_of(MPI_Comm comm) {
  int size = 0;
  MPI_Comm_size(comm, &size);
  return size;
}

template <class T>
MPI_Datatype datatype() {
  if constexpr (std::is_same_v<T, double>) return MPI_DOUBLE;
  if constexpr (std::is_same_v<T, std::int64_t>) return MPI_INT64_T;
  if constexpr (std::is_same_v<T, int>) return MPI_INT;
}

/// Reduces element by element over all ranks; all have the result.
template <class T>
std::vector<T> all_reduce(MPI_Comm comm, std::vector<T> values, MPI_Op op) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), int(values.size()), datatype<T>(), op, comm);
  return values;
}
template <class T>
T all_reduce(MPI_Comm comm, T value, MPI_Op op) {
  return all_reduce(comm, std::vector<T>{value}, op)[0];
}
/// Returns the values of all ranks, on all.
template <class T>
std::vector<T> all_gather(MPI_Comm comm, T value) {
  std::vector<T> values(std::size_t(size_of(comm)));
  MPI_Allgather(&value, 1, datatype<T>(), values.data(), 1, datatype<T>(), comm);
  return values;
}
/// Returns the items of all ranks, on all, in the order of the ranks.
template <class T>
std::vector<T> gather_all(MPI_Comm comm, const std::vector<T>& items, MPI_Datatype type) {
  const std::vector<int> counts = all_gather(comm, int(items.size()));
  std::vector<int> begin(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), begin.begin(), 0);
  std::vector<T> all(std::size_t(begin.back() + counts.back()));
  MPI_Allgatherv(items.data(), counts[std::size_t(rank_of(comm))], type, all.data(), counts.data(), begin.data(), type,
                 comm);
  return all;
}
/// The sum over the ranks before this one.
inline std::int64_t sum_before(MPI_Comm comm, std::int64_t value) {
  const auto values = all_gather(comm, value);
  return std::accumulate(values.begin(), values.begin() + rank_of(comm), std::int64_t{0});
}

/// The MPI data type of an item of a number of bytes.
class Datatype {
 public:
  explicit Datatype(std::size_t bytes) {
    MPI_Type_contiguous(int(bytes), MPI_BYTE, &type_);
    MPI_Type_commit(&type_);
  }
  ~Datatype() { MPI_Type_free(&type_); }
  Datatype(const Datatype&) = delete;
  Datatype& operator=(const Datatype&) = delete;
  MPI_Datatype get() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

/// A pattern of communication: item i of this rank goes to rank `to[i]`. Received items are in the order of the sending
/// ranks, and for each rank in the order of its items, so that results are reproducible. Items are trivially copyable,
/// and fewer than 2^31 per rank.
class Route {
 public:
  Route(MPI_Comm comm, const std::vector<int>& to);

  template <class T>
  std::vector<T> send(const std::vector<T>& items) const {
    std::vector<T> packed(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) packed[place_[i]] = items[i];
    std::vector<T> received(received_);
    transfer(packed.data(), out_, received.data(), in_, sizeof(T));
    return received;
  }
  /// Sends one answer per received item back to the rank of the item, where they are in the order of the items.
  template <class T>
  std::vector<T> answer(const std::vector<T>& answers) const {
    std::vector<T> packed(place_.size());
    transfer(answers.data(), in_, packed.data(), out_, sizeof(T));
    std::vector<T> received(place_.size());
    for (std::size_t i = 0; i < place_.size(); ++i) received[i] = packed[place_[i]];
    return received;
  }

 private:
  struct Counts {
    std::vector<int> count, begin;
  };
  static std::size_t add_up(Counts& counts);
  void transfer(const void* from, const Counts& out, void* to, const Counts& in, std::size_t bytes) const;

  MPI_Comm comm_;
  std::vector<std::size_t> place_;  ///< of each item in the send buffer
  Counts out_, in_;
  std::size_t received_ = 0;
};

/// Does work that does not communicate. Where it throws on some ranks, all ranks throw the exception of the lowest.
void collective_try(MPI_Comm comm, const std::function<void()>& work);

}  // namespace tetune::mpi
