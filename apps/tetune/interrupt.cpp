// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <string_view>

#include "exit_code.hpp"

namespace tetune::cli::interrupt {
namespace {

std::atomic<Stage> stage{Stage::nothing};
std::atomic<bool> was_requested{false};
std::atomic<bool> as_json{false};

// Calls only async-signal-safe functions.
void handle(int) {
  const Stage now = stage;
  if (!was_requested.exchange(true) && now == Stage::worth_writing) return;
  const bool written = now == Stage::written;
  const std::string_view text = written
                                    ? (as_json ? R"({"event":"error","text":"interrupted after the mesh was written"})"
                                               : "\ntetune: interrupted after the mesh was written")
                                    : (as_json ? R"({"event":"error","text":"interrupted, nothing was written"})"
                                               : "\ntetune: interrupted, nothing was written");
  [[maybe_unused]] auto done = ::write(STDERR_FILENO, text.data(), text.size());
  done = ::write(STDERR_FILENO, "\n", 1);
  ::_exit(written ? kStoppedEarly : kNothingWritten);
}

}  // namespace

void install(bool json) {
  as_json = json;
  struct sigaction action {};
  action.sa_handler = handle;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction old {};
    // A signal that is ignored (nohup, background jobs of a shell) stays ignored.
    if (::sigaction(signal, nullptr, &old) == 0 && old.sa_handler != SIG_IGN) ::sigaction(signal, &action, nullptr);
  }
}

void enter(Stage next) { stage = next; }

bool requested() { return was_requested; }

}  // namespace tetune::cli::interrupt
