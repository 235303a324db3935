// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

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
