# SPDX-License-Identifier: Apache-2.0
# The shared library once more for processors with AVX2 or with AVX-512 (x86-64-v3 and -v4). They lie where the
# system's loader looks first on such a processor (glibc 2.33 or newer); on all others the one for any x86-64 runs.
# AVX-512 is 2 % faster than AVX2 (docs/benchmarks/cpu.md), which is not worth the time of compiling by default.
# TETUNE_LEVELS: the targets are tetune_v3 and so on, in the folders glibc-hwcaps/x86-64-v3 and so on.
set(TETUNE_DISPATCH_LEVELS v3 CACHE STRING "For TETUNE_DISPATCH: v3, v4 or v3;v4")
set(TETUNE_LEVELS)
if(NOT CMAKE_SYSTEM_NAME STREQUAL Linux OR NOT CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|amd64|AMD64)$")
  set(needs "Linux on x86-64")
elseif(NOT BUILD_SHARED_LIBS OR TETUNE_NATIVE OR TETUNE_CUDA)
  set(needs "-DBUILD_SHARED_LIBS=ON -DTETUNE_NATIVE=OFF and a build without CUDA")
else()
  set(TETUNE_LEVELS ${TETUNE_DISPATCH_LEVELS})
endif()
if(NOT TETUNE_LEVELS)
  if(NOT TETUNE_DISPATCH STREQUAL "AUTO")
    message(FATAL_ERROR "TETUNE_DISPATCH needs ${needs}")
  endif()
  message(STATUS "TETUNE_DISPATCH: one library; more need ${needs}")
  return()
endif()

# Calls inside these libraries must not bind to copies of inline functions in a program, which are for any x86-64.
target_link_options(tetune PRIVATE LINKER:-Bsymbolic-functions)
get_target_property(sources tetune SOURCES)
foreach(level ${TETUNE_LEVELS})
  add_library(tetune_${level} SHARED ${sources})
  tetune_library(tetune_${level})
  target_compile_options(tetune_${level} PRIVATE -march=x86-64-${level})
  target_link_options(tetune_${level} PRIVATE LINKER:-Bsymbolic-functions)
  set_target_properties(tetune_${level} PROPERTIES OUTPUT_NAME tetune
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/glibc-hwcaps/x86-64-${level})
  install(TARGETS tetune_${level} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/glibc-hwcaps/x86-64-${level}
    NAMELINK_SKIP)
  add_dependencies(tetune tetune_${level})
endforeach()
