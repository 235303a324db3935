// SPDX-License-Identifier: Apache-2.0
#include "option_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "tetune/error.hpp"

namespace tetune::cli {
namespace {

double diagonal(const TetMesh& mesh) {
  if (mesh.points.empty()) return 0;
  Point3 low = mesh.points[0];
  Point3 high = low;
  for (const Point3& p : mesh.points) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

}  // namespace

double parse_length(const std::string& option, const std::string& text, const TetMesh& mesh) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value);
  const bool percent = error == std::errc() && at + 1 == end && *at == '%';
  if (error != std::errc() || (at != end && !percent) || !(value > 0) || !std::isfinite(value)) {
    throw OptionError(fmt::format(
        "{}: '{}' is not a length; give a positive number in the mesh's unit, or one with % for a part of the "
        "bounding box's diagonal",
        option, text));
  }
  return percent ? value / 100 * diagonal(mesh) : value;
}

Measure parse_measure(const std::string& option, const std::string& name) {
  std::string known;
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const auto measure = static_cast<Measure>(k);
    if (name == to_string(measure)) return measure;
    known += fmt::format("{}{}", k == 0 ? "" : ", ", to_string(measure));
  }
  throw OptionError(fmt::format("{}: '{}' is not a measure; there are {}", option, name, known));
}

Target parse_bound(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string number = equals == std::string::npos ? text : text.substr(equals + 1);
  Target target{Measure::mean_ratio, 0};
  if (equals != std::string::npos) target.measure = parse_measure("--min-quality", text.substr(0, equals));
  const char* end = number.data() + number.size();
  const auto [at, error] = std::from_chars(number.data(), end, target.value);
  if (error != std::errc() || at != end || !std::isfinite(target.value)) {
    throw OptionError(fmt::format(
        "--min-quality: '{}' is not understood; give a number, or a measure and a number as min_dihedral_deg=10",
        text));
  }
  return target;
}

void parse_freeze(const std::string& text, Options& options) {
  std::vector<int>* tags = nullptr;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::string item = text.substr(begin, end - begin);
    begin = end + 1;
    if (item.starts_with("tag=")) {
      tags = &options.frozen_regions;
      item.erase(0, std::strlen("tag="));
    } else if (item.starts_with("patch=")) {
      tags = &options.frozen_patches;
      item.erase(0, std::strlen("patch="));
    }
    int tag = 0;
    const auto [at, error] = std::from_chars(item.data(), item.data() + item.size(), tag);
    if (tags == nullptr || error != std::errc() || at != item.data() + item.size()) {
      throw OptionError(fmt::format(
          "--freeze: '{}' is not understood; give the tags of regions as tag=1,2 and those of patches as patch=3,4",
          text));
    }
    tags->push_back(tag);
  }
}

}  // namespace tetune::cli
