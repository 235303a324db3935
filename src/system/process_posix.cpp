// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <csignal>

#if defined(__EMSCRIPTEN__)
#include <emscripten.h>
#endif

#include "system/process.hpp"

namespace tetune::process {
namespace {

void (*handler)() = nullptr;

}  // namespace

void prepare_standard_streams() {
  int descriptor = 0;
  while (descriptor >= 0 && descriptor <= STDERR_FILENO) descriptor = ::open("/dev/null", O_RDONLY);
  ::close(descriptor);
}

std::vector<std::string> arguments(int argc, char** argv) { return {argv + (argc > 0 ? 1 : 0), argv + argc}; }

#if defined(__EMSCRIPTEN__)
// The C library takes all standard streams for terminals; node knows which are.
EM_JS(int, is_terminal_of_node, (int descriptor),
      { return typeof process == "object" && require("tty").isatty(descriptor) ? 1 : 0; });
bool is_terminal(int descriptor) { return is_terminal_of_node(descriptor) != 0; }
#else
bool is_terminal(int descriptor) { return ::isatty(descriptor) == 1; }
#endif

void on_interruption(void (*handle)()) {
  handler = handle;
  struct sigaction action {};
  action.sa_handler = [](int) { handler(); };
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction old {};
    // A signal that is ignored (nohup, background jobs of a shell) stays ignored.
    if (::sigaction(signal, nullptr, &old) == 0 && old.sa_handler != SIG_IGN) ::sigaction(signal, &action, nullptr);
  }
}

void write_error(std::string_view text) noexcept {
  [[maybe_unused]] const auto done = ::write(STDERR_FILENO, text.data(), text.size());
}

void leave(int exit_code) noexcept { ::_exit(exit_code); }

}  // namespace tetune::process
