// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

/// The process of a command line: its arguments, standard streams and interruptions. One of process_posix.cpp and
/// process_windows.cpp is compiled, into the programs and not into the library.
namespace tetune::process {

/// Opens standard streams that are closed: otherwise the next file to be opened would get the number of a stream, and
/// messages would be written into it. On Windows the streams become binary, and a console shows UTF-8.
void prepare_standard_streams();

/// The words of the command line after the name of the program: bytes, on Windows UTF-8. Windows hands patterns such as
/// *.mesh on as they are: there a word with * or ? is replaced by the names of the files that it fits, in alphabetic
/// order, if there are any.
std::vector<std::string> arguments(int argc, char** argv);

bool is_terminal(int descriptor);

/// Calls `handle` on an interruption (Ctrl-C) or a request to end, unless the process was started such that it ignores
/// them. `handle` may be called while any other function runs, or by another thread.
void on_interruption(void (*handle)());

/// Writes to the standard error. May be called by a handler of interruptions, as may leave().
void write_error(std::string_view text) noexcept;
/// Ends the process at once, without destructors.
[[noreturn]] void leave(int exit_code) noexcept;

}  // namespace tetune::process
