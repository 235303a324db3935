// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

namespace tetune::test {

/// A real of 113 bits: a type of its own on x86-64, long double on AArch64 and in WebAssembly.
#ifdef __SIZEOF_FLOAT128__
using Quad = __float128;
#else
using Quad = long double;
static_assert(std::numeric_limits<Quad>::digits == 113);
#endif

}  // namespace tetune::test
