// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tetune::test {

/// Whether a sanitizer slows the tests down by a factor of ten: long tests take fewer meshes then.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

}  // namespace tetune::test
