// SPDX-License-Identifier: Apache-2.0
#include "nearest.hpp"

#include <BRep_Tool.hxx>
#include <ElCLib.hxx>
#include <ElSLib.hxx>
#include <algorithm>
#include <cmath>

#include "box.hpp"

namespace tetune::plugin {
namespace {

constexpr double kSearchTolerance = 1e-10;

void take_nearer(Foot& best, const gp_Pnt& point, const gp_Pnt& p, const std::optional<gp_Pnt2d>& uv = {}) {
  const double distance = point.Distance(p);
  if (distance < best.distance) best = {point, distance, uv};
}

/// The foot on a plane, cylinder, cone, sphere or torus that is not trimmed.
std::optional<gp_Pnt2d> elementary_foot(const BRepAdaptor_Surface& surface, const gp_Pnt& p) {
  double u = 0, v = 0;
  switch (surface.GetType()) {
    case GeomAbs_Plane:
      ElSLib::Parameters(surface.Plane(), p, u, v);
      break;
    case GeomAbs_Cylinder:
      ElSLib::Parameters(surface.Cylinder(), p, u, v);
      break;
    case GeomAbs_Cone:
      ElSLib::Parameters(surface.Cone(), p, u, v);
      break;
    case GeomAbs_Sphere:
      ElSLib::Parameters(surface.Sphere(), p, u, v);
      break;
    case GeomAbs_Torus:
      ElSLib::Parameters(surface.Torus(), p, u, v);
      break;
    default:
      return {};
  }
  return gp_Pnt2d(u, v);
}

/// Moves a parameter into its range; false if it is outside by more than rounding.
bool clamp_parameter(double& t, double first, double last, bool periodic) {
  if (periodic) return true;
  const double slack = 1e-9 * (last - first);
  if (t < first - slack || t > last + slack) return false;
  t = std::clamp(t, first, last);
  return true;
}

/// A step towards the nearest point of a surface.
struct Step {
  bool is_regular = false;
  gp_Pnt from{};
  double du = 0, dv = 0;
  gp_Vec along{};
  double length = 0;
};

/// The step with the matrix of rows a, b and b, d, where `r` leads from the point to the surface.
Step step_of(const gp_Pnt& from, const gp_Vec& r, const gp_Vec& du, const gp_Vec& dv, double a, double b, double d) {
  const double gu = r.Dot(du), gv = r.Dot(dv);
  const double det = a * d - b * b;
  if (!(det > 1e-12 * a * d)) return {};
  Step step{true, from, (b * gv - d * gu) / det, (b * gu - a * gv) / det};
  step.along = du * step.du + dv * step.dv;
  step.length = step.along.Magnitude();
  return step;
}

/// The step of the method of Gauss and Newton, without second derivatives, which is as good near the surface: errors
/// decrease by the distance times the curvature.
Step gauss_newton_step(const BRepAdaptor_Surface& s, const gp_Pnt& p, double u, double v) {
  gp_Pnt c;
  gp_Vec du, dv;
  s.D1(u, v, c, du, dv);
  return step_of(c, gp_Vec(p, c), du, dv, du.SquareMagnitude(), du.Dot(dv), dv.SquareMagnitude());
}

Step newton_step(const BRepAdaptor_Surface& s, const gp_Pnt& p, double u, double v) {
  gp_Pnt c;
  gp_Vec du, dv, duu, dvv, duv;
  s.D2(u, v, c, du, dv, duu, dvv, duv);
  const gp_Vec r(p, c);
  double a = du.SquareMagnitude() + r.Dot(duu), b = du.Dot(dv) + r.Dot(duv), d = dv.SquareMagnitude() + r.Dot(dvv);
  if (!(a > 0 && a * d - b * b > 1e-6 * a * std::fabs(d))) {
    a = du.SquareMagnitude();
    b = du.Dot(dv);
    d = dv.SquareMagnitude();
  }
  return step_of(c, r, du, dv, a, b, d);
}

/// Newton's method for the parameter of the nearest point of a curve, from a good start.
double refine_on_curve(const BRepAdaptor_Curve& curve, const gp_Pnt& p, double t) {
  const double first = curve.FirstParameter(), last = curve.LastParameter();
  for (int i = 0; i < 10; ++i) {
    gp_Pnt c;
    gp_Vec d1, d2;
    curve.D2(t, c, d1, d2);
    const gp_Vec r(p, c);
    double slope = d1.SquareMagnitude() + r.Dot(d2);
    if (!(slope > 0)) slope = d1.SquareMagnitude();
    if (!(slope > 0)) break;
    const double next = std::clamp(t - r.Dot(d1) / slope, first, last);
    if (next == t) break;
    t = next;
  }
  return t;
}

}  // namespace

NearestPoints::NearestPoints(const Model& model)
    : model_(model), edges_(std::size_t(model.edges() + 1)), faces_(std::size_t(model.faces() + 1)) {}

NearestPoints::Edge& NearestPoints::edge(int i) {
  std::unique_ptr<Edge>& e = item(edges_, i);
  if (!e) {
    e = std::make_unique<Edge>();
    e->curve.Initialize(model_.edge(i));
    e->box = box_of(model_.edge(i));
    e->search.Initialize(e->curve, e->curve.FirstParameter(), e->curve.LastParameter(), kSearchTolerance);
    if (e->curve.GetType() != GeomAbs_Line && e->curve.GetType() != GeomAbs_Circle) sample(*e);
  }
  return *e;
}

NearestPoints::Face& NearestPoints::face(int i) {
  std::unique_ptr<Face>& f = item(faces_, i);
  if (!f) {
    f = std::make_unique<Face>();
    f->surface.Initialize(model_.face(i), Standard_True);
    f->trim = std::make_unique<TrimTable>(model_.face(i), f->surface);
    f->is_elementary = elementary_foot(f->surface, gp_Pnt(0, 0, 0)).has_value();
    if (!f->is_elementary) sample(*f);
  }
  return *f;
}

Foot NearestPoints::on_edge(int i, const gp_Pnt& p) {
  Edge& e = edge(i);
  const double first = e.curve.FirstParameter(), last = e.curve.LastParameter();
  Foot best;
  take_nearer(best, e.curve.Value(first), p);
  take_nearer(best, e.curve.Value(last), p);
  if (e.curve.GetType() == GeomAbs_Line) {
    const double t = ElCLib::Parameter(e.curve.Line(), p);
    if (t > first && t < last) take_nearer(best, e.curve.Value(t), p);
  } else if (e.curve.GetType() == GeomAbs_Circle) {
    const double t = ElCLib::InPeriod(ElCLib::Parameter(e.curve.Circle(), p), first, first + 2 * M_PI);
    if (t < last) take_nearer(best, e.curve.Value(t), p);
  } else if (const std::optional<Foot> foot = search_from_samples(e, p)) {
    take_nearer(best, foot->point, p);
  } else {
    e.search.Perform(p);
    for (int k = 1; e.search.IsDone() && k <= e.search.NbExt(); ++k) {
      take_nearer(best, e.curve.Value(refine_on_curve(e.curve, p, e.search.Point(k).Parameter())), p);
    }
  }
  return best;
}

std::optional<Foot> NearestPoints::refine(const Face& f, const gp_Pnt& p, gp_Pnt2d uv, double precision) {
  constexpr int kMaxSteps = 20;
  constexpr double kSlow = 0.25;  // steps that decrease by less need second derivatives
  double u = uv.X(), v = uv.Y();
  const BRepAdaptor_Surface& s = f.surface;
  const double rounding = 1e-14 * (1 + p.XYZ().Modulus());
  double last_step = kAnyRadius;
  bool is_slow = false;
  for (int i = 0; i < kMaxSteps; ++i) {
    const Step step = is_slow ? newton_step(s, p, u, v) : gauss_newton_step(s, p, u, v);
    if (!step.is_regular) return {};
    const bool is_rounding =
        step.length <= rounding || (i > 3 && step.length >= last_step && step.length <= 1e4 * rounding);
    if (is_rounding) return Foot{step.from, step.from.Distance(p), gp_Pnt2d(u, v)};
    u += step.du;
    v += step.dv;
    if (!clamp_parameter(u, s.FirstUParameter(), s.LastUParameter(), s.IsUPeriodic())) return {};
    if (!clamp_parameter(v, s.FirstVParameter(), s.LastVParameter(), s.IsVPeriodic())) return {};
    if (step.length <= precision * step.from.Distance(p)) {
      const gp_Pnt foot = step.from.Translated(step.along);
      return Foot{foot, foot.Distance(p), gp_Pnt2d(u, v)};
    }
    // Steps decrease at least as much as the last time.
    if (i > 0 && step.length < 0.1 * last_step && step.length * (step.length / last_step) <= rounding) {
      const gp_Pnt foot = s.Value(u, v);
      return Foot{foot, foot.Distance(p), gp_Pnt2d(u, v)};
    }
    is_slow = is_slow || step.length > kSlow * last_step;
    last_step = step.length;
  }
  return {};
}

void NearestPoints::sample(Edge& e) {
  constexpr int kPerInterval = 8;
  const int n = std::clamp(kPerInterval * e.curve.NbIntervals(GeomAbs_C2), 32, 512);
  const double first = e.curve.FirstParameter(), step = (e.curve.LastParameter() - first) / n;
  for (int i = 0; i <= n; ++i) {
    e.samples.push_back(e.curve.Value(first + i * step));
    if (i > 0) e.cell = std::max(e.cell, e.samples.back().Distance(item(e.samples, i - 1)));
  }
}

std::optional<Foot> NearestPoints::search_from_samples(const Edge& e, const gp_Pnt& p) {
  double least = kAnyRadius;
  for (const gp_Pnt& sample : e.samples) least = std::min(least, sample.SquareDistance(p));
  least = std::sqrt(least);
  if (least > e.cell) return {};
  const int last = int(e.samples.size()) - 1;
  const double first = e.curve.FirstParameter(), step = (e.curve.LastParameter() - first) / last;
  const double reach = (least + e.cell) * (least + e.cell);
  const auto distance2 = [&](int i) { return item(e.samples, std::clamp(i, 0, last)).SquareDistance(p); };
  Foot best;
  for (int i = 0; i <= last; ++i) {
    const double d = distance2(i);
    if (d > reach || distance2(i - 1) < d || distance2(i + 1) < d) continue;
    take_nearer(best, e.curve.Value(refine_on_curve(e.curve, p, first + i * step)), p);
  }
  if (best.distance > least) return {};
  return best;
}

void NearestPoints::sample(Face& f) {
  constexpr int kPerInterval = 4;
  const BRepAdaptor_Surface& s = f.surface;
  const int nu = std::clamp(kPerInterval * s.NbUIntervals(GeomAbs_C2), 16, 128);
  const int nv = std::clamp(kPerInterval * s.NbVIntervals(GeomAbs_C2), 16, 128);
  f.sample_columns = nv + 1;
  const double u0 = s.FirstUParameter(), v0 = s.FirstVParameter();
  const double du = (s.LastUParameter() - u0) / nu, dv = (s.LastVParameter() - v0) / nv;
  for (int i = 0; i <= nu; ++i) {
    for (int j = 0; j <= nv; ++j) {
      f.sample_uv.emplace_back(u0 + i * du, v0 + j * dv);
      f.samples.push_back(s.Value(f.sample_uv.back().X(), f.sample_uv.back().Y()));
      if (i == 0 || j == 0) continue;
      const std::size_t last = f.samples.size() - 1, row = std::size_t(nv + 1);
      f.cell = std::max({f.cell, f.samples[last].Distance(f.samples[last - row - 1]),
                         f.samples[last - 1].Distance(f.samples[last - row])});
    }
  }
}

std::pair<gp_Pnt2d, double> NearestPoints::nearest_sample(const Face& f, const gp_Pnt& p) {
  std::size_t best = 0;
  double least = kAnyRadius;
  for (std::size_t i = 0; i < f.samples.size(); ++i) {
    const double d = f.samples[i].SquareDistance(p);
    if (d >= least) continue;
    least = d;
    best = i;
  }
  return {f.sample_uv[best], std::sqrt(least)};
}

Foot NearestPoints::search_from_samples(Face& f, const gp_Pnt& p, double radius) {
  const int columns = f.sample_columns, rows = int(f.samples.size()) / columns;
  const double reach = (radius + f.cell) * (radius + f.cell);
  Foot best;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const double d = item(f.samples, i * columns + j).SquareDistance(p);
      if (d > reach) continue;
      bool is_least = true;
      for (int k = std::max(0, i - 1); k <= std::min(rows - 1, i + 1); ++k) {
        for (int l = std::max(0, j - 1); l <= std::min(columns - 1, j + 1); ++l) {
          is_least = is_least && item(f.samples, k * columns + l).SquareDistance(p) >= d;
        }
      }
      if (!is_least) continue;
      const std::optional<Foot> foot = refine(f, p, item(f.sample_uv, i * columns + j));
      if (foot && foot->distance < best.distance && is_inside(f, *foot)) best = *foot;
    }
  }
  return best;
}

