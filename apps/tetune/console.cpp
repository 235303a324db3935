// SPDX-License-Identifier: Apache-2.0
#include "console.hpp"

#include <fmt/format.h>

#include "system/process.hpp"

namespace tetune::cli {

using Json = nlohmann::ordered_json;

void print_to(std::FILE* stream, std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stream);
  std::fflush(stream);
}

std::string json_line(const Json& event) { return event.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json end_event(const std::string& input, const char* result, int exit_code, double seconds) {
  return {{"event", "end"},
          {"input", input.empty() ? Json() : Json(input)},
          {"result", result},
          {"exit_code", exit_code},
          {"seconds", seconds}};
}

Console::Console(ProgressMode mode, int verbosity, std::FILE* tables)
    : json_(mode == ProgressMode::json),
      line_(mode == ProgressMode::automatic && verbosity > 0 && process::is_terminal(2)),
      verbosity_(verbosity),
      tables_(tables) {}

void Console::print(const std::string& text) {
  clear();
  if (verbosity_ > 0 && tables_ != nullptr) print_to(tables_, text);
}

void Console::warn(const std::string& text) {
  if (verbosity_ >= 0 || json_) message("warning", text);
}

void Console::error(const std::string& text) { message("error", text); }

void Console::message(const char* kind, const std::string& text) {
  clear();
  if (json_) {
    event({{"event", kind}, {"text", text}});
  } else {
    print_to(stderr, fmt::format("tetune: {}{}\n", std::string_view(kind) == "warning" ? "warning: " : "", text));
  }
}

void Console::event(const Json& event) {
  if (json_) print_to(stderr, json_line(event));
}

void Console::phase(const char* name) {
  event({{"event", "phase"}, {"phase", name}});
  if (line_) print_to(stderr, fmt::format("\r\033[K{} ...", name));
}

std::function<bool(const Progress&)> Console::progress_hook() {
  if (!json_ && !line_) return {};
  return [this](const Progress& p) {
    update(p);
    return true;
  };
}

void Console::update(const Progress& p) {
  if (json_) {
    Json json = {{"event", "progress"},
                 {"phase", p.phase},
                 {"fraction", p.fraction},
                 {"seconds", p.seconds},
                 {"seconds_left", nullptr},
                 {"iteration", p.iteration},
                 {"energy", p.energy},
                 {"energy_before", p.energy_before},
                 {"worst_angle_deg", p.worst_angle}};
    if (p.seconds_left >= 0) json["seconds_left"] = p.seconds_left;
    event(json);
  }
  const auto now = std::chrono::steady_clock::now();
  if (!line_ || now - last_ < std::chrono::milliseconds(50)) return;
  last_ = now;
  const double decrease = p.energy_before > 0 ? 100 * (1 - p.energy / p.energy_before) : 0;
  print_to(stderr,
           fmt::format("\r\033[K{:>3.0f} %  {:<6} after {:>2} sweeps  energy -{:.2f} %  worst angle {:.2f} deg{}",
                       100 * p.fraction, p.phase, p.iteration, decrease, p.worst_angle,
                       p.seconds_left < 0 ? "" : fmt::format("  {:.0f} s left", p.seconds_left)));
}

void Console::clear() {
  if (line_) print_to(stderr, "\r\033[K");
}

}  // namespace tetune::cli
