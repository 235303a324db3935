// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/registry.hpp"

namespace tetune {

/// A program in the installation's own folder that reads and writes formats through a library of the field. A process
/// of its own: the library's start costs nothing where it is not used, its crash on a damaged file is an error message
/// here, its licence and its symbols stay with it.
struct Plugin {
  /// File name of the program.
  const char* program;
  /// What it is built on, and the Debian packages to build it and to run it.
  const char* library;
  const char* build_package;
  const char* run_package;
};

inline constexpr Plugin kVtkPlugin{"tetune-vtk", "VTK", "libvtk9-dev", "libvtk9.1"};
inline constexpr Plugin kGmshPlugin{"tetune-gmsh", "Gmsh", "libgmsh-dev", "libgmsh4.8"};

/// Whether this installation has it.
bool has_plugin(const Plugin& plugin);

/// Throws FileError with what to install where the plugin or its library is missing.
TetMesh read_by_plugin(const Plugin& plugin, const std::string& path, const ReadContext& context);

/// Writes `temporary`, a file beside `path` with its ending; errors speak of `path`.
void write_by_plugin(const Plugin& plugin, const std::string& path, const std::string& temporary, const TetMesh& mesh,
                     const ReadContext& context);

/// Throws FileError unless this installation has the plugin.
void require_plugin(const Plugin& plugin, const std::string& path);

/// Throws FileError unless its library has the format of the name, which some builds of it lack.
void require_format(const Plugin& plugin, const std::string& path);

}  // namespace tetune
