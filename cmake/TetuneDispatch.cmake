# SPDX-License-Identifier: Apache-2.0
# The shared library once more for processors with AVX2 and with AVX-512 (x86-64-v3 and -v4). They lie where the
# system's loader looks first on such a processor (glibc 2.33 or newer); on all others the one for any x86-64 runs.
if(NOT BUILD_SHARED_LIBS OR TETUNE_NATIVE OR TETUNE_CUDA)
  message(FATAL_ERROR "TETUNE_DISPATCH needs -DBUILD_SHARED_LIBS=ON -DTETUNE_NATIVE=OFF and a build without CUDA")
endif()
if(CMAKE_SYSTEM_NAME STREQUAL Linux AND CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|amd64|AMD64)$")
  set(levels v3 v4)
else()
  set(levels)
  message(STATUS "TETUNE_DISPATCH: one library, as there are no levels of this processor")
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
  set_target_properties(tetune_${level} PROPERTIES OUTPUT_NAME tetune
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/${folder})
  install(TARGETS tetune_${level} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/${folder})
  add_dependencies(tetune tetune_${level})
endforeach()
