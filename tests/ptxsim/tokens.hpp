// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ptxsim/types.hpp"

namespace tetune::ptxsim {

/// The words, strings and single characters of PTX, without comments, read one after the other.
class Tokens {
 public:
  /// `text` must outlive the tokens.
  explicit Tokens(std::string_view text);

  bool at_end() const { return position_ >= tokens_.size(); }
  /// Empty beyond the end.
  std::string_view peek(std::size_t ahead = 0) const {
    return position_ + ahead < tokens_.size() ? tokens_[position_ + ahead].text : std::string_view();
  }
  std::string_view take();
  bool accept(std::string_view text);
  /// Ends the process where another token follows.
  void expect(std::string_view text);
  u64 take_number() { return number_of(take()); }
  void skip_line();
  void skip_behind(std::string_view text);
  /// Of the next token.
  u32 line() const;
  [[noreturn]] void fail(const std::string& what) const;

  static bool is_number(std::string_view text);
  /// Decimal, hexadecimal, octal, or the bits of a floating-point number after 0d or 0f.
  static u64 number_of(std::string_view text);

 private:
  struct Token {
    std::string_view text;
    u32 line;
  };
  std::vector<Token> tokens_;
  std::size_t position_ = 0;
};

}  // namespace tetune::ptxsim
