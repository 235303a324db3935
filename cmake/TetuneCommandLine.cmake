# SPDX-License-Identifier: Apache-2.0
# The command line waits for the library: less optimization halves the time that its sources take to compile.
function(tetune_command_line_options target)
  tetune_target_options(${target})
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# The libraries that the command line is built with: the system's packages where they are (Debian: libcli11-dev libfmt-dev
# nlohmann-json3-dev), else these releases: CLI11 2.5.0, fmt 11.2.0, nlohmann/json 3.11.3. toml++ (Debian:
# libtomlplusplus-dev) is optional: without it the command line has the criteria of programs, and reads no files of them.
if(CMAKE_CROSSCOMPILING)
  include(TetuneHeaderLibraries)
  if(TARGET CLI11::CLI11)
    return()
  endif()
endif()
include(FetchContent)
FetchContent_Declare(CLI11 GIT_REPOSITORY https://github.com/CLIUtils/CLI11.git
  GIT_TAG 4160d259d961cd393fd8d67590a8c7d210207348 FIND_PACKAGE_ARGS)
FetchContent_Declare(fmt GIT_REPOSITORY https://github.com/fmtlib/fmt.git
  GIT_TAG 40626af88bd7df9a5fb80be7b25ac85b122d6c21 FIND_PACKAGE_ARGS)
FetchContent_Declare(nlohmann_json GIT_REPOSITORY https://github.com/nlohmann/json.git
  GIT_TAG 9cca280a4d0ccf0c08f47a99aa71d1b0e52f8d03 FIND_PACKAGE_ARGS)
FetchContent_MakeAvailable(CLI11 fmt nlohmann_json)
find_package(tomlplusplus QUIET)
if(NOT tomlplusplus_FOUND)
  message(STATUS "toml++ is not installed: --criteria takes no files")
endif()
