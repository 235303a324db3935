// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "plugin.hpp"

namespace tetune::plugin {

TetMesh read_exodus(const std::string& file, Warnings& warnings);
void write_exodus(const std::string& file, TetMesh mesh, Warnings& warnings);

}  // namespace tetune::plugin
