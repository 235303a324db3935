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

/// Two tetrahedra with the common face 2, 3, 4, and after their vertices the mid-side nodes, those of the face 12
/// to 14.
inline const std::string kTwoQuadratic =
    "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n5, 1., 1., 1.\n"
    "12, 0.5, 0.5, 0.\n13, 0., 0.5, 0.5\n14, 0.5, 0., 0.5\n21, 0.5, 0., 0.\n22, 0., 0.5, 0.\n23, 0., 0., 0.5\n"
    "31, 1., 0.5, 0.5\n32, 0.5, 1., 0.5\n33, 0.5, 0.5, 1.\n"
    "*ELEMENT, TYPE=C3D10\n1, 1, 2, 3, 4, 21, 12, 22, 23,\n14, 13\n2, 2, 3, 4, 5, 12, 13, 14, 31, 32, 33\n";

inline std::map<std::string, std::vector<int>> groups_of(const TetMesh& m, int dimension) {
  std::map<std::string, std::vector<int>> groups;
  for (const Group& g : m.groups) {
    if (g.dimension == dimension) groups[g.name] = g.tags;
  }
  return groups;
}

}  // namespace tetune::test
