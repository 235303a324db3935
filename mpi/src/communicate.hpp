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

/// Element by element over all ranks, the result on all.
template <class T>
std::vector<T> all_reduce(MPI_Comm comm, std::vector<T> values, MPI_Op op) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), datatype<T>(), op, comm);
  return values;
}
template <class T>
T all_reduce(MPI_Comm comm, T value, MPI_Op op) {
  return all_reduce(comm, std::vector<T>{value}, op)[0];
}
/// The value of each rank, on all.
template <class T>
std::vector<T> all_gather(MPI_Comm comm, T value) {
  std::vector<T> values(static_cast<std::size_t>(size_of(comm)));
  MPI_Allgather(&value, 1, datatype<T>(), values.data(), 1, datatype<T>(), comm);
  return values;
}
/// The sum over the ranks before this one.
inline std::int64_t sum_before(MPI_Comm comm, std::int64_t value) {
  const auto values = all_gather(comm, value);
  return std::accumulate(values.begin(), values.begin() + rank_of(comm), std::int64_t{0});
}

/// An item of some bytes.
class Datatype {
 public:
  explicit Datatype(std::size_t bytes) {
    MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &type_);
    MPI_Type_commit(&type_);
  }
  ~Datatype() { MPI_Type_free(&type_); }
  Datatype(const Datatype&) = delete;
  Datatype& operator=(const Datatype&) = delete;
  MPI_Datatype get() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

/// Items on their way: item i of this rank goes to rank `to[i]`. What arrives is in the order of the sending ranks, and
/// for each in the order of its items, so that it is the same every time. Trivially copyable items; fewer than 2^31 a
/// rank.
class Route {
 public:
  Route(MPI_Comm comm, const std::vector<int>& to);
  std::size_t arriving() const { return arriving_; }

  template <class T>
  std::vector<T> send(const std::vector<T>& items) const {
    std::vector<T> packed(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) packed[place_[i]] = items[i];
    std::vector<T> received(arriving_);
    transfer(packed.data(), out_, received.data(), in_, sizeof(T));
    return received;
  }
  /// One answer for each item that arrived, handed back to where the item came from, in the order of the items there.
  template <class T>
  std::vector<T> answer(const std::vector<T>& answers) const {
    std::vector<T> packed(place_.size());
    transfer(answers.data(), in_, packed.data(), out_, sizeof(T));
    std::vector<T> received(place_.size());
    for (std::size_t i = 0; i < place_.size(); ++i) received[i] = packed[place_[i]];
    return received;
  }
  /// The rank that each item came from.
  std::vector<int> senders() const;

 private:
  struct Counts {
    std::vector<int> count, begin;
  };
  static std::size_t add_up(Counts& counts);
  void transfer(const void* from, const Counts& out, void* to, const Counts& in, std::size_t bytes) const;

  MPI_Comm comm_;
  std::vector<std::size_t> place_;  ///< of each item in the buffer that is sent
  Counts out_, in_;
  std::size_t arriving_ = 0;
};

/// Does work that does not communicate. Where it throws on some ranks, all ranks throw what the lowest of them did.
void together(MPI_Comm comm, const std::function<void()>& work);

}  // namespace tetune::mpi
