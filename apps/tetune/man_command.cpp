// SPDX-License-Identifier: Apache-2.0
// The manual page: the definitions of the options, and the sections below.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "aliases.hpp"
#include "commands.hpp"
#include "definitions.hpp"
#include "tetune/version.hpp"

namespace tetune::cli {
namespace {

/// Escapes backslashes and dashes, and a dot or quote at the beginning, for troff.
std::string troff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  if (out.starts_with('.') || out.starts_with('\'')) out.insert(0, "\\&");
  return out;
}

std::string option_item(const CLI::Option& o) {
  std::string head;
  if (is_positional(o)) {
    head = "\\fI" + troff(placeholder_of(o)) + "\\fR";
  } else {
    for (const std::string& name : names_of(o)) head += (head.empty() ? "" : ", ") + ("\\fB" + troff(name) + "\\fR");
    if (takes_value(o)) head += " \\fI" + troff(placeholder_of(o)) + "\\fR";
  }
  std::string text = o.get_description();
  if (takes_value(o) && !o.get_default_str().empty()) text += " (default: " + o.get_default_str() + ")";
  return ".TP\n" + head + "\n" + troff(text) + ".\n";
}

constexpr const char* kDescription = R"(.SH DESCRIPTION
.B tetune optimize
improves a tetrahedral mesh: it flips edges and faces and moves vertices until the elements are suitable for a solver.
No element is inverted, the smallest dihedral angle does not decrease, and
.B \-\-boundary
says how the boundary may change.
The result is the same file for any number of threads.
.PP
Meshes are read and written in the formats of MEDIT, VTK, Exodus, Gmsh, TetGen and others; the ending of
the name selects the format.
.B \-
is the standard input or output.
Every output replaces the old file only when it is complete: a run that fails leaves the old file.
)";

constexpr const char* kSections = R"(.SH INTERRUPTION
On SIGINT (Ctrl\-C) and SIGTERM, and at the time limit, the work stops within about half a second; the mesh at that time,
which is as valid as any result, is written, and the exit code is 1.
With
.BR "\-\-data conserve"
data are still transferred, for at most as long as the run has taken before; then they are interpolated.
A second signal, or one before there is anything to write, ends the process at once: no file is written, and temporary
files are removed.
.SH EXIT STATUS
.TP
.B 0
Success.
.TP
.B 1
Stopped early, a target was missed or not reached, a criterion failed, or the report, trace or map could not be written;
a valid mesh was written.
Or
.B \-\-untangle
could not repair all tetrahedra; no mesh was written.
Or, of
.B info
and
.BR compare ,
the mesh has no tetrahedron, is not valid, or not of the required quality.
.TP
.B 2
Nothing was written.
.PP
Of several meshes, the largest of their codes.
.SH EXAMPLES
.TP
.B tetune optimize in.mesh out.meshb
Improve a mesh.
.TP
.B tetune optimize part.mesh out.mesh \-\-boundary slide \-\-max\-deviation 0.1%
Let vertices slide on a curved surface, and bound its deviation.
.TP
.B tetune optimize parts/*.mesh \-o better/
Improve several meshes.
.TP
.B tetune optimize \- \- < in.mesh | solver
Improve a mesh in a pipe.
.TP
.B tetune info \-\-check \-\-min\-quality min_dihedral_deg=5 out.mesh
Exit with 1 if an element has a smaller dihedral angle.
.SH SEE ALSO
The project's
.IR docs/ :
method, formats, quality, command line.
)";

std::string synopsis(const CLI::App& command) {
  std::string text = fmt::format(".B tetune {}\n", command.get_name());
  bool has_options = false;
  std::string positionals;
  for (const CLI::Option* o : command.get_options()) {
    has_options = has_options || (!is_positional(*o) && o->get_name() != "--help");
    if (is_positional(*o)) positionals += ".I " + troff(placeholder_of(*o)) + "\n";
  }
  return text + (has_options ? ".RI [ OPTIONS ]\n" : "") + positionals;
}

/// The section of a command: its options by groups.
std::string section(const CLI::App& command) {
  std::string title = command.get_name();
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string text = fmt::format(".SH {}\n{}\n", title, troff(command.get_description()));
  for (const CLI::Option* o : command.get_options()) {
    if (is_positional(*o)) text += option_item(*o);
  }
  for (const std::string& group : command.get_groups()) {
    bool has_title = group == "Options";
    for (const CLI::Option* o : command.get_options()) {
      if (is_positional(*o) || o->get_group() != group) continue;
      if (!std::exchange(has_title, true)) text += ".SS " + troff(group) + "\n";
      text += option_item(*o);
    }
  }
  return text;
}

std::string page(const CLI::App& app) {
  std::string text = ".TH TETUNE 1 " TETUNE_DATE " \"tetune " TETUNE_VERSION
                     "\"\n.SH NAME\ntetune \\- improve a tetrahedral mesh\n.SH SYNOPSIS\n";
  const char* between = "";
  for (const CLI::App* c : commands_of(app)) text += std::exchange(between, ".br\n") + synopsis(*c);
  text += kDescription;
  for (const CLI::App* c : commands_of(app)) {
    text += section(*c);
    if (c->get_name() != "optimize") continue;
    text += ".SS Options of Mmg\nA long option may have one dash.\n";
    for (const auto& [alias, words] : alias_table()) {
      text += fmt::format(".TP\n\\fB{}\\fR\n{}.\n", troff(alias), troff(words));
    }
  }
  return text + kSections;
}

}  // namespace

void add_man(CLI::App& app) {
  app.add_subcommand("man", "Print the manual page.")->callback([&app] { fmt::print("{}", page(app)); });
}

}  // namespace tetune::cli
