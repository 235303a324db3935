# SPDX-License-Identifier: Apache-2.0
# The CUDA instantiations of the kernels, compiled for every architecture from sm_75 to sm_90.
if(TETUNE_PTXSIM)
  # The simulator reads the code for virtual architectures, which is text.
  set(CMAKE_CUDA_ARCHITECTURES 75-virtual 90-virtual)
  set(CMAKE_CUDA_RUNTIME_LIBRARY None)
elseif(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
  set(CMAKE_CUDA_ARCHITECTURES 75 80 86 89 90)
endif()
enable_language(CUDA)
find_package(CUDAToolkit REQUIRED)

# CMake 3.25 does not know how to ask nvcc 12 and newer for C++20, hence the flag below. Without contracted multiply-adds
# a kernel rounds as the same code does on the CPU, and so as the emulation that the tests run.
function(tetune_cuda_options target)
  set_target_properties(${target} PROPERTIES CUDA_ARCHITECTURES "${CMAKE_CUDA_ARCHITECTURES}")
  target_compile_options(${target} PRIVATE
    $<$<COMPILE_LANGUAGE:CUDA>:-std=c++20 -fmad=false -t=0 -Xcompiler=-Wall,-Wextra>)
  if(TETUNE_WERROR)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:-Werror=all-warnings -Xcompiler=-Werror>)
  endif()
  if(TETUNE_PTXSIM)
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CUDA>:--no-compress -lineinfo>)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:tetune_ptxsim>)
  else()
    target_link_libraries(${target} PRIVATE CUDA::cudart_static)
  endif()
endfunction()

if(TETUNE_PTXSIM)
  add_subdirectory(tests/ptxsim)
endif()
set(cuda_sources src/driver/driver_cuda.cu src/operators/operators_cuda.cu src/relocation/relocation_cuda.cu)
set_source_files_properties(${cuda_sources} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
foreach(library ${TETUNE_LIBRARIES})
  target_sources(${library} PRIVATE ${cuda_sources})
  tetune_cuda_options(${library})
endforeach()
