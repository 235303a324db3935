// SPDX-License-Identifier: Apache-2.0
#include "tetune/data.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "core/types.hpp"
#include "core/unit_scale.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Entries in the order of `new2old`; zeros where that is -1.
DataArray gather(const DataArray& array, const std::vector<Index>& new2old) {
  if (array.components < 1) {
    throw MeshError("data \"" + array.name + "\" has " + std::to_string(array.components) +
                    " components; it must have at least one");
  }
  DataArray result{array.name, array.components, {}};
  const auto each = static_cast<std::size_t>(array.components);
  std::visit(
      [&](const auto& from) {
        std::remove_cvref_t<decltype(from)> to(new2old.size() * each);
        for (std::size_t i = 0; i < new2old.size(); ++i) {
          if (new2old[i] < 0) continue;
          const auto first = static_cast<std::size_t>(new2old[i]) * each;
          if (first + each > from.size()) {
            throw MeshError("data \"" + array.name + "\" has no entry " + std::to_string(new2old[i]) +
                            "; it must have one for each vertex or element");
          }
          std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(first), each,
                      to.begin() + static_cast<std::ptrdiff_t>(i * each));
        }
        result.values = std::move(to);
      },
      array.values);
  return result;
}

/// An inserted vertex: which ones are around it, and with what weights. Weights add up to 1.
struct Stencil {
  Index vertex;
  std::vector<Index> neighbours;
  std::vector<double> weights;
  std::vector<double> distances;
};

/// The weights that the vertices of the tetrahedron's face opposite to its vertex k get for a mean at that vertex.
std::array<double, 3> mean_value_weights(const Vec3& at, const std::array<Vec3, 3>& corners) {
  std::array<Vec3, 3> unit{};
  std::array<double, 3> length{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 to = corners[i] - at;
    length[i] = norm(to);
    unit[i] = (1 / length[i]) * to;
  }
  // The integral of the outward direction over the spherical triangle, by its sides.
  std::array<Vec3, 3> normal{};
  Vec3 mean{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 side = cross(unit[(i + 1) % 3], unit[(i + 2) % 3]);
    const double sine = norm(side);
    normal[i] = (1 / sine) * side;
    mean = mean + 0.5 * std::atan2(sine, dot(unit[(i + 1) % 3], unit[(i + 2) % 3])) * normal[i];
  }
  std::array<double, 3> weights{};
  for (std::size_t i = 0; i < 3; ++i) {
    // Positive whichever way the corners turn.
    weights[i] = dot(normal[i], mean) / (length[i] * std::fabs(dot(normal[i], unit[i])));
  }
  return weights;
}

std::vector<Stencil> find_stencils(const std::vector<Index>& vertex2original, const std::vector<Point3>& points,
                                   const std::vector<std::array<Index, 4>>& tets) {
  std::vector<Stencil> stencils;
  std::vector<Index> vertex2stencil(points.size(), -1);
  for (std::size_t v = 0; v < vertex2original.size(); ++v) {
    if (vertex2original[v] >= 0) continue;
    vertex2stencil[v] = static_cast<Index>(stencils.size());
    stencils.push_back({static_cast<Index>(v), {}, {}, {}});
  }
  const double scale = unit_scale(points);
  const auto at = [&points, scale](Index v) { return scale * vec(points[static_cast<std::size_t>(v)]); };
  for (const auto& tet : tets) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Index slot = vertex2stencil[static_cast<std::size_t>(tet[k])];
      if (slot < 0) continue;
      const std::array<Index, 3> face{tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]};
      const auto weights = mean_value_weights(at(tet[k]), {at(face[0]), at(face[1]), at(face[2])});
      Stencil& stencil = stencils[static_cast<std::size_t>(slot)];
      for (std::size_t i = 0; i < 3; ++i) {
        auto found = std::find(stencil.neighbours.begin(), stencil.neighbours.end(), face[i]);
        if (found == stencil.neighbours.end()) {
          stencil.neighbours.push_back(face[i]);
          stencil.weights.push_back(0);
          stencil.distances.push_back(norm(at(face[i]) - at(tet[k])));
          found = stencil.neighbours.end() - 1;
        }
        stencil.weights[static_cast<std::size_t>(found - stencil.neighbours.begin())] += weights[i];
      }
    }
  }
  for (Stencil& stencil : stencils) {
    double sum = 0;
    for (const double w : stencil.weights) sum += w;
    for (double& w : stencil.weights) w /= sum;
  }
  return stencils;
}

