// SPDX-License-Identifier: Apache-2.0
#include "fuzz.hpp"

// A series that is read is written, and reads back the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static tetune::fuzz::Folder folder;
  std::vector<tetune::SeriesStep> steps;
  try {
    steps = tetune::parse_series(folder.path("in.pvd"), tetune::fuzz::text(data, size));
  } catch (const tetune::FileError&) {
    return 0;
  }
  tetune::write_series(folder.path("out.pvd"), steps);
  const std::vector<tetune::SeriesStep> back = tetune::read_series(folder.path("out.pvd"));
  if (back.size() != steps.size()) std::abort();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (back[i].time != steps[i].time || back[i].path != steps[i].path) std::abort();
  }
  return 0;
}
