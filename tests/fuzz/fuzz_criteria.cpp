// SPDX-License-Identifier: Apache-2.0
// A file of acceptance criteria: it is refused with its name and a line, or every criterion of it is usable.
#include <cstdlib>
#include <string>

#include "criteria_file.hpp"
#include "fuzz.hpp"
#include "tetune/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tetune;
  try {
    const AcceptanceCriteria criteria = cli::parse_criteria("f.toml", std::string(fuzz::text(data, size)));
    if (criteria.criteria.empty()) std::abort();
    for (const AcceptanceCriterion& criterion : criteria.criteria) check_criterion(criterion);
  } catch (const FileError& e) {
    if (!std::string(e.what()).starts_with("f.toml:")) std::abort();
  }
  return 0;
}
