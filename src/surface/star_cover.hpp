// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "par/pack.hpp"
#include "par/prefetch.hpp"
#include "surface/primitive.hpp"

namespace tetune {

/// A few ids, each with its place in the order they came in.
template <int kMost>
class SmallSet {
 public:
  static constexpr int kAbsent = -1;
  TETUNE_HD int size() const { return size_; }
  TETUNE_HD Index operator[](int place) const { return items_[place]; }
  TETUNE_HD int find(Index item) const {
    const int guess = slots_[slot_of(item)];
    if (guess == 0) return kAbsent;
    if (items_[guess - 1] == item) return guess - 1;
    for (int i = 0; i < size_; ++i) {
      if (items_[i] == item) return i;
    }
    return kAbsent;
  }
  /// The place of one that is not in it, or kAbsent: it is full.
  TETUNE_HD int add(Index item) {
    if (size_ == kMost) return kAbsent;
    items_[size_] = item;
    std::uint8_t& slot = slots_[slot_of(item)];
    if (slot == 0) slot = static_cast<std::uint8_t>(size_ + 1);
    return size_++;
  }

 private:
  static constexpr int kSlots = 256;
  static_assert(kMost < kSlots);
  TETUNE_HD static unsigned slot_of(Index item) { return static_cast<unsigned>(item) % kSlots; }
  Index items_[kMost];
  std::uint8_t slots_[kSlots] = {};
  int size_ = 0;
};

/// Where a corner of the reference is that no prism over a triangle holds.
enum class Wedge { none, close, far };

/// The triangles of the mesh's surface at a vertex and what of the reference is over them, found once for all: decides
/// most of what DeviationBound asks. Bit i of a mask stands for triangle i.
class StarCover {
 public:
  using Mask = std::uint32_t;
  static constexpr int kMostCorners = 16;

  TETUNE_HD StarCover(const ReferenceView& ref, Span<const Point> points, Span<const Site> sites, double limit)
      : ref_(ref), points_(points), sites_(sites), limit_(limit) {}

  /// The triangles around a vertex, were it at x. False: they are too many, not all of one patch, or folded over.
  TETUNE_HD bool take(Index vertex, const Vec3& x) {
    x_ = x;
    return take_star(vertex) && take_normals();
  }
  TETUNE_HD int size() const { return count_; }
  /// At the vertex, of triangle i.
  TETUNE_HD std::uint32_t corner(int i) const { return corner_[i]; }

  /// Asks for all triangles of the star. False: one is too far. Else those `in_doubt` are left to ask for. `wedge_of`:
  /// DeviationBound's.
  template <class WedgeOf>
  TETUNE_HD bool is_close(const Site& site, const WedgeOf& wedge_of, Mask& in_doubt) {
    start_at(site);
    const int starts = triangles_.size();
    for (int i = 0; i < triangles_.size() && doubt_ != all_; ++i) {
      over_[i] = 0;
      if (!visit(i, i < starts, wedge_of)) return false;
    }
    if (doubt_ != all_) doubt_ |= away_from_sites();
    in_doubt = doubt_;
    return true;
  }

 private:
  static constexpr int kLanes = sizeof(par::Pack) / sizeof(double);
  static constexpr int kMostTriangles = 64;
  static constexpr int kMostVertices = 64;
  /// As for DeviationBound.
  static constexpr double kInset = 1e-6;

  /// A vector for each triangle.
  struct Vectors {
    double x[kMostCorners], y[kMostCorners], z[kMostCorners];
    TETUNE_HD par::Pack dots(int i, const Vec3& d) const {
      using par::Pack;
      return par::load<Pack>(x + i) * d.x + par::load<Pack>(y + i) * d.y + par::load<Pack>(z + i) * d.z;
    }
    TETUNE_HD void set(int i, const Vec3& v) { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
    TETUNE_HD Vec3 operator[](int i) const { return {x[i], y[i], z[i]}; }
    TETUNE_HD double dot(int i, const Vec3& d) const { return x[i] * d.x + y[i] * d.y + z[i] * d.z; }
  };

