// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <atomic>
#include <string_view>

#include "exit_code.hpp"
#include "system/process.hpp"

namespace tetune::cli::interrupt {
namespace {

std::atomic<Stage> stage{Stage::nothing};
std::atomic<bool> was_requested{false};
std::atomic<bool> as_json{false};

// Calls only async-signal-safe functions.
void handle() {
  const Stage now = stage;
  if (!was_requested.exchange(true) && now == Stage::worth_writing) return;
  const bool written = now == Stage::written;
  const std::string_view text = written
                                    ? (as_json ? R"({"event":"error","text":"interrupted after the mesh was written"})"
                                               : "\ntetune: interrupted after the mesh was written")
                                    : (as_json ? R"({"event":"error","text":"interrupted, nothing was written"})"
                                               : "\ntetune: interrupted, nothing was written");
  process::write_error(text);
  process::write_error("\n");
  process::leave(written ? kStoppedEarly : kNothingWritten);
}

}  // namespace

void install(bool json) {
  as_json = json;
  process::on_interruption(handle);
}

void enter(Stage next) { stage = next; }

bool requested() { return was_requested; }

}  // namespace tetune::cli::interrupt
