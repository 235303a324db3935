// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "io/inp/inp_cursor.hpp"

/// The files that a deck includes (*INCLUDE, INPUT=...).
namespace tetune {

inline constexpr std::size_t kMaxInpDepth = 20, kMaxInpIncludes = 1000;

/// The file that an *INCLUDE card of `file` names: in the folder of the deck, or else in that of the file.
std::string included_inp_path(const std::string& deck, const std::string& file, std::string name);

/// Calls take(keyword, place) for each card of a deck and of the files that it includes, in order. `text`: the contents
/// of the deck. Files that do not exist, or are included too deep, are left out.
void for_each_inp_keyword(const std::string& deck, std::string_view text,
                          const std::function<void(const InpKeyword&, const InpPlace&)>& take);

}  // namespace tetune
