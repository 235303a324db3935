// SPDX-License-Identifier: Apache-2.0
// Which elements miss a target, and what holds them, against plain oracles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "support/meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

TargetReport run(TetMesh& mesh, Target target, Options options = {}) {
  options.targets = {target};
  const Report report = optimize(mesh, options);
  EXPECT_EQ(report.targets.size(), 1U);
  return report.targets.at(0);
}

std::int64_t held(const TargetReport& r, LimitingConstraint constraint) {
  return r.held_by[static_cast<std::size_t>(constraint)];
}

TEST(Targets, MissedAreThoseWhoseMeasureIsWorse) {
  const Target targets[] = {{Measure::min_dihedral, 40},  {Measure::max_dihedral, 100}, {Measure::mean_ratio, 0.8},
                            {Measure::sicn, 0.8},         {Measure::gamma, 0.8},        {Measure::scaled_jacobian, 0.6},
                            {Measure::radius_ratio, 1.3}, {Measure::aspect_ratio, 1.7}, {Measure::harmonic, 0.85}};
  ASSERT_EQ(std::size(targets), kMeasures);
  for (const Target& target : targets) {
    TetMesh m = test::scrambled(test::cube(5, 0.3), 2, 3);
    const TargetReport r = run(m, target);
    const std::vector<Measures> all = measure_each(m);
    std::vector<std::pair<double, Index>> missed;  // worst first
    const double sign = larger_is_better(target.measure) ? 1 : -1;
    for (std::size_t t = 0; t < all.size(); ++t) {
      const double value = all[t][static_cast<std::size_t>(target.measure)];
      if (sign * value < sign * target.value) missed.emplace_back(sign * value, static_cast<Index>(t));
    }
    std::sort(missed.begin(), missed.end());
    EXPECT_GT(missed.size(), 0U) << to_string(target.measure);
    EXPECT_LT(missed.size(), all.size()) << to_string(target.measure);
    EXPECT_EQ(r.missed, static_cast<std::int64_t>(missed.size()));
    EXPECT_EQ(r.tets, static_cast<std::int64_t>(m.tets.size()));
    EXPECT_FALSE(r.met());
    EXPECT_EQ(std::accumulate(r.held_by.begin(), r.held_by.end(), std::int64_t{0}), r.missed);
    ASSERT_EQ(r.worst.size(), missed.size());
    for (std::size_t i = 0; i < missed.size(); ++i) {
      EXPECT_EQ(r.worst[i].tet, missed[i].second);
      EXPECT_EQ(r.worst[i].value, sign * missed[i].first);
      const Point3 centroid = test::centroid(m, static_cast<std::size_t>(r.worst[i].tet));
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(r.worst[i].centroid[k], centroid[k], 1e-15);
    }
  }
}

TEST(Targets, OnlyTheWorstAreListed) {
  TetMesh m = test::cube(8, 0.2);
  const TargetReport r = run(m, {Measure::min_dihedral, 70.5});
  EXPECT_GT(r.missed, 2 * static_cast<std::int64_t>(kMaxMissed));
  ASSERT_EQ(r.worst.size(), kMaxMissed);
  std::vector<double> angles;
  for (const Measures& each : measure_each(m)) angles.push_back(each[static_cast<std::size_t>(Measure::min_dihedral)]);
  std::sort(angles.begin(), angles.end());
  for (std::size_t i = 0; i < kMaxMissed; ++i) EXPECT_EQ(r.worst[i].value, angles[i]);
}

