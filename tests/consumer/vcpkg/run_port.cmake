# SPDX-License-Identifier: MIT
#
# Runs src/packaging/vcpkg/portfile.cmake where there is no vcpkg:
#
#     cmake -DPORT_FOLDER=... -DBUILD=... -DPACKAGE=... -DLINKAGE=static -DGENERATOR=Ninja -P run_port.cmake
#
# A stand-in for vcpkg: for the functions and variables that the port uses it does what vcpkg's documentation says, and
# leaves the package in PACKAGE. It knows nothing of triplets, dependencies and debug builds. BUILD may be that of an
# earlier run, which saves time.
cmake_minimum_required(VERSION 3.20)
set(PORT mlrt)
set(CURRENT_PORT_DIR "${PORT_FOLDER}")
set(CURRENT_BUILDTREES_DIR "${BUILD}")
set(CURRENT_PACKAGES_DIR "${PACKAGE}")
set(VCPKG_LIBRARY_LINKAGE "${LINKAGE}")

function(run)
    execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(status)
        message(FATAL_ERROR "${ARGV}: ${status}\n${output}")
    endif()
endfunction()

function(vcpkg_cmake_configure)
    cmake_parse_arguments(PARSE_ARGV 0 arg "" SOURCE_PATH OPTIONS)
    if(arg_UNPARSED_ARGUMENTS OR NOT arg_SOURCE_PATH OR NOT VCPKG_BUILD_TYPE STREQUAL "release")
        message(FATAL_ERROR "vcpkg_cmake_configure: arguments, or a debug build, that this stand-in does not know")
    endif()
    set(shared ON)
    if(VCPKG_LIBRARY_LINKAGE STREQUAL "static")
        set(shared OFF)
    endif()
    run(${CMAKE_COMMAND} -S ${arg_SOURCE_PATH} -B ${CURRENT_BUILDTREES_DIR} -DCMAKE_BUILD_TYPE=Release
        -DBUILD_SHARED_LIBS=${shared} -DCMAKE_INSTALL_PREFIX=${CURRENT_PACKAGES_DIR} -DCMAKE_INSTALL_LIBDIR=lib
        -DCMAKE_INSTALL_BINDIR=bin -DCMAKE_ERROR_ON_ABSOLUTE_INSTALL_DESTINATION=ON -G ${GENERATOR} ${arg_OPTIONS})
endfunction()

function(vcpkg_cmake_install)
    run(${CMAKE_COMMAND} --build ${CURRENT_BUILDTREES_DIR} --target install)
endfunction()

# Moves the package's files to share/mlrt, which is two folders below the prefix.
function(vcpkg_cmake_config_fixup)
    cmake_parse_arguments(PARSE_ARGV 0 arg "" CONFIG_PATH "")
    file(GLOB files "${CURRENT_PACKAGES_DIR}/${arg_CONFIG_PATH}/*")
    file(COPY ${files} DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
    file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/lib/cmake")
    file(GLOB files "${CURRENT_PACKAGES_DIR}/share/${PORT}/*.cmake")
    set(up "get_filename_component(_IMPORT_PREFIX \"\${_IMPORT_PREFIX}\" PATH)\n")
    foreach(file IN LISTS files)
        file(READ "${file}" text)
        string(REPLACE "${up}${up}${up}" "${up}${up}" text "${text}")
        file(WRITE "${file}" "${text}")
    endforeach()
endfunction()

function(vcpkg_fixup_pkgconfig)
    if(NOT EXISTS "${CURRENT_PACKAGES_DIR}/lib/pkgconfig/mlrt.pc")
        message(FATAL_ERROR "vcpkg_fixup_pkgconfig: no file for pkg-config")
    endif()
endfunction()

function(vcpkg_install_copyright)
    cmake_parse_arguments(PARSE_ARGV 0 arg "" "" FILE_LIST)
    file(INSTALL ${arg_FILE_LIST} DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}" RENAME copyright)
endfunction()

include("${PORT_FOLDER}/portfile.cmake")