  /// How a reference vertex lies to the triangles.
  struct Place {
    Vec3 d;          ///< from x
    Mask beyond[3];  ///< outside the prism over the triangle
    Mask high;       ///< farther from its plane than the bound
    Mask wedge;      ///< it may be beside one, where no prism is
    Mask at;         ///< triangles with a part of the reference over them that has this corner
    Mask behind;     ///< beyond ring vertex i, where the same may be true of triangles i - 1 and i
  };

  /// Over one triangle: the coordinates of its vertices, and the height.
  struct Over {
    double l[3], height;
  };

  TETUNE_HD int after(int i) const { return i + 1 < count_ ? i + 1 : 0; }
  TETUNE_HD int before(int i) const { return i > 0 ? i - 1 : count_ - 1; }
  /// Bit i to bit i + 1, and back.
  TETUNE_HD Mask to_next(Mask m) const { return ((m << 1) | (m >> (count_ - 1))) & all_; }
  TETUNE_HD Mask to_last(Mask m) const { return (m >> 1) | ((m & 1) << (count_ - 1)); }

  TETUNE_HD bool take_star(Index vertex) {
    const Size begin = ref_.vertex2corner.begin(vertex);
    const Size count = ref_.vertex2corner.end(vertex) - begin;
    if (count < 3 || count > kMostCorners) return false;
    count_ = static_cast<int>(count);
    all_ = (Mask{1} << count_) - 1;
    auto corner = static_cast<Index>(ref_.vertex2corner.items[begin]);
    for (int i = 0; i < count_; ++i) {
      const Index k = corner % 3;
      bit_[i] = std::uint64_t{1} << i;
      corner_[i] = static_cast<std::uint32_t>(corner);
      ring_[i] = ref_.triangles[corner / 3].v[(k + 1) % 3];
      edge_.set(i, vec(points_[ring_[i]]) - x_);
      // What has not slid far is over what it was.
      par::prefetch(&ref_.points[ring_[i]]);
      const Index outer = ref_.across[corner];
      walled_[i] = outer == kWall;
      if (walled_[i]) {
        outer_.set(i, {});
      } else {
        const Index apex = ref_.triangles[outer / 3].v[outer % 3];
        par::prefetch(&ref_.points[apex]);
        outer_.set(i, vec(points_[apex]) - x_);
      }
      const Index next = ref_.across[corner - k + (k + 1) % 3];
      if (next == kWall) return false;
      corner = next - next % 3 + (next + 1) % 3;
      if (ref_.triangles[next / 3].v[corner % 3] != vertex) return false;
    }
    return static_cast<std::uint32_t>(corner) == corner_[0];
  }

  TETUNE_HD bool take_normals() {
    Vec3 sum{};
    for (int i = 0; i < count_; ++i) {
      const Vec3 a = edge_[i];
      const Vec3 b = edge_[after(i)];
      const Vec3 normal = cross(a, b);
      const double n2 = dot(normal, normal);
      if (!(n2 > 0)) return false;
      slope_a_.set(i, (1 / n2) * cross(b, normal));
      slope_b_.set(i, (1 / n2) * cross(normal, a));
      unit_.set(i, (1 / std::sqrt(n2)) * normal);
      sum = sum + unit_[i];
      edge2_[i] = dot(a, a);
      const Vec3 e = b - a;
      const Vec3 apex = outer_[i] - a;
      inward_.set(i, walled_[i] ? Vec3{} : apex - (dot(apex, e) / dot(e, e)) * e);
      inward_at_[i] = walled_[i] ? -1 : dot(a, inward_[i]);
    }
    for (int i = count_; i % kLanes != 0; ++i) {
      bit_[i] = 0;
      for (Vectors* v : {&slope_a_, &slope_b_, &unit_, &edge_, &inward_}) v->set(i, {});
      edge2_[i] = inward_at_[i] = 0;
    }
    axis_ = (1 / norm(sum)) * sum;
    double least = 1;
    for (int i = 0; i < count_; ++i) {
      const double c = dot(axis_, unit_[i]);
      least = c < least ? c : least;
    }
    tilt2_ = 1 - least * least;
    return least > 0;
  }

