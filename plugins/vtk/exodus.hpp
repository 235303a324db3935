// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "plugin.hpp"

namespace tetune::plugin {

/// `time` as of read().
TetMesh read_exodus(const std::string& file, int time, Warnings& warnings);
std::vector<double> exodus_times(const std::string& file);
void write_exodus(const std::string& file, TetMesh mesh, Warnings& warnings);

}  // namespace tetune::plugin
