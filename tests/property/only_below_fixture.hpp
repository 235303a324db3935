// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <variant>
#include <vector>

#include "backend/span.hpp"
#include "tetune/options.hpp"
#include "tetune/quality.hpp"
#include "tetune/report.hpp"

/// Options::only_below: the active tetrahedra by the definition, and what must stay outside them.
namespace tetune::test {

inline bool is_bad(const Measures& m, const Target& limit) {
  const double value = m[static_cast<std::size_t>(limit.measure)];
  return larger_is_better(limit.measure) ? value < limit.value : value > limit.value;
}

/// The number of tetrahedra that miss a limit.
inline std::int64_t count_missing(const TetMesh& mesh, const Target& limit) {
  const std::vector<Measures> measures = measure_each(mesh);
  return std::count_if(measures.begin(), measures.end(), [&](const Measures& m) { return is_bad(m, limit); });
}

/// The active tetrahedra by the definition, one ring after the other.
inline std::vector<bool> active_by_definition(const TetMesh& mesh, const Options& options) {
  std::vector<bool> active;
  for (const Measures& m : measure_each(mesh)) {
    active.push_back(std::any_of(options.only_below.begin(), options.only_below.end(),
                                 [&](const Target& limit) { return is_bad(m, limit); }));
  }
  for (const Index t : mesh.required_tets) active[to_size_t(t)] = false;
  for (int ring = 0; ring < options.rings; ++ring) {
    std::set<Index> vertices;
    for (std::size_t t = 0; t < active.size(); ++t) {
      if (active[t]) vertices.insert(mesh.tets[t].begin(), mesh.tets[t].end());
    }
    for (std::size_t t = 0; t < active.size(); ++t) {
      for (const Index v : mesh.tets[t]) active[t] = active[t] || vertices.count(v) == 1;
    }
  }
  return active;
}

template <class T>
T entry(const DataArray& data, std::size_t i) {
  return std::get<std::vector<T>>(data.values)[i];
}

/// Checks that what is not active has stayed, and that the maps are true.
inline void expect_rest_unchanged(const TetMesh& before, const TetMesh& after, const std::vector<bool>& active,
                                  const Report& report) {
  // Vertices keep their numbers, and outside the active part their positions.
  ASSERT_GE(after.points.size(), before.points.size());
  for (std::size_t t = 0; t < before.tets.size(); ++t) {
    if (active[t]) continue;
    for (const Index v : before.tets[t]) {
      EXPECT_EQ(before.points[to_size_t(v)], after.points[to_size_t(v)]);
      EXPECT_EQ(before.point_tags[to_size_t(v)], after.point_tags[to_size_t(v)]);
    }
  }
  ASSERT_EQ(report.tet2original.size(), after.tets.size());
  std::vector<std::size_t> rest_before;
  std::vector<std::size_t> rest_after;
  for (std::size_t t = 0; t < before.tets.size(); ++t) {
    if (!active[t]) rest_before.push_back(t);
  }
  for (std::size_t t = 0; t < after.tets.size(); ++t) {
    const std::size_t original = to_size_t(report.tet2original[t]);
    EXPECT_EQ(after.tet_tags[t], before.tet_tags[original]);
    EXPECT_EQ(entry<double>(after.tet_data[0], t), entry<double>(before.tet_data[0], original));
    if (!active[original]) rest_after.push_back(t);
  }
  ASSERT_EQ(rest_before.size(), rest_after.size());
  for (std::size_t i = 0; i < rest_before.size(); ++i) {
    EXPECT_EQ(before.tets[rest_before[i]], after.tets[rest_after[i]]);
    if (after.tets.size() >= before.tets.size()) {
      EXPECT_EQ(rest_before[i], rest_after[i]);
    }
  }
  for (std::size_t v = 0; v < after.points.size(); ++v) {
    const bool inserted = !report.vertex2original.empty() && report.vertex2original[v] < 0;
    if (inserted) continue;
    EXPECT_EQ(report.vertex2original.empty() ? v : to_size_t(report.vertex2original[v]), v);
    EXPECT_EQ(entry<double>(after.point_data[0], v), entry<double>(before.point_data[0], v));
  }
}

inline void number_data(TetMesh& mesh) {
  const auto numbers = [](std::size_t size, double first) {
    std::vector<double> values;
    for (std::size_t i = 0; i < size; ++i) values.push_back(first + static_cast<double>(i));
    return DataArray{"number", 1, values};
  };
  mesh.point_data = {numbers(mesh.points.size(), 0.5)};
  mesh.tet_data = {numbers(mesh.tets.size(), 0.25)};
}

/// The value of a measure that a part of the tetrahedra miss.
inline double limit_missed_by(const TetMesh& mesh, double part, Measure measure = Measure::mean_ratio) {
  std::vector<double> values;
  for (const Measures& m : measure_each(mesh)) values.push_back(m[static_cast<std::size_t>(measure)]);
  std::sort(values.begin(), values.end());
  if (!larger_is_better(measure)) std::reverse(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size()))];
}

}  // namespace tetune::test
