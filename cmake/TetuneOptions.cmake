# SPDX-License-Identifier: Apache-2.0
# Compile flags, private to each target of ours. Without contracted multiply-adds all compilers and instruction sets
# round alike, for 2 to 3 % of the time: tests/bits/run.
function(tetune_target_options target)
  target_compile_options(${target} PRIVATE
    $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-psabi -Wno-ignored-attributes -fno-math-errno
    -fno-trapping-math -ffp-contract=off>)
  if(TETUNE_NATIVE)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-march=native>)
  endif()
  if(TETUNE_WERROR)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Werror>)
  endif()
  if(TETUNE_SANITIZE)
    target_compile_options(${target} PRIVATE
      $<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${TETUNE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all>)
    target_link_options(${target} PUBLIC -fsanitize=${TETUNE_SANITIZE})
  endif()
endfunction()
