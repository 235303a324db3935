// SPDX-License-Identifier: Apache-2.0
// The public headers after windows.h, which defines macros for common words.
#include <windows.h>

#include <tetune/tetune.hpp>

#include <gtest/gtest.h>

namespace tetune {
namespace {

TEST(WindowsHeaders, PublicHeadersCompileAfterWindowsH) {
  EXPECT_STREQ(to_string(LimitingConstraint::region_interface), "interface");
}

}  // namespace
}  // namespace tetune