Foot NearestPoints::search_surface(Face& f, const gp_Pnt& p, double& least) {
  Foot best;
  const BRepAdaptor_Surface& s = f.surface;
  if (const std::optional<gp_Pnt2d> uv = elementary_foot(s, p)) {
    const Foot foot{s.Value(uv->X(), uv->Y()), 0, uv};
    least = foot.point.Distance(p);
    if (is_inside(f, foot)) take_nearer(best, foot.point, p, uv);
    return best;
  }
  if (!f.search) {
    f.search = std::make_unique<Extrema_ExtPS>();
    f.search->SetFlag(Extrema_ExtFlag_MIN);
    f.search->Initialize(s, s.FirstUParameter(), s.LastUParameter(), s.FirstVParameter(), s.LastVParameter(),
                         kSearchTolerance, kSearchTolerance);
  }
  f.search->Perform(p);
  least = 0;  // the boundary of the surface may be nearer than its extrema
  for (int k = 1; f.search->IsDone() && k <= f.search->NbExt(); ++k) {
    double u = 0, v = 0;
    f.search->Point(k).Parameter(u, v);
    Foot foot{s.Value(u, v), 0, gp_Pnt2d(u, v)};
    if (const std::optional<Foot> finer = refine(f, p, *foot.uv)) foot = *finer;
    if (is_inside(f, foot)) take_nearer(best, foot.point, p, foot.uv);
  }
  return best;
}

