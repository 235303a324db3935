// SPDX-License-Identifier: Apache-2.0
#include "io/nastran/nastran_systems.hpp"

#include <cmath>

#include "math/angle.hpp"
#include "math/elementary.hpp"

namespace tetune {
namespace {

using Kind = NastranSystem::Kind;

/// The components along the axes.
Vec3 components(Kind kind, const Vec3& x) {
  const auto radians = [](double degrees) { return degrees / kDegreesPerRadian; };
  if (kind == Kind::rectangular) return x;
  if (kind == Kind::cylindrical) {
    return {x.x * elementary::cos(radians(x.y)), x.x * elementary::sin(radians(x.y)), x.z};
  }
  const double distance = x.x * elementary::sin(radians(x.y));  // from the z axis
  return {distance * elementary::cos(radians(x.z)), distance * elementary::sin(radians(x.z)),
          x.x * elementary::cos(radians(x.y))};
}

}  // namespace

void NastranSystems::add(int number, const NastranSystem& system) {
  if (!systems_.try_emplace(number, system).second) {
    fail_(system.place, "the coordinate system " + std::to_string(number) + " is defined twice");
  }
}

Vec3 NastranSystems::in_basic(int system, const Vec3& coordinates, NastranPlace place) {
  if (system == 0) return coordinates;
  const Frame& frame = frame_of(system, place);
  const Vec3 x = components(systems_.at(system).kind, coordinates);
  return frame.origin + x.x * frame.axes[0] + x.y * frame.axes[1] + x.z * frame.axes[2];
}

const NastranSystems::Frame& NastranSystems::frame_of(int number, NastranPlace place) {
  if (const auto found = frames_.find(number); found != frames_.end()) return found->second;
  const auto at = systems_.find(number);
  const std::string name = "the coordinate system " + std::to_string(number);
  if (at == systems_.end()) fail_(place, name + " is used here, and no card defines it (CORD1R, CORD2R and so on)");
  const NastranSystem& system = at->second;
  if (!unfinished_.insert(number).second) fail_(system.place, name + " is defined by itself");
  constexpr std::size_t kMaxDepth = 1000;
  if (unfinished_.size() > kMaxDepth) fail_(system.place, name + " depends on more than 1000 others");
  std::array<Vec3, 3> points;
  for (std::size_t k = 0; k < 3; ++k) {
    points[k] = system.has_nodes ? position_of_(system.nodes[k], system.place)
                                 : in_basic(system.reference, system.points[k], system.place);
  }
  unfinished_.erase(number);
  const auto unit = [&](const Vec3& v) {
    const double length = norm(v);
    if (!(length > 0) || !std::isfinite(length)) fail_(system.place, name + " has three points on a line");
    return (1 / length) * v;
  };
  Frame frame{points[0], {}};
  frame.axes[2] = unit(points[1] - points[0]);
  frame.axes[1] = unit(cross(frame.axes[2], points[2] - points[0]));
  frame.axes[0] = cross(frame.axes[1], frame.axes[2]);
  return frames_.emplace(number, frame).first->second;
}

}  // namespace tetune
