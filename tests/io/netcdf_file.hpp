// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tetune::test {

/// A file of netCDF's classic format, which Exodus files can be of, without records: numbers are big-endian, names and
/// values are padded to 4 bytes.
class NetCdfFile {
 public:
  using Values = std::variant<std::string, std::vector<int>, std::vector<float>, std::vector<double>>;
  using Attributes = std::vector<std::pair<std::string, Values>>;

  /// `length` 0: the dimension of records.
  void add_dimension(const std::string& name, int length) { dimensions_.emplace_back(name, length); }
  void add_attribute(const std::string& name, const Values& values) { attributes_.emplace_back(name, values); }
  void add_variable(const std::string& name, const std::vector<std::string>& dimensions, const Values& values,
                    const Attributes& attributes = {}) {
    variables_.push_back({name, dimensions, values, attributes});
  }

  std::string bytes() const {
    const std::size_t header = written(0).size();
    std::string result = written(header);
    for (const Variable& variable : variables_) result += padded(bytes_of(variable.values));
    return result;
  }

 private:
  struct Variable {
    std::string name;
    std::vector<std::string> dimensions;
    Values values;
    Attributes attributes;
  };

  template <class Unsigned>
  static std::string big_endian(Unsigned value) {
    std::string result;
    for (int shift = 8 * static_cast<int>(sizeof value) - 8; shift >= 0; shift -= 8) {
      result += static_cast<char>((value >> shift) & 0xFF);
    }
    return result;
  }
  static std::string number(std::size_t value) { return big_endian(static_cast<std::uint32_t>(value)); }
  static std::string padded(std::string bytes) {
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    return bytes;
  }
  static std::string named(const std::string& name) { return number(name.size()) + padded(name); }
  /// The number of a list's kind and its length, 0 for an empty one.
  static std::string list(std::size_t kind, std::size_t length) {
    return number(length > 0 ? kind : 0) + number(length);
  }

  static std::size_t type_of(const Values& values) {
    constexpr std::size_t kTypes[]{2, 4, 5, 6};  // characters, int, float, double
    return kTypes[values.index()];
  }
  static std::size_t count(const Values& values) {
    return std::visit([](const auto& list) { return list.size(); }, values);
  }
  static std::string bytes_of(const Values& values) {
    std::string result;
    if (const auto* text = std::get_if<std::string>(&values)) return *text;
    if (const auto* ints = std::get_if<std::vector<int>>(&values)) {
      for (const int value : *ints) result += big_endian(static_cast<std::uint32_t>(value));
    } else if (const auto* floats = std::get_if<std::vector<float>>(&values)) {
      for (const float value : *floats) result += big_endian(std::bit_cast<std::uint32_t>(value));
    } else {
      for (const double value : std::get<std::vector<double>>(values)) {
        result += big_endian(std::bit_cast<std::uint64_t>(value));
      }
    }
    return result;
  }

  static std::string written(const Attributes& attributes) {
    std::string result = list(12, attributes.size());
    for (const auto& [name, values] : attributes) {
      result += named(name) + number(type_of(values)) + number(count(values)) + padded(bytes_of(values));
    }
    return result;
  }

  std::size_t number_of(const std::string& dimension) const {
    std::size_t i = 0;
    while (i < dimensions_.size() && dimensions_[i].first != dimension) ++i;
    return i;
  }

  /// All before the values, which begin at the byte `begin`.
  std::string written(std::size_t begin) const {
    std::string result = std::string("CDF\1") + number(0) + list(10, dimensions_.size());
    for (const auto& [name, length] : dimensions_) result += named(name) + number(static_cast<std::size_t>(length));
    result += written(attributes_) + list(11, variables_.size());
    for (const Variable& variable : variables_) {
      const std::size_t size = padded(bytes_of(variable.values)).size();
      result += named(variable.name) + number(variable.dimensions.size());
      for (const std::string& dimension : variable.dimensions) result += number(number_of(dimension));
      result += written(variable.attributes) + number(type_of(variable.values)) + number(size) + number(begin);
      begin += size;
    }
    return result;
  }

  std::vector<std::pair<std::string, int>> dimensions_;
  Attributes attributes_;
  std::vector<Variable> variables_;
};

}  // namespace tetune::test
