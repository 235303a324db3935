// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "fuzz.hpp"

/// The input holds .node, .ele, .face and .edge, separated by '%'; a file whose part is missing does not exist.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static tetune::fuzz::Folder folder;
  std::string_view rest = tetune::fuzz::text(data, size);
  bool more = true;
  for (const char* name : {"in.node", "in.ele", "in.face", "in.edge"}) {
    const std::size_t end = std::min(rest.find('%'), rest.size());
    if (more) {
      folder.put(name, rest.substr(0, end));
    } else {
      folder.remove(name);
    }
    more = end < rest.size();
    rest.remove_prefix(more ? end + 1 : end);
  }
  tetune::fuzz::check(folder.path("in.ele"));
  return 0;
}
