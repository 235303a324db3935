// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "plugin.hpp"

namespace tetune::plugin {

/// A name of a mesh to be written, and the number of characters that the format allows it.
struct LimitedName {
  std::string* text;
  std::size_t most;
};

/// Replaces names that are longer than their limits by shorter ones, each different from all other names in the list,
/// with warnings. Equal names stay equal. `length`: the number of characters that the format writes for one. `what`:
/// for the warnings, what the names are of.
void shorten_names(const std::vector<LimitedName>& names, std::size_t (*length)(char), const char* what,
                   Warnings& warnings);

/// Shortens names of data and tags to the length that readers of VTK's legacy files accept.
void shorten_names_for_legacy(TetMesh& mesh, Warnings& warnings);

}  // namespace tetune::plugin
