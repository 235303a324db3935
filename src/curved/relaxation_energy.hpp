// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "curved/jacobian.hpp"
#include "tetune/types.hpp"

namespace tetune {

/// One element of a patch: its nodes as positions in the patch's list.
struct PatchElement {
  std::array<std::size_t, 10> nodes{};
  /// The inverse of the Jacobian matrix of the straight element that is the ideal shape, by rows.
  std::array<Vec3, 3> inverse_ideal{};
};

/// The energy of curved elements, at 35 points of each and once for the straight element, which has to stay positive
/// too (docs/method.md, "Curved tetrahedra"): with the Jacobian matrix J relative to the ideal shape, D = det J and chi
/// as in RegularizedRing,
///   e = ((|J|^2 / (3 chi^(2/3)) + (D^2 + 1) / (2 chi)) / 2)^power,
/// which is 1 for an element of the ideal shape and size.
class RelaxationEnergy {
 public:
  RelaxationEnergy(std::vector<PatchElement> elements, std::vector<Vec3> nodes, std::vector<std::size_t> unknowns);

  /// With epsilon 0 the energy is infinite where a determinant is not positive.
  double epsilon = 0;
  int power = 1;

  std::vector<double> start() const;
  /// Moves the unknown nodes to x. Returns all nodes.
  const std::vector<Vec3>& nodes_at(const std::vector<double>& x);
  double operator()(const std::vector<double>& x, std::vector<double>& gradient);
  /// The smallest D at the points.
  double smallest_determinant(const std::vector<double>& x);

 private:
  double add_element(const PatchElement& element);
  std::vector<PatchElement> elements_;
  std::vector<Vec3> nodes_;
  std::vector<Vec3> node_gradient_;  ///< per node
  std::vector<std::size_t> unknowns_;
};

/// The inverse of the matrix whose columns are the edges from the first vertex, by rows; infinite for a flat one.
std::array<Vec3, 3> inverse_of_edges(const std::array<Vec3, 4>& vertices);

}  // namespace tetune
