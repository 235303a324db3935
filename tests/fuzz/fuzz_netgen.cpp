// SPDX-License-Identifier: Apache-2.0
#include "fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static tetune::fuzz::Folder folder;
  tetune::fuzz::check(folder.put("in.vol", tetune::fuzz::text(data, size)));
  return 0;
}
