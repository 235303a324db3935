// SPDX-License-Identifier: Apache-2.0
#include "trim_table.hpp"

#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <TopAbs_ShapeEnum.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <algorithm>
#include <cmath>

#include "plugin.hpp"

namespace tetune::plugin {

TrimTable::TrimTable(const TopoDS_Face& face, const BRepAdaptor_Surface& s)
    : exact_(face, BRep_Tool::Tolerance(face)),
      u0_(s.FirstUParameter()),
      v0_(s.FirstVParameter()),
      du_((s.LastUParameter() - u0_) / kCells),
      dv_((s.LastVParameter() - v0_) / kCells),
      is_regular_(du_ > 0 && dv_ > 0 && std::isfinite(u0_ + v0_ + du_ + dv_)),
      cells_(std::size_t(kCells * kCells), Cell::unknown) {
  if (is_regular_) mark_boundary(face);
}

/// Marks the cells of points of the boundary that are at most half a cell apart, and the cells around these.
void TrimTable::mark_boundary(const TopoDS_Face& face) {
  constexpr int kMaxSteps = 1 << 16;
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More() && is_regular_; e.Next()) {
    double first = 0, last = 0;
    const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(TopoDS::Edge(e.Current()), face, first, last);
    if (curve.IsNull() || !std::isfinite(last - first)) {
      is_regular_ = false;
      return;
    }
    double t = first, step = (last - first) / 16;
    gp_Pnt2d p = curve->Value(t);
    mark(p);
    for (int i = 0; t < last; ++i) {
      const double next_t = std::min(last, t + step);
      const gp_Pnt2d next = curve->Value(next_t), middle = curve->Value((t + next_t) / 2);
      const auto is_close = [&](const gp_Pnt2d& a, const gp_Pnt2d& b) {
        return std::fabs(a.X() - b.X()) <= du_ / 2 && std::fabs(a.Y() - b.Y()) <= dv_ / 2;
      };
      if (i == kMaxSteps) {
        is_regular_ = false;
        return;
      }
      if (!is_close(p, middle) || !is_close(middle, next)) {
        step /= 2;
        continue;
      }
      mark(middle);
      mark(next);
      t = next_t;
      p = next;
      step *= 1.5;
    }
  }
}

void TrimTable::mark(const gp_Pnt2d& uv) {
  const double u = (uv.X() - u0_) / du_, v = (uv.Y() - v0_) / dv_;
  for (int i = std::max(0, int(u) - 1); i <= std::min(kCells - 1, int(u) + 1); ++i) {
    for (int j = std::max(0, int(v) - 1); j <= std::min(kCells - 1, int(v) + 1); ++j) {
      item(cells_, i * kCells + j) = Cell::boundary;
    }
  }
}

bool TrimTable::is_inside(const gp_Pnt2d& uv) {
  const double u = (uv.X() - u0_) / du_, v = (uv.Y() - v0_) / dv_;
  if (is_regular_ && u >= 0 && v >= 0 && u < kCells && v < kCells) {
    const int i = int(u), j = int(v);
    Cell& cell = item(cells_, i * kCells + j);
    if (cell == Cell::unknown) {
      const bool inside = exact_.Perform({u0_ + (i + 0.5) * du_, v0_ + (j + 0.5) * dv_}) == TopAbs_IN;
      cell = inside ? Cell::inside : Cell::outside;
    }
    if (cell != Cell::boundary) return cell == Cell::inside;
  }
  return exact_.Perform(uv) != TopAbs_OUT;
}

}  // namespace tetune::plugin
