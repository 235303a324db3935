// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "io_fixture.hpp"

/// Decks of Abaqus and CalculiX.
namespace tetune::test {

using Inp = IoTest;

/// Two tetrahedra with the common face 20, 30, 40.
inline const std::string kTwoTets =
    "*NODE\n10, 0., 0., 0.\n20, 1., 0., 0.\n30, 0., 1., 0.\n40, 0., 0., 1.\n900000000000000050, 1., 1., 1.\n"
    "*ELEMENT, TYPE=C3D4\n7, 10, 20, 30, 40\n800000000000000000, 20, 30, 40, 900000000000000050\n";

inline std::map<std::string, std::vector<int>> groups_of(const TetMesh& m, int dimension) {
  std::map<std::string, std::vector<int>> groups;
  for (const Group& g : m.groups) {
    if (g.dimension == dimension) groups[g.name] = g.tags;
  }
  return groups;
}

}  // namespace tetune::test
