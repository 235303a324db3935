// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "io/nastran/nastran_cards.hpp"
#include "math/vec3.hpp"

namespace tetune {

/// A coordinate system of the cards CORD1R, CORD1C, CORD1S, CORD2R, CORD2C and CORD2S: by its origin, a point on the z
/// axis, and one in the half plane of the x axis.
struct NastranSystem {
  enum class Kind { rectangular, cylindrical, spherical };
  Kind kind = Kind::rectangular;
  NastranPlace place;
  bool has_nodes = false;      ///< the points are nodes (CORD1R and so on)
  std::array<int, 3> nodes{};  ///< their numbers
  int reference = 0;           ///< else the system in which the points are; 0: the basic one
  std::array<Vec3, 3> points{};
};

/// The coordinate systems of a file.
class NastranSystems {
 public:
  /// Throws FileError.
  using Fail = std::function<void(NastranPlace place, const std::string& text)>;
  /// The position of a node in the basic system. `place` is that of the card that names it.
  using PositionOf = std::function<Vec3(int node, NastranPlace place)>;
  NastranSystems(Fail fail, PositionOf position_of) : fail_(std::move(fail)), position_of_(std::move(position_of)) {}

  void add(int number, const NastranSystem& system);
  /// A position in the basic system, by its coordinates in another one; angles are in degrees. `place` is that of the
  /// card that has them.
  Vec3 in_basic(int system, const Vec3& coordinates, NastranPlace place);

 private:
  struct Frame {
    Vec3 origin{};
    std::array<Vec3, 3> axes{};
  };
  const Frame& frame_of(int number, NastranPlace place);

  Fail fail_;
  PositionOf position_of_;
  std::map<int, NastranSystem> systems_;
  std::map<int, Frame> frames_;
  std::set<int> unfinished_;  ///< systems whose frames are being found
};

}  // namespace tetune
