# SPDX-License-Identifier: Apache-2.0
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${text}")
  endif()
endfunction()
file(REMOVE_RECURSE ${WORK}/prefix ${WORK}/consumer ${WORK}/shown)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/consumer -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DCMAKE_CXX_COMPILER=${COMPILER} -DMPI_PROGRAM=${MPI_PROGRAM})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/consumer)
if(MPI_PROGRAM)
  run(${WORK}/consumer/consumer_mpi -n 4)
endif()
# Builds and runs the program and the project that a page shows: `pattern` finds the program.
function(run_shown page pattern source languages opening closing)
  get_filename_component(name ${page} NAME_WE)
  set(folder ${WORK}/shown/${name})
  file(WRITE ${folder}/in.mesh "MeshVersionFormatted 2 Dimension 3 Vertices 4 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 0
    Tetrahedra 1 1 2 3 4 1 End")
  file(READ ${page} text)
  string(REGEX MATCH "${pattern}" found "${text}")
  file(WRITE ${folder}/${source} "${CMAKE_MATCH_1}${opening}${CMAKE_MATCH_2}${closing}")
  string(REGEX MATCH "```cmake\n([^`]*)```" found "${text}")
  file(WRITE ${folder}/CMakeLists.txt
    "cmake_minimum_required(VERSION 3.25)\nproject(shown LANGUAGES ${languages})\nadd_executable(app ${source})\n${CMAKE_MATCH_1}")
  run(${CMAKE_COMMAND} -S ${folder} -B ${folder}/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix
    -DCMAKE_CXX_COMPILER=${COMPILER})
  run(${CMAKE_COMMAND} --build ${folder}/build)
  run(${CMAKE_COMMAND} -E chdir ${folder} build/app)
  if(NOT EXISTS ${folder}/out.meshb)
    message(FATAL_ERROR "the program of ${page} wrote no out.meshb")
  endif()
endfunction()
run_shown(${README} "```cpp\n(#include[^\n]*\n)([^`]*)```" main.cpp CXX "int main() {\n" "}\n")
run_shown(${C_PAGE} "```c\n(#include[^\n]*\n)([^`]*)```" main.c "C CXX" "" "")
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
