# SPDX-License-Identifier: Apache-2.0
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${text}")
  endif()
endfunction()
file(REMOVE_RECURSE ${WORK}/prefix ${WORK}/consumer ${WORK}/readme ${WORK}/c_page)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/consumer -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DCMAKE_CXX_COMPILER=${COMPILER} -DMPI_PROGRAM=${MPI_PROGRAM})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/consumer)
if(MPI_PROGRAM)
  run(${WORK}/consumer/consumer_mpi -n 4)
endif()
# The program and the project that README.md shows.
file(WRITE ${WORK}/readme/in.mesh "MeshVersionFormatted 2 Dimension 3 Vertices 4 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 0
  Tetrahedra 1 1 2 3 4 1 End")
file(READ ${README} readme)
string(REGEX MATCH "```cpp\n(#include[^\n]*\n)([^`]*)```" found "${readme}")
file(WRITE ${WORK}/readme/main.cpp "${CMAKE_MATCH_1}int main() {\n${CMAKE_MATCH_2}}\n")
string(REGEX MATCH "```cmake\n([^`]*)```" found "${readme}")
file(WRITE ${WORK}/readme/CMakeLists.txt
  "cmake_minimum_required(VERSION 3.25)\nproject(readme LANGUAGES CXX)\nadd_executable(app main.cpp)\n${CMAKE_MATCH_1}")
run(${CMAKE_COMMAND} -S ${WORK}/readme -B ${WORK}/readme/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${WORK}/readme/build)
run(${CMAKE_COMMAND} -E chdir ${WORK}/readme build/app)
if(NOT EXISTS ${WORK}/readme/out.meshb)
  message(FATAL_ERROR "the program of README.md wrote no out.meshb")
endif()
# The C program that docs/c.md shows.
file(READ ${C_PAGE} page)
string(REGEX MATCH "```c\n([^`]*)```" found "${page}")
file(WRITE ${WORK}/c_page/main.c "${CMAKE_MATCH_1}")
string(REGEX MATCH "```cmake\n([^`]*)```" found "${page}")
file(WRITE ${WORK}/c_page/CMakeLists.txt
  "cmake_minimum_required(VERSION 3.25)\nproject(page LANGUAGES C CXX)\nadd_executable(app main.c)\n${CMAKE_MATCH_1}")
run(${CMAKE_COMMAND} -S ${WORK}/c_page -B ${WORK}/c_page/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${WORK}/c_page/build)
file(COPY ${WORK}/readme/in.mesh DESTINATION ${WORK}/c_page)
run(${CMAKE_COMMAND} -E chdir ${WORK}/c_page build/app)
if(NOT EXISTS ${WORK}/c_page/out.meshb)
  message(FATAL_ERROR "the program of docs/c.md wrote no out.meshb")
endif()
# The manual and the completions, where the command line was built.
if(EXISTS ${WORK}/prefix/bin/tetune)
  foreach(file share/man/man1/tetune.1 share/bash-completion/completions/tetune share/zsh/site-functions/_tetune
      share/fish/vendor_completions.d/tetune.fish)
    if(NOT EXISTS ${WORK}/prefix/${file})
      message(FATAL_ERROR "not installed: ${file}")
    endif()
  endforeach()
endif()
# The installed command line finds the installed plugins.
if(EXISTS ${WORK}/prefix/bin/tetune AND EXISTS ${WORK}/prefix/libexec/tetune/tetune-vtk)
  file(WRITE ${WORK}/one.mesh "MeshVersionFormatted 2 Dimension 3 Vertices 4 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 0
    Tetrahedra 1 1 2 3 4 1 End")
  run(${WORK}/prefix/bin/tetune optimize ${WORK}/one.mesh -o ${WORK}/one.vtu)
  run(${WORK}/prefix/bin/tetune info ${WORK}/one.vtu)
endif()
