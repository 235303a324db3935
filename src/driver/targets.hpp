// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/links.hpp"
#include "core/motion.hpp"
#include "core/types.hpp"
#include "tetune/optimize.hpp"

/// Which elements miss a target, and what holds them (docs/quality.md, "Targets").
namespace tetune {

/// Throws OptionError for a target that every element meets or that none can.
void check_target(const Target& target);

/// What an optimisation ended with, on the host: slots and links before they are compacted.
struct Outcome {
  std::vector<Point> points;
  std::vector<Tet> tets;
  std::vector<Links> links;
  std::vector<int> tet_tags;
  std::vector<Index> vertex2original;
  std::vector<Mobility> kind;
  std::vector<std::uint8_t> frozen;
  std::vector<Index> required_slots;
  double scale;
};

/// One entry for each of Options::targets.
std::vector<TargetReport> report_targets(const Outcome& outcome, const Options& options);

}  // namespace tetune
