// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace tetune::ptxsim {

using u8 = std::uint8_t;
using u16 = std::uint16_t;
using u32 = std::uint32_t;
using u64 = std::uint64_t;
using i8 = std::int8_t;
using i16 = std::int16_t;
using i32 = std::int32_t;
using i64 = std::int64_t;

inline constexpr u32 kLanes = 32;
/// One bit per lane of a warp.
using LaneMask = u32;

/// Ends the process with a message: for PTX and calls of the runtime that the simulator does not support.
[[noreturn]] void fatal(const std::string& message);

/// As std::snprintf.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

/// The name in C++ of a mangled name; the name itself where it is not mangled.
std::string demangled(const std::string& name);

/// `at`, rounded up to a multiple of a power of two.
constexpr u32 aligned(u32 at, u32 alignment) { return (at + alignment - 1) & ~(alignment - 1); }

}  // namespace tetune::ptxsim