  TETUNE_HD void start_at(const Site& site) {
    if (site.kind == SiteKind::triangle) {
      add(site.item, all_);
    } else if (site.kind == SiteKind::edge && ref_.across[site.item] != kWall) {
      add(site.item / 3, all_);
      add(ref_.across[site.item] / 3, all_);
    } else if (site.kind == SiteKind::vertex && ref_.kind[site.item] == Mobility::surface) {
      for (Size c = ref_.vertex2corner.begin(site.item); c < ref_.vertex2corner.end(site.item); ++c)
        add(static_cast<Index>(ref_.vertex2corner.items[c] / 3), all_);
    } else {
      doubt_ = all_;
    }
  }
  TETUNE_HD void add(Index triangle, Mask over) {
    par::prefetch(&ref_.across[3 * triangle]);
    if (triangles_.find(triangle) < 0 && triangles_.add(triangle) < 0) doubt_ |= over;
  }

  /// The place of a reference vertex, or null: there are too many.
  TETUNE_HD Place* place(Index v) {
    int i = vertices_.find(v);
    if (i < 0) {
      i = vertices_.add(v);
      if (i < 0) return nullptr;
      look(v, places_[i]);
    }
    return &places_[i];
  }
  TETUNE_HD void look(Index v, Place& p) const {
    const Vec3 d = ref_.point(v) - x_;
    using par::Pack;
    using par::where;
    par::PackBits sides{};
    par::PackBits off{};
    par::PackBits reach{};
    const Pack limit = Pack{} + limit_;
    for (int i = 0; i < count_; i += kLanes) {
      const auto bit = par::load<par::PackBits>(bit_ + i);
      const Pack la = slope_a_.dots(i, d);
      const Pack lb = slope_b_.dots(i, d);
      const Pack l0 = 1.0 - la - lb;
      const Pack height = unit_.dots(i, d);
      const Pack along = edge_.dots(i, d);
      sides |= where(l0 < kInset, bit) | where(la < kInset, bit << 16) | where(lb < kInset, bit << 32);
      const auto low = where(height <= limit, bit << 48) & where(height >= -limit, bit << 48);
      sides |= low ^ (bit << 48);
      const auto folded = where(l0 < 0.0, bit) & where(inward_.dots(i, d) <= par::load<Pack>(inward_at_ + i), bit);
      off |= folded | where(la < 0.0, bit << 16) | where(lb < 0.0, bit << 32);
      reach |= where(along > 0.0, bit) | where(along >= par::load<Pack>(edge2_ + i), bit << 16);
    }
    const auto mask = [this](std::uint64_t bits, int at) { return static_cast<Mask>(bits >> at) & all_; };
    const std::uint64_t side = par::merged(sides);
    const Mask out_a = mask(par::merged(off), 16);
    const Mask out_b = mask(par::merged(off), 32);
    const Mask behind = mask(par::merged(reach), 16);
    // The edge from x to ring vertex i is between triangles i - 1 and i.
    const Mask at_edge = to_next(out_a) & out_b & mask(par::merged(reach), 0) & ~behind;
    const Mask folded = mask(par::merged(off), 0);
    p.d = d;
    p.at = 0;
    for (int k = 0; k < 3; ++k) p.beyond[k] = mask(side, 16 * k);
    p.high = mask(side, 48);
    p.wedge = (out_a | out_b) == all_ ? all_ : folded | at_edge | to_last(at_edge);
    p.behind = behind;
    if ((p.wedge | p.behind) != 0 && is_site(v)) p.wedge = p.behind = 0;
  }
  /// Whether a vertex of the ring has stayed on a reference vertex.
  TETUNE_HD bool is_site(Index v) const {
    for (int i = 0; i < count_; ++i) {
      const Site site = sites_[ring_[i]];
      if (site.kind == SiteKind::vertex && site.item == v) return true;
    }
    return false;
  }

