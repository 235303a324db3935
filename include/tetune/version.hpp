// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tetune/export.hpp"

#define TETUNE_VERSION_MAJOR 0
#define TETUNE_VERSION_MINOR 2
#define TETUNE_VERSION_PATCH 0
#define TETUNE_VERSION "0.2.0"

namespace tetune {

/// The instruction set for which the loaded library was compiled: "x86-64-v4" (AVX-512), "x86-64-v3" (AVX2), "x86-64"
/// or "other". Results are bit for bit the same with all of them.
TETUNE_API const char* instruction_set();

}  // namespace tetune
