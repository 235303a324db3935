// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <BRepAdaptor_Surface.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <TopoDS_Face.hxx>
#include <gp_Pnt2d.hxx>
#include <vector>

namespace tetune::plugin {

/// Decides whether parameters of a face's surface are inside its boundary. A grid stores the results of OpenCASCADE's
/// test for cells away from the boundary.
class TrimTable {
 public:
  TrimTable(const TopoDS_Face& face, const BRepAdaptor_Surface& surface);

  bool is_inside(const gp_Pnt2d& uv);

 private:
  enum class Cell : char { unknown, boundary, inside, outside };
  static constexpr int kCells = 64;  ///< per direction

  void mark_boundary(const TopoDS_Face& face);
  void mark(const gp_Pnt2d& uv);

  BRepTopAdaptor_FClass2d exact_;
  double u0_, v0_, du_, dv_;  ///< first cell, and size of the cells
  bool is_regular_;           ///< the range of parameters is finite, and no boundary is left out
  std::vector<Cell> cells_;
};

}  // namespace tetune::plugin
