// SPDX-License-Identifier: Apache-2.0
// Time series (.pvd).
#include "tetune/series.hpp"
#include "io_fixture.hpp"

namespace tetune::test {
namespace {

using Series = IoTest;

std::string series(const std::string& entries) {
  return "<?xml version=\"1.0\"?>\n<!-- c -->\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n" +
         entries + "</Collection>\n</VTKFile>\n";
}

TEST_F(Series, TimesAndFiles) {
  const std::string text = series(
      "<DataSet timestep=\"-0.5\" group=\"\" part='0' file=\"a &amp; b.vtu\"/>\n"
      "<DataSet file = 'sub/c.vtu' timestep=\"1e2\"></DataSet>\n<DataSet timestep=\"200\" file=\"/d.vtu\" />\n");
  const std::vector<SeriesStep> steps = read_series(put("s.pvd", text));
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_EQ(steps[0].time, -0.5);
  EXPECT_EQ(steps[0].path, path("a & b.vtu"));
  EXPECT_EQ(steps[1].time, 100);
  EXPECT_EQ(steps[1].path, path("sub/c.vtu"));
  EXPECT_EQ(std::filesystem::path(steps[2].path), std::filesystem::path(path("s.pvd")).root_path() / "d.vtu");
}

TEST_F(Series, CharacterReferences) {
  const auto file_of = [](const std::string& name) {
    return parse_series("s.pvd", series("<DataSet timestep=\"0\" file=\"" + name + "\"/>"))[0].path;
  };
  EXPECT_EQ(file_of("&#97;.vtu"), "a.vtu");
  EXPECT_EQ(file_of("&#xE4;&#228;.vtu"), "\xC3\xA4\xC3\xA4.vtu");
  EXPECT_EQ(file_of("&#x20AC;"), "\xE2\x82\xAC");
  EXPECT_EQ(file_of("&#x1F600;"), "\xF0\x9F\x98\x80");
}

TEST_F(Series, TimesIncreaseOnWritingToo) {
  for (const double time : {0.0, -1.0, double(NAN), double(INFINITY)}) {
    EXPECT_THROW(write_series(path("o.pvd"), {{0, path("a.vtu")}, {time, path("b.vtu")}}), FileError) << time;
  }
  EXPECT_TRUE(files().empty());
}

TEST_F(Series, RoundTrip) {
  const std::vector<SeriesStep> steps{{0.1, path("<a>'\"&.vtu")},
                                      {1.0 / 3, std::filesystem::absolute("/elsewhere/b.vtu").generic_string()}};
  write_series(path("o.pvd"), steps);
  const std::vector<SeriesStep> back = read_series(path("o.pvd"));
  ASSERT_EQ(back.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back[i].time, steps[i].time);
    EXPECT_EQ(back[i].path, steps[i].path);
  }
  EXPECT_TRUE(contains(get("o.pvd"), "file=\"&lt;a&gt;&apos;&quot;&amp;.vtu\""));
}

TEST_F(Series, RelativePathsAreThoseOfTheSeries) {
  const auto relative = [](const std::string& file) { return std::filesystem::relative(file).generic_string(); };
  write_series(relative(path("o.pvd")), {{0, relative(path("sub/a.vtu"))}, {1, relative(path("b.vtu"))}});
  const std::vector<SeriesStep> back = read_series(path("o.pvd"));
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(std::filesystem::path(back[0].path).lexically_normal(), path("sub/a.vtu"));
  EXPECT_EQ(std::filesystem::path(back[1].path).lexically_normal(), path("b.vtu"));
}

TEST_F(Series, RefusesWhatIsNoSeries) {
  const auto refuses = [](const std::string& text, const std::string& said) {
    try {
      parse_series("s.pvd", text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const FileError& e) {
      EXPECT_TRUE(contains(e.what(), said)) << e.what();
      EXPECT_TRUE(contains(e.what(), "s.pvd:")) << e.what();
    }
  };
  const std::string one = "<DataSet timestep=\"0\" file=\"a.vtu\"/>";
  refuses("", "ends early");
  refuses("text", "expected an element");
  refuses("<VTKFile type=\"UnstructuredGrid\">", "not a collection");
  refuses("<VTKFile type=\"Collection\"><Collection/></VTKFile>", "lists no file");
  refuses("<VTKFile type=\"Collection\"/>", "ends early");
  refuses(series("<Points/>"), "s.pvd:5: <Points> in a collection");
  refuses(series("<DataSet file=\"a.vtu\"/>"), "no timestep");
  refuses(series("<DataSet timestep=\"0\"/>"), "names no file");
  refuses(series("<DataSet timestep=\"nan\" file=\"a.vtu\"/>"), "not a finite number");
  refuses(series("<DataSet timestep=\"0x\" file=\"a.vtu\"/>"), "not a finite number");
  refuses(series("<DataSet timestep=\"0\" timestep=\"1\" file=\"a.vtu\"/>"), "given twice");
  refuses(series("<DataSet timestep=0 file=\"a.vtu\"/>"), "no quotes");
  refuses(series("<DataSet timestep=\"0\" file=\"a&b\"/>"), "&amp;");
  for (const char* const reference : {"&#0;", "&#xD800;", "&#x110000;", "&#;", "&#x;", "&#1a;"}) {
    refuses(series("<DataSet timestep=\"0\" file=\"" + std::string(reference) + "\"/>"), "no character");
  }
  refuses(series("<DataSet timestep=\"0\" file=\"&#97\"/>"), "no ; at its end");
  refuses(series(one).insert(series(one).find("</Collection"), "</Foo>"), "expected <DataSet> or </Collection>");
  refuses(series(one + one), "several files");
  refuses(series("<DataSet timestep=\"1\" file=\"b.vtu\"/>" + one), "do not increase");
  refuses(series(one) + "<more/>", "more after");
  refuses("<!-- " + series(one).substr(40, 5), "does not end");
}

}  // namespace
}  // namespace tetune::test