  /// Goes on from a reference triangle to its neighbours. As all are upright over the triangles, and none over them has
  /// an edge without a neighbour, these are covered. False: it is too far.
  template <class WedgeOf>
  TETUNE_HD bool visit(int found, bool start, const WedgeOf& wedge_of) {
    const Index triangle = triangles_[found];
    const SurfaceTriangle t = ref_.triangles[triangle];
    Place* corner[3];
    Place* apex[3];
    for (int k = 0; k < 3; ++k) corner[k] = place(t.v[k]);
    if (corner[0] == nullptr || corner[1] == nullptr || corner[2] == nullptr) {
      doubt_ = all_;
      return true;
    }
    if (start) doubt_ |= not_upright(corner, all_);
    Mask over = all_ & ~doubt_;
    for (int k = 0; k < 3; ++k) over &= ~(corner[0]->beyond[k] & corner[1]->beyond[k] & corner[2]->beyond[k]);
    if (over == 0) return true;
    if (!start) doubt_ |= not_upright(corner, over);
    over_[found] = over;
    for (Place* p : corner) p->at |= over;
    const Mask high = over & (corner[0]->high | corner[1]->high | corner[2]->high);
    for (int i = 0; i < count_; ++i) {
      if ((high >> i & 1) != 0 && !keeps_low(corner, i)) return false;
    }
    for (int k = 0; k < 3; ++k) {
      const Place& a = *corner[(k + 1) % 3];
      const Place& b = *corner[(k + 2) % 3];
      Mask crossed = over;
      for (int side = 0; side < 3; ++side) crossed &= ~(a.beyond[side] & b.beyond[side]);
      const Index other = ref_.across[3 * triangle + k];
      apex[k] = nullptr;
      if (other == kWall) {
        doubt_ |= crossed;
        continue;
      }
      apex[k] = place(ref_.triangles[other / 3].v[other % 3]);
      if (apex[k] == nullptr) doubt_ |= over;
      if (crossed != 0) add(other / 3, crossed);
    }
    for (int k = 0; k < 3; ++k) {
      ask_wedge(corner[k], over, wedge_of);
      ask_wedge(apex[k], over, wedge_of);
    }
    return true;
  }

  template <class WedgeOf>
  TETUNE_HD void ask_wedge(Place* p, Mask over, const WedgeOf& wedge_of) {
    if (p == nullptr) return;
    Mask behind = p->behind & (over | to_next(over));
    p->behind &= ~behind;
    for (int i = 0; behind != 0; ++i, behind >>= 1) {
      if ((behind & 1) != 0 && !leads_closer(i, p->d)) p->wedge |= (Mask{1} << i) | (Mask{1} << before(i));
    }
    const Mask asked = p->wedge & over;
    if (asked == 0) return;
    for (int i = 0; i < count_; ++i) {
      const Mask bit = Mask{1} << i;
      if ((asked & bit) == 0) continue;
      if (wedge_of(corner_[i], x_ + p->d, place_over(i, p->d).l) == Wedge::none) {
        p->wedge &= ~bit;
      } else {
        doubt_ |= bit;
      }
    }
  }
  /// Whether from ring vertex i one of its edges that are known here does.
  TETUNE_HD bool leads_closer(int i, const Vec3& d) const {
    const Vec3 from = d - edge_[i];
    const auto closer = [&](const Vec3& to) { return dot(from, to - edge_[i]) > 0; };
    return closer(outer_[i]) || closer(outer_[before(i)]) || closer(edge_[after(i)]) || closer(edge_[before(i)]);
  }

  TETUNE_HD Over place_over(int i, const Vec3& d) const {
    const double la = slope_a_.dot(i, d);
    const double lb = slope_b_.dot(i, d);
    return {{1 - la - lb, la, lb}, unit_.dot(i, d)};
  }
  /// Whether the part of a reference triangle over triangle i is within the bound: at its corners inside, where its
  /// edges cross the rim, and above the corners of triangle i.
  TETUNE_HD bool keeps_low(Place* const corner[3], int i) const {
    const Over p[3] = {place_over(i, corner[0]->d), place_over(i, corner[1]->d), place_over(i, corner[2]->d)};
    // For each vertex of triangle i, its coordinates over the reference triangle, times twice the area.
    double weight[3][3];
    for (int k = 0; k < 3; ++k) {
      const Over& a = p[(k + 1) % 3];
      const Over& b = p[(k + 2) % 3];
      double from = 0;
      double to = 1;
      for (int side = 0; side < 3; ++side) {
        const double da = a.l[side] - kInset;
        const double db = b.l[side] - kInset;
        if (da < 0 && db < 0) {
          to = -1;
        } else if (da < 0) {
          const double s = da / (da - db);
          from = s > from ? s : from;
        } else if (db < 0) {
          const double s = da / (da - db);
          to = s < to ? s : to;
        }
      }
      const double rise = b.height - a.height;
      if (from <= to && !(is_low(a.height + from * rise) && is_low(a.height + to * rise))) return false;
      weight[0][k] = a.l[1] * b.l[2] - a.l[2] * b.l[1];
      weight[1][k] = a.l[2] * b.l[0] - a.l[0] * b.l[2];
      weight[2][k] = a.l[0] * b.l[1] - a.l[1] * b.l[0];
    }
    for (int j = 0; j < 3; ++j) {
      // As far inside as the edges above, or rounding could pass by both.
      double w[3];
      for (int k = 0; k < 3; ++k)
        w[k] = (1 - 3 * kInset) * weight[j][k] + kInset * (weight[0][k] + weight[1][k] + weight[2][k]);
      if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
      const double sum = w[0] * p[0].height + w[1] * p[1].height + w[2] * p[2].height;
      const double most = (w[0] + w[1] + w[2]) * limit_;
      if (!(sum <= most && sum >= -most)) return false;
    }
    return true;
  }
  TETUNE_HD bool is_low(double height) const { return height <= limit_ && height >= -limit_; }

