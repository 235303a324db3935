// SPDX-License-Identifier: Apache-2.0
#pragma once

/// SIGINT (Ctrl-C) and SIGTERM. While there is a mesh worth writing, the first signal requests a stop. Otherwise, and
/// at the second signal, the process ends at once: old files are unchanged.
namespace tetune::cli::interrupt {

/// Installs the signal handler. `json`: it prints its message as an event of --progress json.
void install(bool json);

enum class Stage {
  nothing,  ///< nothing to write yet
  worth_writing,
  written,
};
void enter(Stage stage);

/// Whether a stop was requested.
bool requested();

}  // namespace tetune::cli::interrupt
