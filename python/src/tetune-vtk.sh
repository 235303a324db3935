#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The plugin for VTK's files of a package that was built without VTK: starts _vtk_program.py with the interpreter of the
# installation that this file is part of, PREFIX/lib/pythonX.Y/site-packages/tetune/libexec/tetune.
package=$(dirname "$(dirname "$(dirname "$(readlink -f "$0")")")")
library=$(dirname "$(dirname "$package")")
version=${library##*/}
for python in "$(dirname "$(dirname "$library")")/bin/$version" "/usr/bin/$version" "/usr/local/bin/$version"; do
  # Isolated: neither the environment nor the working folder adds code.
  [ -x "$python" ] && exec "$python" -I "$package/_vtk_program.py" "$@"
done
exit 126  # kPluginNoInterpreter in src/io/plugin/plugin_protocol.hpp
