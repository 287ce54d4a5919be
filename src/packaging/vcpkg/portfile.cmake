# SPDX-License-Identifier: MIT
#
# An overlay port, which builds the sources that it lies in:
#
#     vcpkg install mlrt --overlay-ports=/path/of/the/sources/src/packaging/vcpkg
#
# vcpkg looks only at the files of this folder to see whether an installed port is up to date: after other changes of
# the sources, remove and install it anew.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

# Release and debug builds would be the same bytes (src/packaging/CMakeLists.txt), so one serves both.
set(VCPKG_BUILD_TYPE release)

vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}/src/packaging")
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/mlrt)
vcpkg_fixup_pkgconfig()
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
