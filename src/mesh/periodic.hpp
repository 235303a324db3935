// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "math/vec3.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Two vertices match if their difference deviates from the translation by at most this part of the extent of the mesh.
inline constexpr double kMatchTolerance = 1e-9;

/// The length of the longest side of the bounding box.
double extent_of(const TetMesh& mesh);

/// The translation from the masters of a link to their images. Of the candidates for each coordinate (that of
/// PeriodicLink::affine, zero, the difference of the first pair and the doubles beside it) it is the one by which most
/// pairs match to the last bit. None where the pairs do not differ by a translation, as with a rotation.
std::optional<Vec3> translation_of(const PeriodicLink& link, const std::vector<Point3>& points, double tolerance);

/// The vertices that are linked to each other, in the caller's ids: a vertex inside a periodic face has one image, one
/// on an edge of a box three, a corner seven.
struct PeriodicClasses {
  /// Class by class; the first member of a class is its root.
  std::vector<Index> members;
  /// The translation of each member from the root.
  std::vector<Vec3> shifts;
  /// The members of class c are first[c] .. first[c + 1] - 1.
  std::vector<std::uint32_t> first{0};
  std::size_t size() const { return first.size() - 1; }
};

/// Finds the classes whose members are translations of each other. The root is a vertex that is no image, if there is
/// one, and of several the one of the lowest id.
PeriodicClasses find_periodic_classes(const TetMesh& mesh);

}  // namespace tetune
