// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "ptxsim/launch.hpp"

namespace tetune::ptxsim {

/// Appends the counts of a launch to the file that Settings::trace names, if any: a line of values separated by tabs,
/// below a line of their names.
void write_trace(const Launch& launch);

/// Appends a copy between the host and the device, or within the device: "upload", "download", "copy", "set".
void write_transfer(const char* name, u64 bytes);

/// Counts to increment per instruction of a module: how often warps ran it. Null if Settings::profile names no file.
/// When the process ends the file gets a line per line of the sources: warp instructions, file and line.
std::vector<u64>* profile_of(const Module& module);

}  // namespace tetune::ptxsim
