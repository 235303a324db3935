// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

namespace tetune::plugin {

/// Throws FileError when writing to a file that was closed since the start has failed: Gmsh does not check.
void check_closed_files();

}  // namespace tetune::plugin
