// SPDX-License-Identifier: Apache-2.0
#include "mesh/transfer/conserve.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "mesh/transfer/bounded_projection.hpp"
#include "mesh/transfer/projection_sums.hpp"
#include "mesh/transfer/tet_overlaps.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// A floating-point component of data of the vertices.
struct Field {
  std::size_t array;
  Size component;
};

/// Calls f(values) with the vector of an array if it is of a floating-point type.
template <class Array, class F>
void if_floating(Array& array, const F& f) {
  std::visit(
      [&](auto& values) {
        using T = typename std::remove_cvref_t<decltype(values)>::value_type;
        if constexpr (std::is_floating_point_v<T>) f(values);
      },
      array.values);
}

/// The entries of one component.
std::vector<double> component_of(const DataArray& array, Size component) {
  std::vector<double> result;
  if_floating(array, [&](const auto& values) {
    for (Size i = component; i < std::ssize(values); i += array.components) result.push_back(span_of(values)[i]);
  });
  return result;
}

bool all_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

/// The components of all floating-point data that are finite, one after the other for each vertex.
std::pair<std::vector<Field>, std::vector<double>> projected_fields(const std::vector<DataArray>& data, Size vertices) {
  std::vector<Field> fields;
  std::vector<std::vector<double>> columns;
  for (std::size_t a = 0; a < data.size(); ++a) {
    for (Size c = 0; c < data[a].components; ++c) {
      std::vector<double> column = component_of(data[a], c);
      if (column.empty() || !all_finite(column)) continue;
      fields.push_back({a, c});
      columns.push_back(std::move(column));
    }
  }
  std::vector<double> values;
  values.reserve(columns.size() * to_size_t(vertices));
  for (Size v = 0; v < vertices; ++v) {
    for (const std::vector<double>& column : columns) values.push_back(span_of(column)[v]);
  }
  return {fields, values};
}

/// Replaces a component by the projected one, unless it has overflowed.
void project(BoundedProjection& projection, Size index, const Field& field, const DataArray& old, DataArray& array) {
  std::vector<double> values = component_of(array, field.component);
  projection.project(index, component_of(old, field.component), values);
  if (!all_finite(values)) return;
  if_floating(array, [&](auto& to) {
    using T = typename std::remove_cvref_t<decltype(to)>::value_type;
    Size i = field.component;
    for (const double x : values) {
      span_of(to)[i] = T(x);
      i += array.components;
    }
  });
}

/// The tetrahedra of the input that contribute to one of the result, with the volumes that they give.
class Contributions {
 public:
  explicit Contributions(const TetOverlaps& overlaps) : overlaps_(overlaps), uncovered_tets_(overlaps.uncovered_tets) {
    std::stable_sort(uncovered_tets_.begin(), uncovered_tets_.end(),
                     [](const auto& a, const auto& b) { return a.second < b.second; });
  }

  /// Calls visit(old, volume): over all entries, each tetrahedron of the input gives its volume.
  template <class Visit>
  void for_each(Size entry, const Visit& visit) const {
    for (Size p = span_of(overlaps_.offsets)[entry]; p < span_of(overlaps_.offsets)[entry + 1]; ++p) {
      const Index old = span_of(overlaps_.old)[p];
      visit(old, span_of(overlaps_.volumes)[p] / span_of(overlaps_.covered)[old]);
    }
    auto tet = std::lower_bound(uncovered_tets_.begin(), uncovered_tets_.end(), entry,
                                [](const auto& item, Size e) { return item.second < e; });
    for (; tet != uncovered_tets_.end() && tet->second == entry; ++tet) {
      visit(tet->first, span_of(overlaps_.old_volumes)[tet->first]);
    }
  }

  /// The one of the largest volume, or -1.
  Index largest(Size entry) const {
    Index found = -1;
    double most = 0;
    for_each(entry, [&](Index old, double volume) {
      if (volume < most || (volume == most && old > found)) return;
      most = volume;
      found = old;
    });
    return found;
  }

 private:
  const TetOverlaps& overlaps_;
  std::vector<std::pair<Index, Size>> uncovered_tets_;
};

/// Sets the values of a changed tetrahedron, which are those of the largest contribution before, to the means over all
/// contributions.
template <class T>
void set_means(const std::vector<T>& from, Size components, const Contributions& contributions, Size entry, T* to) {
  for (Size c = 0; c < components; ++c) {
    double sum = 0;
    double volume = 0;
    T low = to[c];
    T high = to[c];
    contributions.for_each(entry, [&](Index old, double v) {
      const T x = span_of(from)[old * components + c];
      sum += v * double{x};
      volume += v;
      low = std::min(low, x);
      high = std::max(high, x);
    });
    const double mean = sum / volume;
    if (std::isfinite(mean)) to[c] = std::clamp(T(mean), low, high);
  }
}

