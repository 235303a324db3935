// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace tetune::plugin {

/// Throws FileError when a file was closed, since the start, to which not all could be written: Gmsh does not look.
void check_closed_files();

}  // namespace tetune::plugin
