// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/registry.hpp"
#include "io_fixture.hpp"

namespace tetune::test {

/// Tests of formats that plugins read and write; skipped where one is missing.
class Plugins : public IoTest {
 protected:
  void SetUp() override {
    IoTest::SetUp();
    for (const Plugin& plugin : {kVtkPlugin, kGmshPlugin}) {
      if (!has_plugin(plugin)) GTEST_SKIP() << "built without " << plugin.library << ": install it with its headers";
    }
  }
};

}  // namespace tetune::test
