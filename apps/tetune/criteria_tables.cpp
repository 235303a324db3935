// SPDX-License-Identifier: Apache-2.0
// Tables of targets and acceptance criteria.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "option_flags.hpp"
#include "tables.hpp"

namespace tetune::cli {
namespace {

/// The constraint of an element, in words.
std::string constraint_text(const MissedTet& m) {
  if (m.held_by != LimitingConstraint::surface_angle) return to_string(m.held_by);
  return fmt::format("surface: {:.3f} deg at edge {} {}", m.surface_angle, m.edge[0] + 1, m.edge[1] + 1);
}

/// One line per constraint that holds elements.
std::string held_by_lines(const std::array<std::int64_t, kLimitingConstraints>& held_by) {
  std::string text;
  for (std::size_t k = 0; k < kLimitingConstraints; ++k) {
    if (held_by[k] == 0) continue;
    text += fmt::format("    {:>9} held by: {}\n", held_by[k], to_string(static_cast<LimitingConstraint>(k)));
  }
  return text;
}

std::string limit_text(const std::optional<double>& value) { return value ? fmt::format("{:.6g}", *value) : "-"; }

std::string place_of_worst(const CriterionResult& r) {
  if (r.worst_tet < 0) return "-";
  return fmt::format("{} at {:.6g} {:.6g} {:.6g}", r.worst_tet + 1, r.centroid[0], r.centroid[1], r.centroid[2]);
}

}  // namespace

std::string target_table(const TargetReport& r) {
  const Measure measure = r.target.measure;
  std::string text =
      fmt::format("  target: {} {} {}: ", to_string(measure), larger_is_better(measure) ? ">=" : "<=", r.target.value);
  if (r.met()) return text + "met by all\n";
  text += fmt::format("NOT met by {} of {}\n", r.missed, r.tets);
  text += held_by_lines(r.held_by);
  constexpr std::size_t kShown = 10;
  text += fmt::format("  {:<22}{:>12}    {:<36}centroid\n", "worst, counted from 1", to_string(measure), "held by");
  for (std::size_t i = 0; i < std::min(kShown, r.worst.size()); ++i) {
    const MissedTet& m = r.worst[i];
    text += fmt::format("  {:<22}{:>12}    {:<36}{:.6g} {:.6g} {:.6g}\n", m.tet + 1, format_value(measure, m.value),
                        constraint_text(m), m.centroid[0], m.centroid[1], m.centroid[2]);
  }
  return text;
}

std::string acceptance_table(const std::string& title, const AcceptanceReport& report, const std::string& note) {
  std::string text = fmt::format("  {} by {}: {}{}\n", title, report.name, to_string(report.verdict), note);
  text += fmt::format("  {:<22}{:>8}{:>14}{:>14}{:>14}{:>10}{:>10}{:>10}    {}\n", "criterion", "verdict", "worst",
                      "warn", "fail", "warned", "failed", "allowed", "worst tetrahedron, from 1");
  for (const CriterionResult& r : report.results) {
    const AcceptanceCriterion& c = r.criterion;
    text += fmt::format("  {:<22}{:>8}{:>14.6g}{:>14}{:>14}{:>10}{:>10}{:>10}    {}\n", info_of(c.measure).name,
                        to_string(r.verdict), r.worst, limit_text(c.warn), limit_text(c.fail), r.warned, r.failed,
                        fmt::format("{:.4g} %", c.allowed_percent), place_of_worst(r));
  }
  return text;
}

std::string change_table(const CriteriaReport& report) {
  std::string text = fmt::format("  acceptance by {}: {}, before {}\n", report.after.name,
                                 to_string(report.after.verdict), to_string(report.before.verdict));
  text += fmt::format("  {:<22}{:>14}{:>30}{:>14}{:>14}{:>20}{:>20}{:>10}    {}\n", "criterion", "verdict", "worst",
                      "warn", "fail", "warned", "failed", "allowed", "worst tetrahedron, from 1");
  for (std::size_t i = 0; i < report.after.results.size(); ++i) {
    const CriterionResult &old = report.before.results[i], &r = report.after.results[i];
    const AcceptanceCriterion& c = r.criterion;
    text += fmt::format("  {:<22}{:>14}{:>30}{:>14}{:>14}{:>20}{:>20}{:>10}    {}\n", info_of(c.measure).name,
                        fmt::format("{} -> {}", to_string(old.verdict), to_string(r.verdict)),
                        fmt::format("{:.6g} -> {:.6g}", old.worst, r.worst), limit_text(c.warn), limit_text(c.fail),
                        fmt::format("{} -> {}", old.warned, r.warned), fmt::format("{} -> {}", old.failed, r.failed),
                        fmt::format("{:.4g} %", c.allowed_percent), place_of_worst(r));
  }
  return text;
}

std::string criteria_table(const CriteriaReport& report) {
  std::string text;
  const char* const on = !report.undone.empty() && report.before.verdict == Verdict::warn ? "warn" : "fail";
  for (const CriteriaRound& r : report.rounds) {
    text += fmt::format("  round on the elements that {0}: {1} rings, {2} tetrahedra might change, {3} -> {4} {0}{5}\n",
                        on, r.rings, r.active, r.failed_before, r.failed_after, r.kept ? "" : ", undone");
  }
  const bool fails = report.after.verdict == Verdict::fail;
  if (fails && !report.no_rounds.empty()) {
    text += fmt::format("  no rounds on what fails: {}\n", with_flags(report.no_rounds));
  }
  constexpr std::size_t kShown = 5;
  for (const CriterionLimits& l : report.limits) {
    text += fmt::format("  {} fails:\n", info_of(l.criterion.measure).name) + held_by_lines(l.held_by);
    text += fmt::format("  {:<22}{:>12}    {:<36}centroid\n", "worst, counted from 1", "value", "held by");
    for (std::size_t i = 0; i < std::min(kShown, l.worst.size()); ++i) {
      const MissedTet& m = l.worst[i];
      text += fmt::format("  {:<22}{:>12.6g}    {:<36}{:.6g} {:.6g} {:.6g}\n", m.tet + 1, m.value, constraint_text(m),
                          m.centroid[0], m.centroid[1], m.centroid[2]);
    }
  }
  return text;
}

}  // namespace tetune::cli
