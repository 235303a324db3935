// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/registry.hpp"

namespace tetune {

/// A program in the installation's own folder that reads and writes formats through a library of the field. It is a
/// process of its own: starting the library costs nothing where it is not used, its crash on a damaged file is an error
/// message here, its license and its symbols stay with it.
struct Plugin {
  /// File name of the program.
  const char* program;
  /// Name of the library.
  const char* library;
};

inline constexpr Plugin kVtkPlugin{"tetune-vtk", "VTK"};
inline constexpr Plugin kGmshPlugin{"tetune-gmsh", "Gmsh"};

/// Whether this installation has the plugin.
bool has_plugin(const Plugin& plugin);

/// Throws FileError, with what to install, where the plugin or its library is missing.
TetMesh read_by_plugin(const Plugin& plugin, const std::string& path, const IoContext& context);

/// Writes `temporary`, a file in the folder of `path` with the same extension; messages name `path`.
void write_by_plugin(const Plugin& plugin, const std::string& path, const std::string& temporary, const TetMesh& mesh,
                     const IoContext& context);

/// Throws FileError unless this installation has the plugin.
void require_plugin(const Plugin& plugin, const std::string& path);

/// Throws FileError unless the plugin's library has the format of the name, which some builds of it lack.
void require_format(const Plugin& plugin, const std::string& path);

}  // namespace tetune
