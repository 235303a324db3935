# SPDX-License-Identifier: Apache-2.0
# The shared library once more for processors with AVX2 and with AVX-512 (x86-64-v3 and -v4). They lie where the
# system's loader looks first on such a processor (glibc 2.33 or newer); on all others the one for any x86-64 runs.
if(NOT CMAKE_SYSTEM_NAME STREQUAL Linux OR NOT CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|amd64|AMD64)$")
  set(why_not "Linux on x86-64")
elseif(NOT BUILD_SHARED_LIBS OR TETUNE_NATIVE OR TETUNE_CUDA)
  set(why_not "-DBUILD_SHARED_LIBS=ON -DTETUNE_NATIVE=OFF and a build without CUDA")
endif()
if(NOT why_not)
  set(levels v3 v4)
  # Nor do programs that were compiled for any x86-64 lend it their functions.
  target_link_options(tetune PRIVATE LINKER:-Bsymbolic-functions)
elseif(TETUNE_DISPATCH STREQUAL "AUTO")
  message(STATUS "TETUNE_DISPATCH: one library; more need ${why_not}")
else()
  message(FATAL_ERROR "TETUNE_DISPATCH needs ${why_not}")
endif()

# All that the first library is made of, for another level.
foreach(level ${levels})
  set(folder glibc-hwcaps/x86-64-${level})
  get_target_property(sources tetune SOURCES)
  add_library(tetune_${level} SHARED ${sources})
  target_compile_features(tetune_${level} PRIVATE cxx_std_20)
  target_include_directories(tetune_${level} PRIVATE include src)
  target_link_libraries(tetune_${level} PRIVATE Threads::Threads)
  tetune_target_options(tetune_${level})
  target_compile_options(tetune_${level} PRIVATE -march=x86-64-${level})
  target_link_options(tetune_${level} PRIVATE LINKER:-Bsymbolic-functions)
  set_target_properties(tetune_${level} PROPERTIES OUTPUT_NAME tetune
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/${folder})
  install(TARGETS tetune_${level} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/${folder})
  add_dependencies(tetune tetune_${level})
endforeach()