/// A unit cube has no small angle of its own: what holds an element follows from where its vertices are.
TEST(Targets, TheStrongestConstraintIsNamed) {
  for (const Boundary boundary : {Boundary::preserve, Boundary::slide, Boundary::fixed}) {
    TetMesh m = test::two_materials(4, 0.2);
    m.required_vertices = {62};  // inside
    Options options;
    options.boundary = boundary;
    const TargetReport r = run(m, {Measure::min_dihedral, 70.5}, options);
    ASSERT_LT(r.missed, static_cast<std::int64_t>(kMaxMissed));
    for (const MissedTet& missed : r.worst) {
      int fixed = 0;
      int surface = 0;
      LimitingConstraint constraint = LimitingConstraint::none;
      for (const Index v : m.tets[static_cast<std::size_t>(missed.tet)]) {
        const Point3& p = m.points[static_cast<std::size_t>(v)];
        int sides = 0;
        for (const double x : p) sides += x == 0 || x == 1 ? 1 : 0;
        const bool interface = p[0] == 0.5;
        const bool is_frozen = v == 62;
        // At the interface's rim the surface has an edge, at its corners three meet.
        const int planes = sides + (interface ? 1 : 0);
        surface += planes > 0 ? 1 : 0;
        const bool is_fixed = is_frozen || planes == 3 || (planes > 0 && boundary == Boundary::fixed);
        fixed += is_fixed ? 1 : 0;
        const LimitingConstraint mine =
            is_frozen     ? LimitingConstraint::frozen_vertex
            : planes == 0 ? LimitingConstraint::none
            : boundary == Boundary::fixed
                ? (interface ? LimitingConstraint::region_interface : LimitingConstraint::boundary)
            : planes == 3 ? LimitingConstraint::feature_corner
            : planes == 2 ? LimitingConstraint::feature_line
            : interface   ? LimitingConstraint::region_interface
                          : LimitingConstraint::boundary;
        constraint = std::min(constraint, mine);
      }
      if (fixed == 4) {
        constraint = LimitingConstraint::fixed_vertices;
      } else if (surface == 4) {
        constraint = LimitingConstraint::surface_element;
      }
      EXPECT_EQ(missed.held_by, constraint)
          << to_string(missed.held_by) << " for " << to_string(constraint) << ", tetrahedron " << missed.tet;
    }
    for (const LimitingConstraint constraint :
         {LimitingConstraint::frozen_vertex, LimitingConstraint::region_interface, LimitingConstraint::boundary})
      EXPECT_GT(held(r, constraint), 0);
    EXPECT_EQ(held(r, LimitingConstraint::surface_angle), 0);
    EXPECT_GT(
        held(r, boundary == Boundary::fixed ? LimitingConstraint::fixed_vertices : LimitingConstraint::feature_line),
        0);
  }
}

TEST(Targets, RequiredElementsAndFrozenRegionsAreLocked) {
  TetMesh m = test::two_materials(4, 0.2);
  m.required_tets = {5};
  Options options;
  options.frozen_regions = {2};
  const TargetReport r = run(m, {Measure::min_dihedral, 70.5}, options);
  ASSERT_EQ(m.tet_tags[static_cast<std::size_t>(m.required_tets[0])], 1);
  EXPECT_EQ(held(r, LimitingConstraint::locked_element), 1 + std::count(m.tet_tags.begin(), m.tet_tags.end(), 2));
  for (const MissedTet& missed : r.worst) {
    const bool locked = m.tet_tags[static_cast<std::size_t>(missed.tet)] == 2 || missed.tet == m.required_tets[0];
    EXPECT_EQ(missed.held_by == LimitingConstraint::locked_element, locked);
  }
}

/// A cube sheared to a wedge of atan(1 / 4) along two of its edges.
TEST(Targets, TheAngleOfTheSurfaceIsTheProof) {
  const double wedge = std::atan(0.25) * 180 / std::numbers::pi;
  for (const double angle : {12.0, 20.0}) {
    for (const Boundary boundary : {Boundary::preserve, Boundary::fixed}) {
      TetMesh m = test::sheared(test::scrambled(test::cube(4), 2, 7), 4);
      Options options;
      options.boundary = boundary;
      const TargetReport r = run(m, {Measure::min_dihedral, angle}, options);
      ASSERT_EQ(r.worst.size(), static_cast<std::size_t>(r.missed));
      // By hand: elements with an edge on one of the two lines.
      const auto on_line = [&m](Index v) {
        const Point3& p = m.points[static_cast<std::size_t>(v)];
        return p[1] == 0 && p[0] == 0 ? 1 : p[1] == 1 && p[0] == 5 ? 2 : 0;
      };
      for (const MissedTet& missed : r.worst) {
        int at[3] = {0, 0, 0};
        for (const Index v : m.tets[static_cast<std::size_t>(missed.tet)]) ++at[on_line(v)];
        const bool sharp = at[1] == 2 || at[2] == 2;
        EXPECT_EQ(missed.held_by == LimitingConstraint::surface_angle, sharp && angle > wedge);
        if (missed.held_by != LimitingConstraint::surface_angle) continue;
        EXPECT_NEAR(missed.surface_angle, wedge, 1e-10);
        EXPECT_NE(on_line(missed.edge[0]), 0);
        EXPECT_EQ(on_line(missed.edge[0]), on_line(missed.edge[1]));
        const auto& tet = m.tets[static_cast<std::size_t>(missed.tet)];
        for (const Index v : missed.edge) EXPECT_EQ(std::count(tet.begin(), tet.end(), v), 1);
      }
      EXPECT_EQ(held(r, LimitingConstraint::surface_angle) > 0, angle > wedge);
    }
  }
}

