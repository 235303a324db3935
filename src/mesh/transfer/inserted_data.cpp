// SPDX-License-Identifier: Apache-2.0
// Data of vertices that were inserted, interpolated between those of their neighbors.
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "math/constants.hpp"
#include "math/elementary.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/transfer/check_ids.hpp"
#include "tetune/data.hpp"

namespace tetune {
namespace {

/// The neighbors of an inserted vertex, with interpolation weights that sum to 1.
struct Stencil {
  struct Neighbor {
    Index vertex;
    double weight;
    double distance;
  };
  Index vertex;
  std::vector<Neighbor> neighbors;

  Neighbor& neighbor(Index v, double distance) {
    const auto found =
        std::find_if(neighbors.begin(), neighbors.end(), [v](const Neighbor& n) { return n.vertex == v; });
    return found != neighbors.end() ? *found : neighbors.emplace_back(Neighbor{v, 0, distance});
  }
};

/// The mean value weights of the vertices of a triangle for an interpolation at x (Ju, Schaefer, Warren 2005, Sect. 3).
std::array<double, 3> mean_value_weights(const Vec3& x, const std::array<Vec3, 3>& triangle) {
  std::array<Vec3, 3> unit{};
  std::array<double, 3> length{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 to = triangle[i] - x;
    length[i] = norm(to);
    unit[i] = (1 / length[i]) * to;
  }
  // The integral of the unit normal over the spherical triangle, as a sum over its edges.
  std::array<Vec3, 3> normal{};
  Vec3 mean{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& u = unit[(i + 1) % 3];
    const Vec3& v = unit[(i + 2) % 3];
    const double sine = norm(cross(u, v));
    normal[i] = (1 / sine) * cross(u, v);
    mean = mean + 0.5 * elementary::atan2(sine, dot(u, v)) * normal[i];
  }
  std::array<double, 3> weights{};
  for (std::size_t i = 0; i < 3; ++i) {
    // The absolute value makes the weights positive for either orientation of the triangle.
    weights[i] = dot(normal[i], mean) / (length[i] * std::fabs(dot(normal[i], unit[i])));
  }
  return weights;
}

std::vector<Stencil> find_stencils(const std::vector<Index>& vertex2original, const std::vector<Point3>& points,
                                   const std::vector<std::array<Index, 4>>& tets) {
  std::vector<Stencil> stencils;
  std::vector<Index> stencil_of(points.size(), -1);
  const Span<const Index> original = span_of(vertex2original);
  for (Index v = 0; v < original.size(); ++v) {
    if (original[v] >= 0) continue;
    span_of(stencil_of)[v] = to_index(stencils.size());
    stencils.push_back({v, {}});
  }
  const double scale = unit_scale(points);
  const auto position = [&points, scale](Index v) { return scale * vec(span_of(points)[v]); };
  for (const auto& tet : tets) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Index id = span_of(stencil_of)[tet[k]];
      if (id < 0) continue;
      const Vec3 x = position(tet[k]);
      const std::array<Index, 3> face{tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]};
      const auto weights = mean_value_weights(x, {position(face[0]), position(face[1]), position(face[2])});
      for (std::size_t i = 0; i < 3; ++i) {
        span_of(stencils)[id].neighbor(face[i], norm(position(face[i]) - x)).weight += weights[i];
      }
    }
  }
  for (Stencil& stencil : stencils) {
    double sum = 0;
    for (const Stencil::Neighbor& n : stencil.neighbors) sum += n.weight;
    for (Stencil::Neighbor& n : stencil.neighbors) n.weight /= sum;
  }
  return stencils;
}

/// Sets the values at inserted vertices to the weighted means of their neighbors. Inserted vertices may be neighbors of
/// each other: the linear system is solved by Gauss-Seidel iteration.
template <class T>
void interpolate(std::vector<T>& values, Size components, const std::vector<Stencil>& stencils) {
  constexpr int kMaxIterations = 200;
  constexpr double kTolerance = std::max(1e-15, static_cast<double>(std::numeric_limits<T>::epsilon()));
  for (Size c = 0; c < components; ++c) {
    const auto value = [&](Index v) -> T& { return span_of(values)[v * components + c]; };
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      double max_change = 0;
      double max_value = 0;
      for (const Stencil& stencil : stencils) {
        double mean = 0;
        for (const Stencil::Neighbor& n : stencil.neighbors) mean += n.weight * double{value(n.vertex)};
        max_change = std::max(max_change, std::fabs(mean - double{value(stencil.vertex)}));
        max_value = std::max(max_value, std::fabs(mean));
        value(stencil.vertex) = static_cast<T>(mean);
      }
      if (!(max_change > kTolerance * max_value)) break;
    }
  }
}

/// For each vertex the vertex of the input whose integer values it gets: its original, or for an inserted vertex that
/// of the nearest neighbor, which may have been inserted too.
std::vector<Index> nearest_originals(std::vector<Index> vertex2original, const std::vector<Stencil>& stencils) {
  for (bool changed = true; changed;) {
    changed = false;
    const std::vector<Index> known = vertex2original;
    for (const Stencil& stencil : stencils) {
      Index& original = span_of(vertex2original)[stencil.vertex];
      if (original >= 0) continue;
      double nearest = kInfinity;
      for (const Stencil::Neighbor& n : stencil.neighbors) {
        const Index candidate = span_of(known)[n.vertex];
        if (candidate < 0 || n.distance >= nearest) continue;
        nearest = n.distance;
        original = candidate;
        changed = true;
      }
    }
  }
  return vertex2original;
}

}  // namespace

std::vector<DataArray> carry_point_data(const std::vector<DataArray>& data, const std::vector<Index>& vertex2original,
                                        const std::vector<Point3>& points,
                                        const std::vector<std::array<Index, 4>>& tets) {
  if (data.empty() || vertex2original.empty()) return data;
  if (vertex2original.size() != points.size()) {
    throw MeshError("vertex2original has " + std::to_string(vertex2original.size()) +
                    " entries; it must have one for each of the " + std::to_string(points.size()) + " vertices");
  }
  check_not_negative(vertex2original, "vertex2original");
  for (const auto& tet : tets) {
    const bool is_known =
        std::all_of(tet.begin(), tet.end(), [&](Index v) { return v >= 0 && v < std::ssize(points); });
    if (!is_known) throw MeshError("a tetrahedron has a vertex that is none of the " + std::to_string(points.size()));
  }
  const bool inserted = std::find(vertex2original.begin(), vertex2original.end(), kInserted) != vertex2original.end();
  if (!inserted) return take_entries(data, vertex2original);
  const std::vector<Stencil> stencils = find_stencils(vertex2original, points, tets);
  const std::vector<Index> nearest = nearest_originals(vertex2original, stencils);
  std::vector<DataArray> result = take_entries(data, nearest);
  for (DataArray& array : result) {
    std::visit(
        [&](auto& values) {
          using T = typename std::remove_cvref_t<decltype(values)>::value_type;
          if constexpr (std::is_floating_point_v<T>) interpolate(values, array.components, stencils);
        },
        array.values);
  }
  return result;
}

}  // namespace tetune
