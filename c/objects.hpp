// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <new>

#include "tetune/tetune.h"
#include "tetune/tetune.hpp"

struct tetune_mesh {
  tetune::TetMesh mesh;
};
struct tetune_options {
  tetune::Options options;
};
struct tetune_criteria {
  tetune::AcceptanceCriteria criteria;
};
struct tetune_report {
  tetune::Report report;
};

/// The conversion of C++ exceptions to statuses, shared by the files of the C interface.
namespace tetune::c {

/// An error of the caller, which no exception of the library names.
struct InvalidArgument {
  const char* text;
};

/// Keeps the text for tetune_last_error(); returns the status.
tetune_status failed(tetune_status status, const char* text) noexcept;

/// Calls f, and turns exceptions into a status.
template <class F>
tetune_status guarded(const F& f) noexcept {
  try {
    f();
    return TETUNE_OK;
  } catch (const InvalidArgument& e) {
    return failed(TETUNE_INVALID_ARGUMENT, e.text);
  } catch (const tetune::FileError& e) {
    return failed(TETUNE_FILE_ERROR, e.what());
  } catch (const tetune::MeshError& e) {
    return failed(TETUNE_MESH_ERROR, e.what());
  } catch (const tetune::OptionError& e) {
    return failed(TETUNE_OPTION_ERROR, e.what());
  } catch (const tetune::DeviceError& e) {
    return failed(TETUNE_DEVICE_ERROR, e.what());
  } catch (const std::bad_alloc&) {
    return failed(TETUNE_OUT_OF_MEMORY, "out of memory");
  } catch (const std::exception& e) {
    return failed(TETUNE_INTERNAL_ERROR, e.what());
  } catch (...) {
    return failed(TETUNE_INTERNAL_ERROR, "an unknown exception");
  }
}

inline void require(bool condition, const char* text) {
  if (!condition) throw InvalidArgument{text};
}

template <class T>
T& checked(T* object) {
  require(object != nullptr, "a null pointer was given where an object is required");
  return *object;
}

}  // namespace tetune::c
