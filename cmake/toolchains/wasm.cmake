# SPDX-License-Identifier: Apache-2.0
# WebAssembly, run by node, which hands it the file system (Debian: emscripten). One thread, or TETUNE_WASM_THREADS.
find_path(TETUNE_EMSCRIPTEN cmake/Modules/Platform/Emscripten.cmake
  PATHS $ENV{EMSDK}/upstream/emscripten /usr/share/emscripten NO_DEFAULT_PATH REQUIRED)
include(${TETUNE_EMSCRIPTEN}/cmake/Modules/Platform/Emscripten.cmake)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES TETUNE_WASM_THREADS)
set(CMAKE_CXX_FLAGS_INIT "-fexceptions -msimd128")
if(TETUNE_WASM_THREADS)
  string(APPEND CMAKE_CXX_FLAGS_INIT " -pthread")
endif()
set(CMAKE_EXE_LINKER_FLAGS_INIT
  "-fexceptions -sALLOW_MEMORY_GROWTH=1 -sMAXIMUM_MEMORY=4GB -sNODERAWFS=1 -sEXIT_RUNTIME=1")
# With fetch(), which node has from 18 on, Emscripten 3.1 looks for the program on a server.
set(CMAKE_CROSSCOMPILING_EMULATOR node --no-experimental-fetch)
