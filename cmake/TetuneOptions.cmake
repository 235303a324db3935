# SPDX-License-Identifier: Apache-2.0
# Compile flags, private to each target of this project. Two of them relax IEEE semantics, as -ffast-math also does:
# -fno-math-errno (functions such as sqrt do not set errno) and -fno-trapping-math (floating-point exceptions are not
# observed, so that comparisons and selections vectorize). Neither changes a value. No other part of -ffast-math is used:
# nothing is reassociated, and NaN, infinities and signed zeros are honored. -ffp-contract=off forbids fused
# multiply-adds, so that all compilers and instruction sets round alike, at a cost of 2 to 3 % of the time:
# tests/bits/run.
function(tetune_target_options target)
  target_compile_options(${target} PRIVATE
    $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-psabi -Wno-ignored-attributes -fno-math-errno
    -fno-trapping-math -ffp-contract=off>)
  if(EMSCRIPTEN)
    # Sizes of arrays have 64 bits in the code, and 32 in the memory of WebAssembly.
    target_compile_options(${target} PRIVATE -Wno-shorten-64-to-32 -Wno-sign-conversion)
  endif()
  if(MINGW)
    # Several sources compile the same inline function, and the linker takes one. GCC for Windows assumes in each of them
    # that it takes that source's, and keeps values in registers that the other one may use.
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-ipa-ra -fno-ipa-stack-alignment>)
  endif()
  if(TETUNE_NATIVE)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-march=native>)
  endif()
  if(TETUNE_WERROR)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Werror>)
  endif()
  if(TETUNE_SANITIZE)
    target_compile_options(${target} PRIVATE
      $<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${TETUNE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all>
      # These checks of each access double the time that GCC takes. A null pointer ends in a page fault; the fuzz targets
      # have all checks (tests/fuzz/CMakeLists.txt).
      $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-sanitize=null,alignment,object-size,vptr>
      # GCC reports false positives of this warning in instrumented code, in its own <regex> for one.
      $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-maybe-uninitialized>)
    target_link_options(${target} PUBLIC -fsanitize=${TETUNE_SANITIZE})
  endif()
endfunction()
