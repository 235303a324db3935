// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

/// SIGINT (Ctrl-C) and SIGTERM. While there is a mesh worth writing, the first signal requests a stop. Otherwise, and
/// at the second signal, the process ends at once: old files are unchanged.
namespace tetune::cli::interrupt {

/// Installs the signal handler. `json`: it prints events of --progress json, of which the last is the end of the job.
void install(bool json);

/// The output of a job.
enum class JobOutput { mesh, series };
/// A job begins, with nothing to write yet.
void begin(const std::string& input, JobOutput output);

enum class Stage {
  nothing,  ///< nothing to write yet
  worth_writing,
  written,  ///< the mesh, or the first of a series
};
/// A series that has entered Stage::written may enter Stage::worth_writing again, for the mesh of its next time.
void enter(Stage stage);

/// Whether a stop was requested.
bool requested();

}  // namespace tetune::cli::interrupt
