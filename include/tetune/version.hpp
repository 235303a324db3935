// SPDX-License-Identifier: Apache-2.0
#pragma once

#define TETUNE_VERSION_MAJOR 0
#define TETUNE_VERSION_MINOR 1
#define TETUNE_VERSION_PATCH 0
#define TETUNE_VERSION "0.1.0"

namespace tetune {

/// The instructions that the library which runs was compiled for: "x86-64-v4" (AVX-512), "x86-64-v3" (AVX2),
/// "x86-64", or "other". Results are the same bits with all of them.
const char* instruction_set();

}  // namespace tetune
