// SPDX-License-Identifier: Apache-2.0
#include "communicate.hpp"

#include <new>

#include "tetune/error.hpp"

namespace tetune::mpi {

Route::Route(MPI_Comm comm, const std::vector<int>& to) : comm_(comm), place_(to.size()) {
  const std::size_t ranks(size_of(comm));
  out_.count.assign(ranks, 0);
  in_.count.assign(ranks, 0);
  for (const int rank : to) ++item(out_.count, rank);
  MPI_Alltoall(out_.count.data(), 1, MPI_INT, in_.count.data(), 1, MPI_INT, comm);
  add_up(out_);
  received_ = add_up(in_);
  std::vector<int> next = out_.begin;
  for (std::size_t i = 0; i < to.size(); ++i) {
    place_[i] = std::size_t(item(next, to[i])++);
  }
}

std::size_t Route::add_up(Counts& counts) {
  counts.begin.resize(counts.count.size());
  std::exclusive_scan(counts.count.begin(), counts.count.end(), counts.begin.begin(), 0);
  return std::size_t(counts.begin.back() + counts.count.back());
}

void Route::transfer(const void* from, const Counts& out, void* to, const Counts& in, std::size_t bytes) const {
  const Datatype item(bytes);
  MPI_Alltoallv(from, out.count.data(), out.begin.data(), item.get(), to, in.count.data(), in.begin.data(), item.get(),
                comm_);
}

namespace {

enum Kind : int { kNone, kFile, kMesh, kOption, kDevice, kMemory, kOther };

}  // namespace

void collective_try(MPI_Comm comm, const std::function<void()>& work) {
  int kind = kNone;
  std::string message;
  const auto failed = [&](Kind k, const std::exception& e) {
    kind = k;
    message = e.what();
  };
  try {
    work();
  } catch (const FileError& e) {
    failed(kFile, e);
  } catch (const MeshError& e) {
    failed(kMesh, e);
  } catch (const OptionError& e) {
    failed(kOption, e);
  } catch (const DeviceError& e) {
    failed(kDevice, e);
  } catch (const std::bad_alloc& e) {
    failed(kMemory, e);
  } catch (const std::exception& e) {
    failed(kOther, e);
  }
  const int ranks = size_of(comm);
  int first = all_reduce(comm, kind == kNone ? ranks : rank_of(comm), MPI_MIN);
  if (first == ranks) return;
  MPI_Bcast(&kind, 1, MPI_INT, first, comm);
  auto length = int(message.size());
  MPI_Bcast(&length, 1, MPI_INT, first, comm);
  message.resize(std::size_t(length));
  MPI_Bcast(message.data(), length, MPI_CHAR, first, comm);
  switch (kind) {
    case kFile:
      throw FileError(message);
    case kMesh:
      throw MeshError(message);
    case kOption:
      throw OptionError(message);
    case kDevice:
      throw DeviceError(message);
    case kMemory:
      throw Error("rank " + std::to_string(first) + ": out of memory; take more ranks, or nodes with more memory");
    default:
      throw Error("rank " + std::to_string(first) + ": " + message);
  }
}

}  // namespace tetune::mpi
