// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ptxsim/launch.hpp"

namespace tetune::ptxsim {

/// Keeps the PTX that nvcc put into one object file: of the architectures, the newest that the simulated device runs.
/// Returns the handle that register_kernel() takes.
void** register_fat_binary(void* wrapper);

/// `host`: the address that the program calls the kernel by; `name`: the kernel's in PTX.
void register_kernel(void** binary, const void* host, const char* name);

/// The kernel, parsed; null if it was not registered.
const Function* find_kernel(const void* host);

}  // namespace tetune::ptxsim
