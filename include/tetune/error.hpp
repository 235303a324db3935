// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Base of all exceptions of the library except std::bad_alloc. The message says what is wrong, where, and what to do;
/// it writes options as `boundary=slide`.
class TETUNE_API Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file cannot be read or written.
class TETUNE_API FileError : public Error {
 public:
  using Error::Error;
};

/// A mesh breaks the contract of `validate()` (validate.hpp).
class TETUNE_API MeshError : public Error {
 public:
  using Error::Error;
};

/// Options::untangle could not make every volume positive, or every second-order element valid.
class TETUNE_API UntangleError : public MeshError {
 public:
  enum class Reason {
    no_room,                 ///< no positions make all volumes positive while the surface keeps its shape
    no_room_though_sliding,  ///< nor where it slides
    stopped,                 ///< by the caller
    surface_at_fault,        ///< the surface of the input crosses itself or is folded onto itself
    curved_surface,          ///< nodes that are held leave second-order elements no room
  };
  UntangleError(std::int64_t tangled, std::vector<Index> left, Reason reason, bool of_curved = false);
  /// Of second-order elements, whose reason is the curved surface; `remedy` says in words which options may help.
  UntangleError(std::int64_t tangled, std::vector<Index> left, std::vector<Index> folded, const Point3& place,
                std::string remedy);
  /// what(), with ids that start from 1 (as in MEDIT files) or from 0.
  std::string message(bool one_based) const;
  /// Number of inverted or flat tetrahedra of the input, or of second-order ones that are not proved valid.
  std::int64_t tangled;
  /// Tetrahedra of the input, in increasing order, whose descendants are still not positive; or else those at the
  /// surface where it would fold, or where it is at fault.
  std::vector<Index> left;
  Reason reason;
  bool of_curved;  ///< the elements are of second order
  /// The others are of second-order elements that the curved surface leaves no room. Those of `left` with a face that
  /// its own mid-side nodes fold, in increasing order.
  std::vector<Index> folded;
  Point3 place{};  ///< of the first element that the message names
  std::string remedy;
};

/// Second-order elements of the input are not proved valid, and Options::untangle is not set.
class TETUNE_API CurvedError : public MeshError {
 public:
  /// `place` is the position of the first.
  CurvedError(std::vector<Index> tets, const Point3& place);
  /// As in UntangleError, without the last sentence of what(), which names the function that measures elements.
  std::string message(bool one_based) const;
  std::vector<Index> tets;  ///< in increasing order
  Point3 place;
};

/// The mesh overlaps itself, and flips there would make faces that three or more tetrahedra share.
class TETUNE_API OverlapError : public MeshError {
 public:
  explicit OverlapError(std::vector<Index> tets);
  /// As in UntangleError.
  std::string message(bool one_based) const;
  std::vector<Index> tets;  ///< some tetrahedra of the input there, in increasing order
};

/// An option is out of its range, names a tag that no element has, or leaves nothing to do.
class TETUNE_API OptionError : public Error {
 public:
  using Error::Error;
};

/// A device is absent, unusable or out of memory.
class TETUNE_API DeviceError : public Error {
 public:
  using Error::Error;
};

}  // namespace tetune
