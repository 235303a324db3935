// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "fuzz.hpp"

/// The input holds .node, .ele, .face and .edge, parted by '%'; a part that is missing is a file that is.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tetune::fuzz::Folder folder;
  std::string_view rest = tetune::fuzz::text(data, size);
  std::string path;
  bool more = true;
  for (const char* name : {"in.node", "in.ele", "in.face", "in.edge"}) {
    const std::size_t end = std::min(rest.find('%'), rest.size());
    path = folder.put(name, rest.substr(0, end));
    if (!more) std::filesystem::remove(path);
    more = end < rest.size();
    rest.remove_prefix(more ? end + 1 : end);
  }
  tetune::fuzz::check(std::filesystem::path(path).replace_extension(".ele").string());
  return 0;
}
