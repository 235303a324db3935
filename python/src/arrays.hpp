// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "tetune/error.hpp"
#include "tetune/mesh.hpp"

namespace tetune::python {

namespace nb = nanobind;

/// Anything numpy makes an array of, in any layout; a copy where its byte order is not that of the processor.
inline nb::ndarray<nb::ro, nb::device::cpu> as_array(const char* name, nb::handle object) {
  nb::object array = nb::module_::import_("numpy").attr("asarray")(object);
  nb::ndarray<nb::ro, nb::device::cpu> view;
  const nb::object type = array.attr("dtype");
  if (!nb::cast<bool>(type.attr("isnative"))) array = array.attr("astype")(type.attr("newbyteorder")("="));
  const std::string kind = nb::str(type.attr("kind")).c_str();
  if (kind.find_first_of("fiu") == std::string::npos || !nb::try_cast(array, view)) {
    throw nb::type_error(
        (std::string(name) + " must be an array of numbers; its type is " + nb::str(type).c_str()).c_str());
  }
  return view;
}

/// Whether T holds the value; NaN and fractions never get here for integers.
template <class T, class S>
bool fits(S value) {
  if constexpr (std::is_floating_point_v<T>) {
    return true;
  } else {
    return std::in_range<T>(value);
  }
}

template <class T, class S>
void copy_as(const char* name, const nb::ndarray<nb::ro, nb::device::cpu>& from, std::size_t columns, T* to) {
  const S* data = static_cast<const S*>(from.data());
  const std::int64_t next_row = from.stride(0);
  const std::int64_t next_column = from.ndim() == 2 ? from.stride(1) : 0;
  for (std::size_t row = 0; row < from.shape(0); ++row) {
    const S* at = data + static_cast<std::int64_t>(row) * next_row;
    for (std::size_t column = 0; column < columns; ++column, at += next_column, ++to) {
      if (!fits<T>(*at)) {
        throw MeshError(std::string(name) + " has " + std::to_string(*at) + " in row " + std::to_string(row) +
                        "; it must fit in 32 bits");
      }
      *to = static_cast<T>(*at);
    }
  }
}

/// Copies an array, of shape (n, columns) or for one column (n,), into one of ours: the only copy on the way in.
/// Throws TypeError for a type of numbers that would lose something, ValueError for another shape.
template <class T>
void copy_array(const char* name, const nb::ndarray<nb::ro, nb::device::cpu>& from, std::size_t columns, T* to) {
  const nb::dlpack::dtype type = from.dtype();
  const auto is = [&type]<class S>(S) { return type == nb::dtype<S>(); };
  const auto copy = [&]<class S>(S) { copy_as<T, S>(name, from, columns, to); };
  if constexpr (std::is_floating_point_v<T>) {
    if (is(double{})) return copy(double{});
    if (is(float{})) return copy(float{});
  }
  if (is(std::int32_t{})) return copy(std::int32_t{});
  if (is(std::int64_t{})) return copy(std::int64_t{});
  if (is(std::uint32_t{})) return copy(std::uint32_t{});
  if (is(std::uint64_t{})) return copy(std::uint64_t{});
  if (is(std::int16_t{})) return copy(std::int16_t{});
  if (is(std::uint16_t{})) return copy(std::uint16_t{});
  if (is(std::int8_t{})) return copy(std::int8_t{});
  if (is(std::uint8_t{})) return copy(std::uint8_t{});
  throw nb::type_error((std::string(name) + " must be an array of " +
                        (std::is_floating_point_v<T> ? "float64, float32 or integers" : "integers, for example int64"))
                           .c_str());
}

inline void check_shape(const char* name, const nb::ndarray<nb::ro, nb::device::cpu>& array, std::size_t columns) {
  const bool empty = array.size() == 0;
  if (empty || (columns == 1 && array.ndim() == 1) || (array.ndim() == 2 && array.shape(1) == columns)) return;
  std::string shape;
  for (std::size_t d = 0; d < array.ndim(); ++d) shape += (d > 0 ? ", " : "") + std::to_string(array.shape(d));
  throw nb::value_error((std::string(name) + " has the shape (" + shape + "); it must be " +
                         (columns == 1 ? "(n,)" : "(n, " + std::to_string(columns) + ")"))
                            .c_str());
}

template <class T, std::size_t N>
void assign(const char* name, nb::handle object, std::vector<std::array<T, N>>& to) {
  if (object.is_none()) return;
  const auto array = as_array(name, object);
  check_shape(name, array, N);
  if (array.size() == 0) return;
  to.resize(array.shape(0));
  copy_array(name, array, N, to.data()->data());
}

template <class T>
void assign(const char* name, nb::handle object, std::vector<T>& to) {
  if (object.is_none()) return;
  const auto array = as_array(name, object);
  check_shape(name, array, 1);
  if (array.size() == 0) return;
  to.resize(array.shape(0));
  copy_array(name, array, 1, to.data());
}

/// A view of an array of ours, which keeps its owner alive.
template <class T, std::size_t N>
auto view(std::vector<std::array<T, N>>& of, nb::handle owner) {
  return nb::ndarray<nb::numpy, T, nb::shape<-1, static_cast<nb::ssize_t>(N)>>(of.data(), {of.size(), N}, owner);
}
template <class T>
auto view(std::vector<T>& of, nb::handle owner) {
  return nb::ndarray<nb::numpy, T, nb::shape<-1>>(of.data(), {of.size()}, owner);
}

/// The owner of the memory that a numpy array refers to.
template <class T>
nb::capsule owner_of(std::vector<T>* values) {
  return {values, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); }};
}

}  // namespace tetune::python
