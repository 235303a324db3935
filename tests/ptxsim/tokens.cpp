// SPDX-License-Identifier: Apache-2.0
#include "ptxsim/tokens.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>

namespace tetune::ptxsim {
namespace {

bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '$' || c == '%' || c == '.';
}

/// The position behind the token, comment or white space at `begin`.
std::size_t end_of(std::string_view text, std::size_t begin) {
  const char c = text[begin];
  const char next = begin + 1 < text.size() ? text[begin + 1] : '\0';
  std::size_t end = begin + 1;
  const auto behind = [&](std::string_view terminator) {
    const std::size_t found = text.find(terminator, end);
    return found == std::string_view::npos ? text.size() : found + terminator.size();
  };
  if (c == '/' && next == '/') return behind("\n") - 1;
  if (c == '/' && next == '*') return behind("*/");
  if (c == '"') return behind("\"");
  if (!is_word(c)) return end;
  while (end < text.size()) {
    if (is_word(text[end])) {
      ++end;
    } else if (text.substr(end, 2) == "::") {
      end += 2;  // of names such as .shared::cta
    } else {
      break;
    }
  }
  return end;
}

}  // namespace

Tokens::Tokens(std::string_view text) {
  u32 line = 1;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = is_space(text[begin]) ? begin + 1 : end_of(text, begin);
    const std::string_view token = text.substr(begin, end - begin);
    const bool is_comment = token.substr(0, 2) == "//" || token.substr(0, 2) == "/*";
    if (!is_space(token[0]) && !is_comment) tokens_.push_back({token, line});
    line += static_cast<u32>(std::count(token.begin(), token.end(), '\n'));
    begin = end;
  }
}

std::string_view Tokens::take() {
  if (at_end()) fail("the PTX ends too early");
  return tokens_[position_++].text;
}

bool Tokens::accept(std::string_view text) {
  if (peek() != text) return false;
  ++position_;
  return true;
}

void Tokens::expect(std::string_view text) {
  if (!accept(text)) fail(std::string(text) + " expected, " + std::string(peek()) + " found");
}

void Tokens::skip_line() {
  const u32 current = line();
  while (!at_end() && tokens_[position_].line == current) ++position_;
}

void Tokens::skip_behind(std::string_view text) {
  while (take() != text) {
  }
}

u32 Tokens::line() const { return tokens_[std::min(position_, tokens_.size() - 1)].line; }

void Tokens::fail(const std::string& what) const { fatal("PTX line " + std::to_string(line()) + ": " + what); }

bool Tokens::is_number(std::string_view text) { return !text.empty() && is_digit(text[0]); }

u64 Tokens::number_of(std::string_view text) {
  const std::string digits(text);
  const bool is_float =
      digits.size() > 2 && digits[0] == '0' && std::string_view("dDfF").find(digits[1]) != std::string_view::npos;
  return is_float ? std::strtoull(digits.c_str() + 2, nullptr, 16) : std::strtoull(digits.c_str(), nullptr, 0);
}

}  // namespace tetune::ptxsim
