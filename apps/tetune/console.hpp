// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "optimize_arguments.hpp"
#include "tetune/optimize.hpp"

namespace tetune::cli {

/// Writes text to a standard stream. A failure, as on a full disk, does not end a run: main() reports it.
void print_to(std::FILE* stream, std::string_view text);

/// One line of --progress json. Bytes that are not UTF-8 (in names of files) are replaced.
std::string json_line(const nlohmann::ordered_json& event);

/// The event at the end of a job; the input is null where it is empty, as the arguments name none.
nlohmann::ordered_json end_event(const std::string& input, const char* result, int exit_code, double seconds);

/// Output to the user: tables, warnings, errors and progress; the latter as an updated line on a terminal, or as one
/// JSON object per line on the standard error (docs/command-line.md, "Progress").
class Console {
 public:
  /// `tables` is null if the standard output is used for the mesh and the standard error for JSON.
  Console(ProgressMode mode, int verbosity, std::FILE* tables);
  ~Console() { clear(); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  int verbosity() const { return verbosity_; }
  bool json() const { return json_; }

  void print(const std::string& text);
  void warn(const std::string& text);
  void error(const std::string& text);
  /// Prints an event, in JSON mode only.
  void event(const nlohmann::ordered_json& event);

  /// Prints the name of a phase of the program: "reading", "optimizing", "writing".
  void phase(const char* name);
  void update(const Progress& progress);
  /// Context::progress that calls update(); none where no progress is shown.
  std::function<bool(const Progress&)> progress_hook();
  /// Erases the line.
  void clear();

 private:
  void message(const char* kind, const std::string& text);

  bool json_, line_;
  int verbosity_;
  std::FILE* tables_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace tetune::cli
