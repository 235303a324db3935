// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <string_view>

#include "console.hpp"
#include "exit_code.hpp"
#include "system/process.hpp"

namespace tetune::cli::interrupt {
namespace {

using Time = std::chrono::steady_clock;

/// The last events of an interrupted job. They are made before it, as the handler may not allocate: this only fills in
/// the seconds.
class LastEvents {
 public:
  LastEvents(const std::string& input, const char* text, int code) {
    text_ = json_line({{"event", "error"}, {"text", text}});
    std::string end = json_line(end_event(input, "interrupted", code, 0));
    const std::size_t number = end.rfind("0.0");
    seconds_ = text_.size() + number;
    text_ += end.replace(number, 3, std::string(kDigits, ' ') + ".000");
  }
  /// Calls only async-signal-safe functions.
  std::string_view text() {
    std::int64_t rest = std::chrono::duration_cast<std::chrono::milliseconds>(Time::now() - start_).count();
    for (std::size_t i = kDigits + 4; i-- > 0;) {
      if (i == kDigits) continue;  // the point
      if (rest == 0 && i + 1 < kDigits) break;
      text_[seconds_ + i] = char('0' + rest % 10);
      rest /= 10;
    }
    return text_;
  }

 private:
  static constexpr std::size_t kDigits = 12;
  Time::time_point start_ = Time::now();
  std::string text_;
  std::size_t seconds_;  ///< the place of the number
};

constexpr const char* kNothing = "interrupted, nothing was written";
constexpr const char* kWritten = "interrupted after the mesh was written";
constexpr const char* kPartWritten = "interrupted after meshes of the series were written";

struct JobEvents {
  JobEvents(const std::string& input, const char* written_text)
      : nothing(input, kNothing, kNothingWritten), written(input, written_text, kStoppedEarly) {}
  LastEvents nothing, written;
};

std::atomic<Stage> stage{Stage::nothing};
std::atomic<bool> was_written{false};
std::atomic<const char*> text_if_written{kWritten};
std::atomic<bool> was_requested{false};
std::atomic<JobEvents*> events{nullptr};  ///< in the JSON mode

// Calls only async-signal-safe functions.
void handle() {
  const Stage now = stage;
  if (!was_requested.exchange(true) && now == Stage::worth_writing) return;
  const bool written = was_written;
  if (JobEvents* last = events) {
    process::write_error((written ? last->written : last->nothing).text());
  } else {
    process::write_error("\ntetune: ");
    process::write_error(written ? text_if_written.load() : kNothing);
    process::write_error("\n");
  }
  process::leave(written ? kStoppedEarly : kNothingWritten);
}

bool is_json = false;

}  // namespace

void install(bool json) {
  is_json = json;
  begin("", JobOutput::mesh);
  process::on_interruption(handle);
}

void begin(const std::string& input, JobOutput output) {
  enter(Stage::nothing);
  text_if_written = output == JobOutput::series ? kPartWritten : kWritten;
  if (!is_json) return;
  // Never freed: the handler may run while the program ends.
  static auto& all = *new std::deque<JobEvents>;
  events = &all.emplace_back(input, text_if_written);
}

void enter(Stage next) {
  if (next != Stage::worth_writing) was_written = next == Stage::written;
  stage = next;
}

bool requested() { return was_requested; }

}  // namespace tetune::cli::interrupt
