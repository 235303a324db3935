// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <BRepBndLib.hxx>
#include <Bnd_Box.hxx>
#include <TopoDS_Shape.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Pnt.hxx>

namespace tetune::plugin {

/// The bounding box of a shape, of its exact geometry.
inline Bnd_Box box_of(const TopoDS_Shape& shape) {
  Bnd_Box box;
  BRepBndLib::Add(shape, box, Standard_False);
  return box;
}

/// Distance of a point from a box; 0 inside.
inline double box_distance(const Bnd_Box& box, const gp_Pnt& p) {
  const gp_Pnt low = box.CornerMin(), high = box.CornerMax();
  double sum = 0;
  for (int k = 1; k <= 3; ++k) {
    const double d = std::max({low.Coord(k) - p.Coord(k), 0.0, p.Coord(k) - high.Coord(k)});
    sum += d * d;
  }
  return std::sqrt(sum);
}

}  // namespace tetune::plugin
