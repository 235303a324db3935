// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "mesh/first_ids.hpp"
#include "tetune/validate.hpp"

namespace tetune {

/// Collects the elements that have one defect: their number and the first ids.
class FindingCollector {
 public:
  FindingCollector(Defect defect, std::string where) : finding_{defect, 0, {}, std::move(where)} {}
  void add(std::int64_t id) {
    ++finding_.count;
    if (finding_.first.size() < kShownIds) finding_.first.push_back(static_cast<Index>(id));
  }
  /// Appends the finding to the report if there is any element.
  void finish(ValidationReport& report) const {
    if (finding_.count > 0) report.findings.push_back(finding_);
  }

 private:
  Finding finding_;
};

}  // namespace tetune