Foot NearestPoints::on_boundary(int i, const gp_Pnt& p, double radius) {
  Foot best;
  double least_skipped = kAnyRadius;
  for (const int e : model_.edges_of_face(i)) {
    const double bound = box_distance(edge(e).box, p);
    if (bound > radius || bound >= best.distance) {
      least_skipped = std::min(least_skipped, bound);
      continue;
    }
    const Foot foot = on_edge(e, p);
    if (foot.distance < best.distance) best = foot;
  }
  if (least_skipped < best.distance && best.distance > radius) best.distance = least_skipped;
  return best;
}

Foot NearestPoints::on_face(int i, const gp_Pnt& p, double radius, const std::optional<gp_Pnt2d>& guess,
                            double precision) {
  Face& f = face(i);
  if (!f.is_elementary) {
    const auto accepted = [&](const gp_Pnt2d& uv) -> std::optional<Foot> {
      const std::optional<Foot> foot = refine(f, p, uv, precision);
      return foot && foot->distance <= radius && is_inside(f, *foot) ? foot : std::nullopt;
    };
    if (guess && radius < kAnyRadius) {
      if (const std::optional<Foot> foot = accepted(*guess)) return *foot;
    }
    const auto [uv, distance] = nearest_sample(f, p);
    // Between samples the surface is at most about a cell nearer.
    if (distance - f.cell > radius) return {p, distance - f.cell, {}};
    if (const std::optional<Foot> foot = accepted(uv); foot && foot->distance <= distance) return *foot;
  }
  double least = 0;
  Foot best = f.is_elementary || radius == kAnyRadius ? search_surface(f, p, least) : search_from_samples(f, p, radius);
  if (least > radius) return {p, least, {}};
  if (best.distance <= radius && f.is_elementary) return best;
  const Foot border = on_boundary(i, p, std::min(radius, best.distance));
  // Of equal distances the one inside, which has parameters.
  if (border.distance < best.distance) best = border;
  return best;
}

}  // namespace tetune::plugin
