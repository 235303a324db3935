// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// Base of everything tetune throws on purpose. The message says what is wrong, where, and what to do.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file that cannot be read or written.
class FileError : public Error {
 public:
  using Error::Error;
};

/// A mesh that breaks the contract of `validate()` (see validate.hpp).
class MeshError : public Error {
 public:
  using Error::Error;
};

/// Options::untangle could not make every volume positive.
class UntangleError : public MeshError {
 public:
  /// There is no room for the vertices, with a boundary that stays or one that slides; or the caller wanted an end.
  enum class Reason { no_room, no_room_though_sliding, stopped };
  /// `tangled`: how many tetrahedra were inverted or flat. `left`: those of the input, in increasing order, that what
  /// is left descends from: tetrahedra still not positive, or else those at the surface where it would fold.
  UntangleError(std::int64_t tangled, std::vector<Index> left, Reason reason);
  /// what(), with ids counted from 1 (as MEDIT does) or from 0.
  std::string message(bool one_based) const;
  std::int64_t tangled;
  std::vector<Index> left;
  Reason reason;
};

/// The mesh overlaps itself, and flips there would make faces that three or more tetrahedra share.
class OverlapError : public MeshError {
 public:
  /// `tets`: some of the input there, in increasing order.
  explicit OverlapError(std::vector<Index> tets);
  /// As UntangleError's.
  std::string message(bool one_based) const;
  std::vector<Index> tets;
};

/// An option out of its range, or one that cannot take effect.
class OptionError : public Error {
 public:
  using Error::Error;
};

/// A device that is absent, unusable or out of memory.
class DeviceError : public Error {
 public:
  using Error::Error;
};

}  // namespace tetune
