# SPDX-License-Identifier: Apache-2.0
# The clone that this file is in; the port of a release has vcpkg_from_github() here.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

vcpkg_check_features(OUT_FEATURE_OPTIONS feature_options FEATURES tools TETUNE_APPS)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}" OPTIONS ${feature_options} -DTETUNE_DISPATCH=OFF -DTETUNE_MPI=OFF
  -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON -DGMSH_INCLUDE_DIR=OFF -DOCCT_INCLUDE_DIR=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/tetune)
if("tools" IN_LIST FEATURES)
  vcpkg_copy_tools(TOOL_NAMES tetune AUTO_CLEAN)
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
