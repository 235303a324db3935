// SPDX-License-Identifier: Apache-2.0
#include "driver/criteria_losses.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tetune {
namespace {

std::string change(const std::string& from, const std::string& to) { return from + " -> " + to; }
std::string change(std::int64_t from, std::int64_t to) { return change(std::to_string(from), std::to_string(to)); }

std::string loss_of(const CriterionResult& before, const CriterionResult& after) {
  if (after.verdict <= before.verdict && after.failed <= before.failed) return "";
  std::string text = info_of(after.criterion.measure).name;
  text += ": ";
  if (after.verdict > before.verdict) text += change(to_string(before.verdict), to_string(after.verdict)) + ", ";
  if (after.failed != before.failed) return text + change(before.failed, after.failed) + " fail";
  return text + change(before.warned, after.warned) + " warn";
}

bool is_worse(double value, double old, bool larger_is_better) {
  if (std::isnan(value)) return !std::isnan(old);
  return larger_is_better ? value < old : value > old;
}

}  // namespace

std::string losses_in(const AcceptanceReport& before, const AcceptanceReport& after) {
  if (after.verdict < before.verdict) return "";
  std::string text;
  std::int64_t failed = 0, warned_before = 0, warned_after = 0;
  for (std::size_t i = 0; i < after.results.size(); ++i) {
    const CriterionResult &old = before.results[i], &now = after.results[i];
    const std::string loss = loss_of(old, now);
    if (!loss.empty()) text += (text.empty() ? "" : "; ") + loss;
    failed += now.failed - old.failed;
    warned_before += old.warned;
    warned_after += now.warned;
  }
  if (!text.empty() || failed != 0 || warned_after <= warned_before) return text;
  return change(warned_before, warned_after) + " warn";
}

bool has_worse_value(const AcceptanceReport& before, const AcceptanceReport& after, Verdict level) {
  for (std::size_t i = 0; i < after.results.size(); ++i) {
    const CriterionResult& now = after.results[i];
    const double old = before.results[i].worst;
    if (now.verdict >= level && is_worse(now.worst, old, info_of(now.criterion.measure).larger_is_better)) return true;
  }
  return false;
}

}  // namespace tetune
