// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>

#include "plugin.hpp"

namespace tetune::plugin {

/// Warns of cards of a Nastran file (.bdf) and data sets of an I-deas file (.unv) that Gmsh ignores, and of a file that
/// may be cut short: these formats have no counts, only a last line, which Nastran files may lack. Throws FileError
/// where a data set of a mesh has no end, and where nodes are in a coordinate system of their own, which Gmsh would
/// take for the basic one.
void check_ignored_content(const std::string& file, const std::string& ending, Warnings& warnings);

}  // namespace tetune::plugin
