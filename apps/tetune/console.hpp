// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "tetune/optimize.hpp"

namespace tetune::cli {

enum class ProgressMode { automatic, none, json };

/// Writes text to a standard stream. One that takes none, as on a full disk, is no reason to end a run: main() tells.
void say(std::FILE* stream, std::string_view text);

/// What the user sees: tables, warnings and errors, and how far the work is: a line on a terminal, or one JSON object a
/// line on the standard error (docs/command-line.md, "Progress").
class Console {
 public:
  /// `tables` is null where the standard output belongs to the mesh and the standard error to JSON.
  Console(ProgressMode mode, int verbosity, std::FILE* tables);
  ~Console() { clear(); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  int verbosity() const { return verbosity_; }
  bool json() const { return json_; }
  /// Whether anyone looks at the progress.
  bool watched() const { return json_ || line_; }

  void print(const std::string& text);
  void warn(const std::string& text);
  void error(const std::string& text);
  /// An event, in JSON mode alone.
  void event(const nlohmann::ordered_json& event);

  /// "reading", "optimising", "writing".
  void phase(const char* what);
  void update(const Progress& progress);
  /// Takes the line away.
  void clear();

 private:
  void message(const char* kind, const std::string& text);

  bool json_, line_;
  int verbosity_;
  std::FILE* tables_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace tetune::cli
