// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io_fixture.hpp"

/// Parts of Gmsh's files.
namespace tetune::test {

using Msh = IoTest;

inline const std::vector<std::string> kDialects{"msh 2.2 text", "msh 2.2 binary", "msh 4.1 text", "msh 4.1 binary"};

inline const std::string kOldHead = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
inline const std::string kFormat = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
inline const std::string kOldNodes = "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n";

}  // namespace tetune::test
