// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_include.hpp"

#include <algorithm>

#include "io/registry.hpp"
#include "system/path.hpp"

namespace tetune {
namespace {

/// One pass over the cards of a deck.
class InpKeywordWalk {
 public:
  InpKeywordWalk(const std::string& deck, const std::function<void(const InpKeyword&, const InpPlace&)>& take)
      : deck_(deck), take_(take) {}

  void walk(const std::string& file, std::string_view text, std::size_t depth) {
    InpCursor cursor(file, text);
    cursor.take_byte_order_mark();
    while (!cursor.at_end()) {
      if (cursor.line_kind() != InpCursor::Line::keyword) {
        cursor.take_line();
        continue;
      }
      const InpPlace where = cursor.place();
      const InpKeyword keyword = cursor.take_keyword();
      take_(keyword, where);
      const std::string* input = keyword.name == "INCLUDE" ? keyword.find("INPUT") : nullptr;
      if (input == nullptr || input->empty() || depth >= kMaxInpDepth || ++includes_ > kMaxInpIncludes) continue;
      const std::string path = included_inp_path(deck_, file, *input);
      if (is_file(path)) walk(path, MappedFile(path).bytes(), depth + 1);
    }
  }

 private:
  const std::string& deck_;
  const std::function<void(const InpKeyword&, const InpPlace&)>& take_;
  std::size_t includes_ = 0;
};

}  // namespace

std::string included_inp_path(const std::string& deck, const std::string& file, std::string name) {
  std::erase(name, '"');
  const auto in_folder_of = [&name](const std::string& of) {
    return (path_of(of).parent_path() / path_of(name)).lexically_normal().string();
  };
  std::string path = in_folder_of(deck);
  return is_file(path) ? path : in_folder_of(file);
}

void for_each_inp_keyword(const std::string& deck, std::string_view text,
                          const std::function<void(const InpKeyword&, const InpPlace&)>& take) {
  InpKeywordWalk(deck, take).walk(deck, text, 0);
}

std::vector<std::string> included_inp_files(const std::string& path) {
  std::vector<std::string> found;
  const MappedFile deck(path);
  for_each_inp_keyword(path, deck.bytes(), [&](const InpKeyword& keyword, const InpPlace& where) {
    const std::string* input = keyword.name == "INCLUDE" ? keyword.find("INPUT") : nullptr;
    if (input == nullptr || input->empty()) return;
    std::string file = included_inp_path(path, where.file, *input);
    if (is_file(file) && std::find(found.begin(), found.end(), file) == found.end()) found.push_back(std::move(file));
  });
  return found;
}

}  // namespace tetune
