// SPDX-License-Identifier: Apache-2.0
#include "tetune/data.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "math/constants.hpp"
#include "math/elementary.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/whole_number.hpp"
#include "mesh/work_mesh.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Throws MeshError for an id below 0 that is not kInserted.
void check_not_negative(const std::vector<Index>& map, const std::string& name) {
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= kInserted) continue;
    throw MeshError(name + "[" + std::to_string(i) + "] is " + std::to_string(map[i]) +
                    "; it must be the id of a vertex or element, or -1 for none");
  }
}

/// The entries new2old[0], new2old[1], ... of an array; zeros for kInserted.
DataArray gather(const DataArray& array, const std::vector<Index>& new2old) {
  if (array.components < 1) {
    throw MeshError("data \"" + array.name + "\" has " + std::to_string(array.components) +
                    " components; it must have at least one");
  }
  DataArray result{array.name, array.components, {}};
  const Size components = array.components;
  std::visit(
      [&](const auto& from) {
        std::remove_cvref_t<decltype(from)> to(new2old.size() * to_size_t(components));
        auto entry = to.begin();
        for (const Index old : new2old) {
          if (old >= 0) {
            if ((old + 1) * components > std::ssize(from)) {
              throw MeshError("data \"" + array.name + "\" has no entry " + std::to_string(old) +
                              "; it must have one for each vertex or element");
            }
            std::copy_n(from.begin() + old * components, components, entry);
          }
          entry += components;
        }
        result.values = std::move(to);
      },
      array.values);
  return result;
}

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

/// For each vertex the input vertex that it takes integer values from: itself, or for an inserted vertex the nearest
/// neighbor, which passes on the input vertex of its own if it was inserted too.
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

/// Replaces the values of the nearest vertex, where those of all four are finite, by a linear interpolation.
template <class T>
void interpolate_at(const std::vector<T>& from, Size components, const std::vector<MeshPlace>& places,
                    std::vector<T>& to) {
  auto value = to.begin();
  for (const MeshPlace& place : places) {
    for (Size c = 0; c < components; ++c, ++value) {
      double sum = 0;
      T low = std::numeric_limits<T>::max();
      T high = std::numeric_limits<T>::lowest();
      for (std::size_t k = 0; k < 4; ++k) {
        if (place.weights[k] == 0) continue;
        const T x = span_of(from)[place.vertices[k] * components + c];
        sum += place.weights[k] * double{x};
        low = std::min(low, x);
        high = std::max(high, x);
      }
      // Rounding must not lead out of the range of the values.
      if (std::isfinite(sum)) *value = std::clamp(static_cast<T>(sum), low, high);
    }
  }
}

using Data = std::vector<DataArray>;

/// The name that unnamed tags get as data.
constexpr const char* kDefaultName = "medit:ref";

Data::const_iterator find(const Data& data, const std::string& name) {
  return std::find_if(data.begin(), data.end(), [&](const DataArray& array) { return array.name == name; });
}

std::string names_of(const Data& data) {
  std::string names;
  for (const DataArray& array : data) names += (names.empty() ? "" : ", ") + array.name;
  return names.empty() ? "none" : names;
}

int to_tag(double value) {
  if (std::isnan(value)) return 0;
  if (const std::optional<int> tag = whole_number(value)) return *tag;
  throw OptionError("it contains " + std::to_string(value));
}

std::vector<int> to_tags(const DataArray& array) {
  const std::string refusal = "the cell data \"" + array.name + "\" cannot be used as tags: ";
  if (array.components != 1) {
    throw OptionError(refusal + "it has " + std::to_string(array.components) +
                      " numbers per cell; a tag is one number");
  }
  try {
    return std::visit(
        [](const auto& values) {
          std::vector<int> tags;
          tags.reserve(values.size());
          for (const auto value : values) tags.push_back(to_tag(static_cast<double>(value)));
          return tags;
        },
        array.values);
  } catch (const OptionError& e) {
    throw OptionError(refusal + e.what() + "; a tag is a 32-bit integer");
  }
}

/// The data and the tags of one kind of elements.
struct ElementData {
  Data* data;
  std::vector<int>* tags;
};

}  // namespace

std::vector<DataArray> take_entries(const std::vector<DataArray>& data, const std::vector<Index>& new2old) {
  check_not_negative(new2old, "new2old");
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

std::vector<DataArray> interpolate_point_data(const std::vector<DataArray>& data,
                                              const std::vector<MeshPlace>& places) {
  std::vector<Index> nearest;
  Index largest = -1;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const MeshPlace& place = places[i];
    const auto at = std::max_element(place.weights.begin(), place.weights.end()) - place.weights.begin();
    nearest.push_back(place.vertices[to_size_t(at)]);
    for (const Index v : place.vertices) {
      if (v < 0) {
        throw MeshError("places[" + std::to_string(i) + "] names the vertex " + std::to_string(v) +
                        "; vertex ids are 0 or more");
      }
      largest = std::max(largest, v);
    }
  }
  if (largest >= 0) take_entries(data, {largest});  // all entries exist
  std::vector<DataArray> result = take_entries(data, nearest);
  for (std::size_t i = 0; i < data.size(); ++i) {
    std::visit(
        [&](auto& to) {
          using Values = std::remove_cvref_t<decltype(to)>;
          if constexpr (std::is_floating_point_v<typename Values::value_type>) {
            interpolate_at(std::get<Values>(data[i].values), data[i].components, places, to);
          }
        },
        result[i].values);
  }
  return result;
}

void use_as_tags(TetMesh& mesh, const std::string& name) {
  if (find(mesh.tet_data, name) == mesh.tet_data.end()) {
    if (name == (mesh.cell_tags_name.empty() ? kDefaultName : mesh.cell_tags_name))
      return;  // the tags have this name already
    throw OptionError("the tetrahedra have no data \"" + name + "\"; their data are: " + names_of(mesh.tet_data));
  }
  if (!mesh.groups.empty()) {
    throw OptionError("the tags of this mesh are those of its named groups; its data \"" + name +
                      "\" cannot replace them");
  }
  std::vector<ElementData> kinds{
      {&mesh.tet_data, &mesh.tet_tags}, {&mesh.triangle_data, &mesh.triangle_tags}, {&mesh.edge_data, &mesh.edge_tags}};
  for (ElementBlock& block : mesh.others) kinds.push_back({&block.data, &block.tags});
  const bool tagged = std::any_of(kinds.begin(), kinds.end(), [](const ElementData& kind) {
    return std::any_of(kind.tags->begin(), kind.tags->end(), [](int tag) { return tag != 0; });
  });
  std::string old_name = mesh.cell_tags_name.empty() ? kDefaultName : mesh.cell_tags_name;
  const auto is_taken = [&](const ElementData& kind) { return find(*kind.data, old_name) != kind.data->end(); };
  do {
    old_name += ":before";
  } while (std::any_of(kinds.begin(), kinds.end(), is_taken));

  // Everything that may throw comes first, so that the mesh changes completely or not at all.
  std::vector<std::vector<int>> tags;
  Data before;
  for (const ElementData& kind : kinds) {
    const auto at = find(*kind.data, name);
    tags.push_back(at != kind.data->end() ? to_tags(*at) : std::vector<int>());
    tags.back().resize(kind.tags->size(), 0);
    before.push_back({old_name, 1, std::vector<std::int32_t>(kind.tags->begin(), kind.tags->end())});
    kind.data->reserve(kind.data->size() + 1);
  }
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    kinds[k].tags->swap(tags[k]);
    if (tagged && !tags[k].empty()) kinds[k].data->push_back(std::move(before[k]));
  }
}

}  // namespace tetune
