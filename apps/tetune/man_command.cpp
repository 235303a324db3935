// SPDX-License-Identifier: Apache-2.0
// The manual page, from the definitions of the options and what stands here.
#include <fmt/format.h>

#include "aliases.hpp"
#include "commands.hpp"
#include "definitions.hpp"
#include "tetune/version.hpp"

namespace tetune::cli {
namespace {

/// As troff takes it: no line starts with a dot or quote, dashes are dashes.
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
    head = "\\fI" + troff(value_of(o)) + "\\fR";
  } else {
    for (const std::string& name : names_of(o)) head += (head.empty() ? "" : ", ") + ("\\fB" + troff(name) + "\\fR");
    if (takes_value(o)) head += " \\fI" + troff(value_of(o)) + "\\fR";
  }
  std::string text = o.get_description();
  if (takes_value(o) && !o.get_default_str().empty()) text += " (default: " + o.get_default_str() + ")";
  return ".TP\n" + head + "\n" + troff(text) + ".\n";
}

constexpr const char* kDescription = R"(.SH DESCRIPTION
.B tetune optimize
takes a mesh of tetrahedra and makes it better: it flips edges and faces and moves vertices until the elements are good
for a solver.
No element is ever inverted, the smallest dihedral angle does not become smaller, and the boundary is kept as
.B \-\-boundary
says.
The result is the same file for any number of threads.
.PP
Meshes are read and written in the formats of MEDIT, VTK, Exodus, Gmsh and others, and read in TetGen's; the ending says
which.
.B \-
is the standard input or output.
Every file is written under a temporary name and then renamed: a run that fails leaves the old one.
)";

constexpr const char* kSections = R"(.SH INTERRUPTION
On SIGINT (Ctrl\-C) and SIGTERM, and at the time limit, the work stops within about half a second; the mesh is written as
it is then, which is as valid as any result, and the exit code is 1.
A second signal, and one before there is anything to write, ends the process at once: no file is written, and none is left
behind.
.SH EXIT STATUS
.TP
.B 0
Done.
.TP
.B 1
Stopped early, or a target was missed; a valid mesh was written.
Or
.B \-\-untangle
could not repair all; no mesh was written.
Of
.B info
and
.BR compare :
the mesh has no tetrahedron, is not valid, or not of the quality asked for.
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
Let vertices slide on a curved surface, and say how far it may go.
.TP
.B tetune optimize parts/*.mesh \-o better/
Improve several meshes.
.TP
.B tetune optimize \- \- < in.mesh | solver
Improve a mesh in a pipe.
.TP
.B tetune info \-\-check \-\-min\-quality min_dihedral_deg=5 out.mesh
Fail where an element has a smaller dihedral angle.
.SH SEE ALSO
The project's
.IR docs/ :
method, formats, quality, command line.
)";

std::string page(const CLI::App& app) {
  std::string text = ".TH TETUNE 1 2026-11-21 \"tetune " TETUNE_VERSION
                     "\"\n.SH NAME\ntetune \\- make a tetrahedral mesh better\n.SH SYNOPSIS\n";
  const char* between = "";
  for (const CLI::App* c : commands_of(app)) {
    text += fmt::format("{}.B tetune {}\n", between, c->get_name());
    between = ".br\n";
    bool options = false;
    std::string free;
    for (const CLI::Option* o : c->get_options()) {
      options = options || (!is_positional(*o) && o->get_name() != "--help");
      if (is_positional(*o)) free += ".I " + troff(value_of(*o)) + "\n";
    }
    text += (options ? ".RI [ OPTIONS ]\n" : "") + free;
  }
  text += kDescription;
  for (const CLI::App* c : commands_of(app)) {
    std::string title = c->get_name();
    for (char& ch : title) ch = static_cast<char>(std::toupper(static_cast<unsigned char>(ch)));
    text += fmt::format(".SH {}\n{}\n", title, troff(c->get_description()));
    std::string group = "Options";
    for (const CLI::Option* o : c->get_options([](const CLI::Option* each) { return is_positional(*each); })) {
      text += option_item(*o);
    }
    for (const std::string& each : c->get_groups()) {
      bool first = true;
      for (const CLI::Option* o : c->get_options()) {
        if (is_positional(*o) || o->get_group() != each) continue;
        if (first && each != group) text += ".SS " + troff(each) + "\n";
        first = false;
        text += option_item(*o);
      }
    }
    if (c->get_name() != "optimize") continue;
    text += ".SS Names that users of Mmg know\nA long option may have one dash.\n";
    for (const auto& [alias, ours] : alias_table()) {
      text += fmt::format(".TP\n\\fB{}\\fR\n{}.\n", troff(alias), troff(ours));
    }
  }
  return text + kSections;
}

}  // namespace

void add_man(CLI::App& app) {
  app.add_subcommand("man", "Print the manual page.")->callback([&app] { fmt::print("{}", page(app)); });
}

}  // namespace tetune::cli
