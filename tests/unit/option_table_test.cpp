// SPDX-License-Identifier: Apache-2.0
#include "tetune/option_table.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

#include "tetune/error.hpp"

namespace tetune {
namespace {

std::string refusal(const Options& options) {
  try {
    check_options(options);
  } catch (const OptionError& e) {
    return e.what();
  }
  return "";
}

TEST(OptionTable, NamesAreUniqueAndDefaultsAreAccepted) {
  std::set<std::string> names;
  for (const OptionInfo& option : option_table()) {
    EXPECT_TRUE(names.insert(option.name).second) << option.name;
    EXPECT_EQ(find_option(option.name), &option);
  }
  EXPECT_EQ(names.size(), 28U);
  EXPECT_EQ(refusal({}), "");
  EXPECT_TRUE(ineffective_options({}).empty());
}

TEST(OptionTable, ValuesAsText) {
  Options options;
  options.boundary = Boundary::slide;
  options.frozen_regions = {1, 20};
  options.targets = {{Measure::mean_ratio, 0.25}};
  EXPECT_EQ(option_value(*find_option("boundary"), options), "slide");
  EXPECT_EQ(option_value(*find_option("flips"), options), "true");
  EXPECT_EQ(option_value(*find_option("feature_angle"), options), "45");
  EXPECT_EQ(option_value(*find_option("frozen_regions"), options), "1,20");
  EXPECT_EQ(option_value(*find_option("targets"), options), "mean_ratio:0.25");
}

TEST(OptionTable, TextSetsEveryOption) {
  Options options;
  for (const auto& [name, text] : {std::pair("boundary", "slide"),
                                   {"flips", "false"},
                                   {"feature_angle", "30.5"},
                                   {"frozen_regions", "1,20"},
                                   {"targets", "mean_ratio:0.25,min_dihedral_deg:10"},
                                   {"max_ring", "5"},
                                   {"frozen_vertices", "0,1,1"},
                                   {"device", "cpu"}}) {
    set_option(options, name, text);
    EXPECT_EQ(option_value(*find_option(name), options), text) << name;
  }
  // The value of each option, as text, is one that it takes.
  const Options defaults;
  for (const OptionInfo& option : option_table()) {
    set_option(options, option.name, option_value(option, defaults));
    EXPECT_EQ(option_value(option, options), option_value(option, defaults)) << option.name;
  }
  for (const auto& [name, text] : {std::pair("bound", "slide"),
                                   {"boundary", "slid"},
                                   {"flips", "yes"},
                                   {"feature_angle", "30 deg"},
                                   {"frozen_regions", "1;20"},
                                   {"frozen_regions", "1,"},
                                   {"targets", "mean_ratio"},
                                   {"targets", "mean:0.2"},
                                   {"max_ring", ""},
                                   {"max_ring", "5.5"},
                                   {"frozen_vertices", "0,2"}}) {
    EXPECT_THROW(set_option(options, name, text), OptionError) << name;
  }
}

TEST(OptionTable, FormerNamesOfChoicesAreFound) {
  const OptionInfo& effort = *find_option("effort");
  EXPECT_STREQ(find_choice(effort, "default")->name, "standard");
  EXPECT_EQ(find_choice(effort, "standard"), find_choice(effort, "default"));
  EXPECT_STREQ(find_choice(*find_option("device"), "automatic")->name, "auto");
  EXPECT_EQ(find_choice(effort, "heroic"), nullptr);
}

TEST(OptionTable, ValuesOutOfRangeAreRefused) {
  const auto with = [](auto member, auto value) {
    Options options;
    options.*member = value;
    return refusal(options);
  };
  EXPECT_EQ(with(&Options::max_ring, 2), "max_ring=2 is out of range: it must be 3 to 7");
  EXPECT_EQ(with(&Options::max_iterations, -1), "max_iterations=-1 is out of range: it must be 0 or more");
  EXPECT_EQ(with(&Options::threads, 4097), "threads=4097 is out of range: it must be 0 to 4096");
  EXPECT_EQ(with(&Options::feature_angle, 0.0),
            "feature_angle=0 is out of range: it must be above 0 and at most 180 degrees");
  EXPECT_NE(with(&Options::max_deviation, std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_NE(with(&Options::effort, static_cast<Effort>(7)), "");
  EXPECT_EQ(with(&Options::targets, std::vector<Target>{{Measure::mean_ratio, 1.5}}),
            "the target for mean_ratio is 1.5; it must be above 0 and at most 1");
  EXPECT_EQ(with(&Options::only_below, std::vector<Target>{{Measure::mean_ratio, -1e-9}}),
            "the limit of only_below for mean_ratio is -1e-09; it must be above 0 and at most 1");
}

TEST(OptionTable, OptionsWithoutEffectAreNamed) {
  Options options;
  options.max_deviation = 0.1;
  options.feature_angle = 30;
  options.flips = false;
  options.max_ring = 5;
  EXPECT_EQ(refusal(options), "");
  EXPECT_EQ(ineffective_options(options),
            (std::vector<std::string>{"feature_angle=30 has no effect without boundary=slide",
                                      "max_deviation=0.1 has no effect without boundary=slide",
                                      "max_ring=5 has no effect with flips=false"}));
  options.boundary = Boundary::slide;
  EXPECT_EQ(ineffective_options(options).size(), 1U);
  Options nothing;
  nothing.flips = false;
  nothing.max_iterations = 0;
  EXPECT_EQ(refusal(nothing), "");
  EXPECT_EQ(ineffective_options(nothing),
            (std::vector<std::string>{"max_iterations=0 leaves nothing to improve with flips=false"}));
  nothing.untangle = true;
  EXPECT_TRUE(ineffective_options(nothing).empty());
  // Curved elements may be split.
  Options growing;
  growing.max_growth = 1.2;
  EXPECT_EQ(ineffective_options(growing),
            (std::vector<std::string>{
                "max_growth=1.2 has no effect without effort=best, surface_vertices=edit or untangle=true"}));
  growing.untangle = true;
  growing.effort = Effort::fast;
  EXPECT_TRUE(ineffective_options(growing).empty());
  Options edited;
  edited.effort = Effort::best;
  edited.max_ring = 3;
  edited.surface_vertices = SurfaceVertices::edit;
  EXPECT_EQ(ineffective_options(edited).size(), 1U);
  edited.surface_vertices = SurfaceVertices::keep;
  EXPECT_TRUE(ineffective_options(edited).empty());
}

}  // namespace
}  // namespace tetune
