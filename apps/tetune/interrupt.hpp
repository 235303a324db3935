// SPDX-License-Identifier: Apache-2.0
#pragma once

/// SIGINT (Ctrl-C) and SIGTERM. While there is a mesh worth writing, the first one asks for it and an end; else, and
/// the second time, the process ends at once, and leaves old files and no temporary ones.
namespace tetune::cli::interrupt {

/// `json`: last words as an event of --progress json.
void install(bool json);

enum class Stage {
  nothing,  ///< nothing to write yet
  worth_writing,
  written,
};
void enter(Stage stage);

/// Whether a signal has come.
bool requested();

}  // namespace tetune::cli::interrupt
