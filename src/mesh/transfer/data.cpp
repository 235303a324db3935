// SPDX-License-Identifier: Apache-2.0
// Data by the ids or the places of their vertices in another mesh.
#include "tetune/data.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "backend/span.hpp"
#include "mesh/transfer/check_ids.hpp"

namespace tetune {
namespace {

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

}  // namespace

std::vector<DataArray> take_entries(const std::vector<DataArray>& data, const std::vector<Index>& new2old) {
  check_not_negative(new2old, "new2old");
  std::vector<DataArray> result;
  result.reserve(data.size());
  for (const DataArray& array : data) result.push_back(gather(array, new2old));
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

}  // namespace tetune
