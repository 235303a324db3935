// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "plugin.hpp"

namespace tetune::plugin {

/// Reads a file with the values of a time, which is numbered as for read() of plugin.hpp.
TetMesh read_exodus(const std::string& file, int time, Warnings& warnings);
std::vector<double> exodus_times(const std::string& file);
void write_exodus(const std::string& file, TetMesh mesh, Warnings& warnings);

}  // namespace tetune::plugin
