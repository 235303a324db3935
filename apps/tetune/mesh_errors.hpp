// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tetune/tetune.hpp"

/// Errors of a mesh in the words of the command line: ids start from 1 as in MEDIT files, and options are flags.
namespace tetune::cli {

/// The advice for a mesh that untangling makes valid, for commands with --untangle and for others.
inline constexpr const char* kUntangleHere = "untangle them (--untangle)";
inline constexpr const char* kUntangleFirst = "untangle them first (tetune optimize --untangle)";

/// The tetrahedra that --untangle left, and the position of the first.
std::string untangle_message(const UntangleError& error, const TetMesh& mesh);

/// The defects that validate() has found in a mesh. If it is curved, --untangle helps its straight tetrahedra only.
std::string validity_message(const ValidationReport& report, const TetMesh& mesh, const char* advice = kUntangleHere);

/// Throws the error that is being handled again, for with_messages().
[[noreturn]] void rethrow_with_message(const std::string& file, const TetMesh& mesh, int threads, const char* advice);

/// Calls the library for a mesh, which it leaves as it is where it throws. Errors then name the file, its own numbers
/// of elements, and flags; where validate() finds defects, these.
template <class F>
auto with_messages(const std::string& file, const TetMesh& mesh, int threads, const char* advice, const F& work) {
  try {
    return work();
  } catch (const Error&) {
    rethrow_with_message(file, mesh, threads, advice);
  }
}

}  // namespace tetune::cli