/// Means of the neighbours. Inserted vertices that are neighbours depend on each other: in turns, until all agree.
template <class T>
void interpolate(std::vector<T>& values, std::size_t each, const std::vector<Stencil>& stencils) {
  constexpr int kMostTurns = 200;
  constexpr double kAgree = 1e-15;
  for (std::size_t c = 0; c < each; ++c) {
    const auto value = [&](Index v) -> T& { return values[static_cast<std::size_t>(v) * each + c]; };
    for (int turn = 0; turn < kMostTurns; ++turn) {
      double change = 0;
      double largest = 0;
      for (const Stencil& stencil : stencils) {
        double mean = 0;
        for (std::size_t i = 0; i < stencil.neighbours.size(); ++i) {
          mean += stencil.weights[i] * static_cast<double>(value(stencil.neighbours[i]));
        }
        change = std::max(change, std::fabs(mean - static_cast<double>(value(stencil.vertex))));
        largest = std::max(largest, std::fabs(mean));
        value(stencil.vertex) = static_cast<T>(mean);
      }
      if (!(change > std::max(kAgree, static_cast<double>(std::numeric_limits<T>::epsilon())) * largest)) break;
    }
  }
}

/// For each inserted vertex one that came from the input: the nearest, or that of an inserted one that has found its
/// own.
std::vector<Index> nearest_originals(std::vector<Index> vertex2original, const std::vector<Stencil>& stencils) {
  for (bool found = true; found;) {
    found = false;
    const std::vector<Index> known = vertex2original;
    for (const Stencil& stencil : stencils) {
      Index& original = vertex2original[static_cast<std::size_t>(stencil.vertex)];
      if (original >= 0) continue;
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < stencil.neighbours.size(); ++i) {
        const Index candidate = known[static_cast<std::size_t>(stencil.neighbours[i])];
        if (candidate < 0 || stencil.distances[i] >= nearest) continue;
        nearest = stencil.distances[i];
        original = candidate;
        found = true;
      }
    }
  }
  return vertex2original;
}

}  // namespace

std::vector<DataArray> take_entries(const std::vector<DataArray>& data, const std::vector<Index>& new2old) {
  std::vector<DataArray> result;
  result.reserve(data.size());
  for (const DataArray& array : data) result.push_back(gather(array, new2old));
  return result;
}

std::vector<DataArray> carry_point_data(const std::vector<DataArray>& data, const std::vector<Index>& vertex2original,
                                        const std::vector<Point3>& points,
                                        const std::vector<std::array<Index, 4>>& tets) {
  if (data.empty() || vertex2original.empty()) return data;
  if (vertex2original.size() != points.size()) {
    throw MeshError("there are " + std::to_string(points.size()) + " vertices, and " +
                    std::to_string(vertex2original.size()) + " entries that say where they come from");
  }
  const bool inserted = std::find(vertex2original.begin(), vertex2original.end(), -1) != vertex2original.end();
  if (!inserted) return take_entries(data, vertex2original);
  const std::vector<Stencil> stencils = find_stencils(vertex2original, points, tets);
  const std::vector<Index> nearest = nearest_originals(vertex2original, stencils);
  std::vector<DataArray> result = take_entries(data, nearest);
  for (DataArray& array : result) {
    std::visit(
        [&](auto& values) {
          using T = typename std::remove_cvref_t<decltype(values)>::value_type;
          if constexpr (std::is_floating_point_v<T>) {
            interpolate(values, static_cast<std::size_t>(array.components), stencils);
          }
        },
        array.values);
  }
  return result;
}

}  // namespace tetune