/// (2 sqrt(2) sin a / (3 - cos a))^(2/3) bounds three more measures; of the right-angled tetrahedron it is 0.9686 at
/// its smallest angle, 54.74 degrees.
TEST(Targets, TheAngleBoundsMoreThanAngles) {
  for (const Measure measure : {Measure::mean_ratio, Measure::sicn, Measure::harmonic}) {
    TetMesh m = test::one_tet();
    EXPECT_EQ(run(m, {measure, 0.9687}).worst.at(0).held_by, LimitingConstraint::surface_angle) << to_string(measure);
    EXPECT_EQ(run(m, {measure, 0.9685}).worst.at(0).held_by, LimitingConstraint::fixed_vertices) << to_string(measure);
  }
  TetMesh m = test::one_tet();
  EXPECT_EQ(run(m, {Measure::min_dihedral, 54.74}).worst.at(0).held_by, LimitingConstraint::surface_angle);
  EXPECT_TRUE(run(m, {Measure::min_dihedral, 54.73}).met());
  EXPECT_EQ(run(m, {Measure::gamma, 1}).worst.at(0).held_by, LimitingConstraint::fixed_vertices);
}

TEST(Targets, NoElementDoesBetterThanItsAngleAllows) {
  const TetMesh m = test::sheared(test::cube(6, 0.35, 5), 1.5);
  for (const Measures& each : measure_each(m)) {
    const double a = each[static_cast<std::size_t>(Measure::min_dihedral)] * std::numbers::pi / 180;
    const double bound = std::cbrt(std::pow(std::sqrt(8.0) * std::sin(a) / (3 - std::cos(a)), 2));
    for (const Measure measure : {Measure::mean_ratio, Measure::sicn, Measure::harmonic}) {
      EXPECT_LE(each[static_cast<std::size_t>(measure)], bound * (1 + 1e-12));
    }
  }
  // It is attained: an edge of length sqrt(2) h, and another one across it, at the distance h cos(a / 2).
  const double a = 0.3;
  const double e = std::sqrt(1 + std::pow(std::sin(a / 2), 2)) / 2;
  TetMesh one = test::one_tet();
  one.points = {{0, 0, -e}, {0, 0, e}, {std::cos(a / 2), -std::sin(a / 2), 0}, {std::cos(a / 2), std::sin(a / 2), 0}};
  const double best = std::cbrt(std::pow(std::sqrt(8.0) * std::sin(a) / (3 - std::cos(a)), 2));
  EXPECT_NEAR(measure_each(one)[0][static_cast<std::size_t>(Measure::mean_ratio)], best, 1e-12);
}

TEST(Targets, ChangeNothingAndAreTheSameForAnyNumberOfThreads) {
  const TetMesh before = test::scrambled(test::two_materials(6, 0.3), 2, 5);
  TetMesh plain = before;
  optimize(plain);
  TargetReport first;
  for (const int threads : {1, 2, 4}) {
    TetMesh m = before;
    Options options;
    options.threads = threads;
    const TargetReport r = run(m, {Measure::mean_ratio, 0.8}, options);
    EXPECT_EQ(m.points, plain.points);
    EXPECT_EQ(m.tets, plain.tets);
    if (threads == 1) first = r;
    EXPECT_EQ(r.held_by, first.held_by);
    ASSERT_EQ(r.worst.size(), first.worst.size());
    for (std::size_t i = 0; i < r.worst.size(); ++i) {
      EXPECT_EQ(r.worst[i].tet, first.worst[i].tet);
      EXPECT_EQ(r.worst[i].held_by, first.worst[i].held_by);
    }
  }
}

TEST(Targets, WhatAllMeetOrNoneCanIsRefused) {
  const auto refused = [](Measure measure, double value) {
    TetMesh m = test::one_tet();
    Options options;
    options.targets = {{measure, value}};
    try {
      optimize(m, options);
    } catch (const OptionError& e) {
      return std::string(e.what()).find(to_string(measure)) != std::string::npos;
    }
    return false;
  };
  for (const Measure measure :
       {Measure::mean_ratio, Measure::sicn, Measure::gamma, Measure::scaled_jacobian, Measure::harmonic}) {
    for (const double value : {-1.0, 0.0, 1.001, std::nan("")}) EXPECT_TRUE(refused(measure, value)) << value;
    EXPECT_FALSE(refused(measure, 1));
  }
  for (const Measure measure : {Measure::radius_ratio, Measure::aspect_ratio}) {
    for (const double value : {-1.0, 0.999, 1e30, HUGE_VAL}) EXPECT_TRUE(refused(measure, value)) << value;
    EXPECT_FALSE(refused(measure, 1));
  }
  for (const double value : {0.0, 70.53, -5.0}) EXPECT_TRUE(refused(Measure::min_dihedral, value));
  for (const double value : {70.52, 180.0, -5.0}) EXPECT_TRUE(refused(Measure::max_dihedral, value));
  EXPECT_FALSE(refused(Measure::min_dihedral, 70.52));
  EXPECT_FALSE(refused(Measure::max_dihedral, 70.53));
}

}  // namespace
}  // namespace tetune