  /// Those of some triangles over which a reference triangle is not upright.
  TETUNE_HD Mask not_upright(Place* const corner[3], Mask over) const {
    const Vec3 normal = cross(corner[1]->d - corner[0]->d, corner[2]->d - corner[0]->d);
    const double up = dot(normal, axis_);
    if (up > 0 && up * up > tilt2_ * dot(normal, normal)) return 0;
    Mask fallen = 0;
    for (int i = 0; i < count_; ++i) {
      if (!(dot(normal, unit_[i]) > 0)) fallen |= Mask{1} << i;
    }
    return fallen & over;
  }

  /// The triangles that have not, over them, what their vertices are on.
  TETUNE_HD Mask away_from_sites() const {
    Mask away = 0;
    for (int i = 0; i < count_; ++i) {
      const Mask over = over_site(sites_[ring_[i]]);
      const Mask bit = Mask{1} << i;
      away |= ~over & (bit | to_last(bit));
    }
    return away;
  }
  TETUNE_HD Mask over_site(const Site& site) const {
    switch (site.kind) {
      case SiteKind::triangle:
        return over_triangle(site.item);
      case SiteKind::edge: {
        const Index other = ref_.across[site.item];
        return over_triangle(site.item / 3) | (other != kWall ? over_triangle(other / 3) : 0);
      }
      case SiteKind::vertex:
        return over_vertex(site.item);
      case SiteKind::segment:
        return over_vertex(site.item / 2);
      default:
        return 0;
    }
  }
  TETUNE_HD Mask over_triangle(Index triangle) const {
    const int i = triangles_.find(triangle);
    return i < 0 ? 0 : over_[i];
  }
  TETUNE_HD Mask over_vertex(Index v) const {
    const int i = vertices_.find(v);
    return i < 0 ? 0 : places_[i].at;
  }

  const ReferenceView& ref_;
  Span<const Point> points_;
  Span<const Site> sites_;
  double limit_;

  // The star: triangle i is between ring vertices i and i + 1.
  Vec3 x_{};
  int count_ = 0;
  Mask all_ = 0;
  std::uint64_t bit_[kMostCorners];
  std::uint32_t corner_[kMostCorners];
  Index ring_[kMostCorners];
  bool walled_[kMostCorners];
  Vectors edge_;               ///< from x to the ring
  Vectors outer_;              ///< from x to the vertex across the edge opposite x
  Vectors slope_a_, slope_b_;  ///< of the coordinates over the triangle
  Vectors unit_;               ///< its normal
  Vectors inward_;             ///< from the edge opposite x into the triangle across it
  double edge2_[kMostCorners];
  double inward_at_[kMostCorners];
  Vec3 axis_{};       ///< between the normals
  double tilt2_ = 0;  ///< squared sine of the largest angle from it to a normal

  Mask doubt_ = 0;
  SmallSet<kMostTriangles> triangles_;
  Mask over_[kMostTriangles];  ///< of those visited, the triangles of the mesh that they have a part over
  SmallSet<kMostVertices> vertices_;
  Place places_[kMostVertices];
};

}  // namespace tetune