std::vector<DataArray> conserved_tet_data(const backend::Cpu& cpu, const std::vector<DataArray>& data,
                                          const std::vector<Index>& tet2original, const TetOverlaps& overlaps) {
  const Contributions contributions(overlaps);
  std::vector<Index> sources = tet2original;
  cpu.for_each(std::ssize(overlaps.tets), [&](Size entry) {
    const Index largest = contributions.largest(entry);
    if (largest >= 0) span_of(sources)[span_of(overlaps.tets)[entry]] = largest;
  });
  std::vector<DataArray> result = take_entries(data, sources);
  for (std::size_t a = 0; a < data.size(); ++a) {
    const Size components = data[a].components;
    if_floating(result[a], [&](auto& to) {
      const auto& from = std::get<std::remove_cvref_t<decltype(to)>>(data[a].values);
      cpu.for_each(std::ssize(overlaps.tets), [&](Size entry) {
        set_means(from, components, contributions, entry, &span_of(to)[span_of(overlaps.tets)[entry] * components]);
      });
    });
  }
  return result;
}

/// Throws MeshError if an array has no entry for an element.
void check_length(const std::vector<DataArray>& data, std::size_t elements) {
  if (elements > 0) take_entries(data, {to_index(elements - 1)});
}

/// Throws MeshError unless all ids are in [0, size).
void check_ids(std::span<const Index> ids, std::size_t size, const char* what) {
  for (const Index id : ids) {
    if (id >= 0 && to_size_t(id) < size) continue;
    throw MeshError(std::string(what) + " have the id " + std::to_string(id) + "; there are " + std::to_string(size));
  }
}

}  // namespace

std::optional<ConservedData> conserve_data_until_stopped(const backend::Cpu& cpu, const TetMesh& input,
                                                         const std::vector<std::array<Index, 4>>& tets,
                                                         const std::vector<Index>& tet2original,
                                                         const std::vector<MeshPlace>& places) {
  if (tet2original.size() != tets.size()) {
    throw MeshError("tet2original has " + std::to_string(tet2original.size()) + " entries; it must have one for each " +
                    "of the " + std::to_string(tets.size()) + " tetrahedra");
  }
  check_length(input.point_data, input.points.size());
  check_length(input.tet_data, input.tets.size());
  if (input.tet_tags.size() != input.tets.size()) {
    throw MeshError("the input has " + std::to_string(input.tet_tags.size()) + " tags for " +
                    std::to_string(input.tets.size()) + " tetrahedra");
  }
  for (const auto& tet : input.tets) check_ids(tet, input.points.size(), "tetrahedra of the input");
  check_ids(tet2original, input.tets.size(), "originals of tetrahedra");
  for (const auto& tet : tets) check_ids(tet, places.size(), "places of vertices");
  for (const MeshPlace& place : places) check_ids(place.vertices, input.points.size(), "vertices of the input");
  const TransferMeshes meshes(input, tets, tet2original, places);
  const auto [fields, values] = projected_fields(input.point_data, std::ssize(input.points));
  ProjectionSums sums(meshes, span_of(values), std::ssize(fields));
  const bool projects = !fields.empty();
  const std::optional<TetOverlaps> found = find_overlaps(
      cpu, meshes, projects ? Moments::computed : Moments::omitted,
      [&](const std::vector<Index>& changed) {
        if (projects) sums.begin(changed);
      },
      [&](Size entry, Index old, const TetOverlap& common) {
        if (projects) sums.add(entry, old, common);
      });
  if (!found) return std::nullopt;
  const TetOverlaps& overlaps = *found;
  ConservedData result{interpolate_point_data(input.point_data, places),
                       conserved_tet_data(cpu, input.tet_data, tet2original, overlaps), overlaps.uncovered};
  if (!projects) return result;
  sums.complete(overlaps);
  BoundedProjection projection(cpu, meshes, overlaps, sums);
  for (Size f = 0; f < std::ssize(fields); ++f) {
    if (cpu.stop_requested()) return std::nullopt;
    const Field& field = span_of(fields)[f];
    project(projection, f, field, input.point_data[field.array], result.point_data[field.array]);
  }
  return result;
}

ConservedData conserve_data(const TetMesh& input, const std::vector<std::array<Index, 4>>& tets,
                            const std::vector<Index>& tet2original, const std::vector<MeshPlace>& places, int threads) {
  return *conserve_data_until_stopped(backend::Cpu(threads), input, tets, tet2original, places);
}

}  // namespace tetune
