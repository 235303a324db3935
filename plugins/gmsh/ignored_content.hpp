// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>

#include "plugin.hpp"

namespace tetune::plugin {

/// Warns of data sets of an I-deas file (.unv) that Gmsh ignores, and of a file that may be cut short: the format has
/// no counts, only a last line. Throws FileError where a data set of a mesh has no end.
void check_ignored_content(const std::string& file, const std::string& ending, Warnings& warnings);

}  // namespace tetune::plugin
