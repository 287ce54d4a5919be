#!/bin/sh
# SPDX-License-Identifier: MIT
#
# make test-install: installs into scratch folders in three ways, builds consumers there with pkg-config and with CMake,
# shared and static, in C and C++, runs them, and looks whether `make uninstall` leaves anything. Also whether
# debugging information is left out, and whether the manual page and `make help` are complete.
# tests/consumer/check.sh FOLDER
set -eu
mkdir -p "$1"
folder=$(cd "$1" && pwd)
build=$(dirname "$folder")
source=$(cd "$(dirname "$0")" && pwd)
scene=$source/../../bindings/c
: "${CC:=cc}" "${CXX:=c++}" "${MAKE:=make}"
done_list=

fail()
{
    echo "test-install: $*"
    exit 1
}

# A program that needs the shared library, or must not.
run_shared()
{
    readelf -d "$1" | grep -q 'NEEDED.*libmlrt\.so\.0' || fail "$1 does not use the shared library"
    LD_LIBRARY_PATH=$2 "$1" >"$1.log" || fail "$1 fails"
}

run_static()
{
    if readelf -d "$1" | grep 'NEEDED.*libmlrt'; then fail "$1 uses the shared library"; fi
    "$1" >"$1.log" || fail "$1 fails"
}

# consume NAME LIBDIR PREFIX MLRT_DIR: where things are now. CMake looks below PREFIX, or in MLRT_DIR alone.
consume()
{
    out=$folder/$1-out
    libdir=$2
    mkdir -p "$out"
    if command -v pkg-config >/dev/null; then
        export PKG_CONFIG_LIBDIR="$libdir/pkgconfig"
        [ "$(pkg-config --modversion mlrt)" = "$VERSION" ] || fail "$1: pkg-config does not know the version"
        $CC -std=c99 -I"$scene" "$source/main.c" $(pkg-config --cflags --libs mlrt) -o "$out/pkg-shared"
        run_shared "$out/pkg-shared" "$libdir"
        $CXX -std=c++11 -I"$scene" "$source/main.cpp" $(pkg-config --cflags --libs mlrt) -o "$out/pkg-shared-cpp"
        run_shared "$out/pkg-shared-cpp" "$libdir"
        $CC -std=c99 -I"$scene" -static "$source/main.c" $(pkg-config --cflags --static --libs mlrt) -o "$out/pkg-static"
        run_static "$out/pkg-static"
        unset PKG_CONFIG_LIBDIR
        done_list="$done_list $1/pkg-config"
    else
        echo "test-install: no pkg-config: not tested"
    fi
    if command -v cmake >/dev/null; then
        cmake -S "$source" -B "$out/cmake" -DCMAKE_C_COMPILER="$CC" -DCMAKE_CXX_COMPILER="$CXX" -DCMAKE_PREFIX_PATH="$3" \
            -Dmlrt_DIR="$4" -DWANTED=0.1 -DSCENE="$scene" >"$out/cmake.log" || fail "$1: cmake finds no mlrt 0.1: see $out/cmake.log"
        cmake --build "$out/cmake" >>"$out/cmake.log" || fail "$1: cmake cannot build: see $out/cmake.log"
        grep -q "mlrt_DIR.*=$libdir/cmake/mlrt" "$out/cmake/CMakeCache.txt" || fail "$1: cmake found another mlrt"
        run_shared "$out/cmake/use_mlrt" "$libdir"
        run_shared "$out/cmake/use_mlrt_cpp" "$libdir"
        run_static "$out/cmake/use_mlrt_static"
        run_static "$out/cmake/use_mlrt_static_cpp"
        for version in 0.99 1.0; do
            if cmake -S "$source" -B "$out/cmake-$version" -DCMAKE_C_COMPILER="$CC" -DCMAKE_PREFIX_PATH="$3" -Dmlrt_DIR="$4" \
                -DWANTED=$version >"$out/cmake-$version.log" 2>&1; then fail "$1: cmake takes $VERSION for $version"; fi
        done
        done_list="$done_list $1/cmake"
    else
        echo "test-install: no cmake: not tested"
    fi
}

# has_debug FILE: is there debugging information?
has_debug()
{
    readelf -S "$1" | grep -q '\.debug_info'
}

# The page names every function and every status code of the header.
check_manual()
{
    for name in $(sed -n 's/^MLRT_API .*[ *]\(mlrt_[a-z0-9_]*\)(.*/\1/p; s/^    \(MLRT_ERROR_[A-Z_]*\) = .*/\1/p' "$source/../../include/mlrt.h"); do
        [ "$(grep -c "\b$name\b" "$1")" -ge 1 ] || fail "the manual page has no $name"
        grep -A 1 '^\.TP' "$1" | grep -q "^\.BR\{0,1\} $name\b" || fail "the manual page does not describe $name"
    done
    grep -q 'return status != MLRT_OK;' "$1" || fail "the manual page has no example"
    if command -v groff >/dev/null; then
        warnings=$(groff -man -ww -Tutf8 "$1" 2>&1 >/dev/null)
        [ -z "$warnings" ] || fail "the manual page: $warnings"
    fi
}

# The list has every target that a person calls, and no others.
check_help()
{
    $quiet help >"$folder/help"
    for target in $(sed -n 's/^\.PHONY://p' "$source/../../Makefile"); do
        case $target in library | examples | all | install-strip) continue ;; esac
        grep -q "make .*\b$target\b\|^ .*\b$target\b" "$folder/help" || fail "make help has no $target"
    done
    for target in $(sed -n 's/^make \([a-z][a-z-]*\).*/\1/p' "$folder/help"); do
        sed -n 's/^\.PHONY://p' "$source/../../Makefile" | grep -qw -- "$target" || fail "make help has $target, which is no target"
    done
}

leaves_nothing()
{
    left=$(find "$1" ! -type d 2>/dev/null || true)
    [ -z "$left" ] || fail "make uninstall leaves $left"
}

rm -rf "$folder"
mkdir -p "$folder"
quiet="$MAKE --no-print-directory -s"

# As distributions do: under /usr, staged elsewhere, libraries in a folder of the machine's kind.
stage=$folder/stage
set -- DESTDIR="$stage" PREFIX=/usr LIBDIR=/usr/lib/some-machine
$quiet install "$@"
for script in "$stage"/usr/lib/some-machine/pkgconfig/mlrt.pc "$stage"/usr/lib/some-machine/cmake/mlrt/*; do
    if grep -n "$folder" "$script"; then fail "$script names the folder that it was staged in"; fi
    if grep -n '@[A-Z_]*@' "$script"; then fail "$script has a place that was not filled in"; fi
done
check_manual "$stage/usr/share/man/man3/mlrt.3"
for library in libmlrt.a libmlrt.so; do
    if has_debug "$stage/usr/lib/some-machine/$library"; then fail "$library is not stripped"; fi
done
mv "$stage" "$folder/moved"
consume staged "$folder/moved/usr/lib/some-machine" "$folder/moved/usr" "$folder/moved/usr/lib/some-machine/cmake/mlrt"
mv "$folder/moved" "$stage"
$quiet uninstall "$@"
leaves_nothing "$stage"

# As people do, then moved as a whole; with the debugging information, if the build has any.
set -- PREFIX="$folder/prefix"
$quiet install KEEP_DEBUG=1 "$@"
for library in libmlrt.a libmlrt.so; do
    cmp "$folder/prefix/lib/$library" "$build/$library" || fail "KEEP_DEBUG=1 does not keep $library as it is"
done
mv "$folder/prefix" "$folder/moved"
consume prefix "$folder/moved/lib" "$folder/moved" ""
mv "$folder/moved" "$folder/prefix"
$quiet uninstall "$@"
leaves_nothing "$folder/prefix"

# Libraries and header in places that have nothing in common.
set -- PREFIX="$folder/apart" LIBDIR="$folder/libraries"
$quiet install "$@"
consume apart "$folder/libraries" "$folder/apart" "$folder/libraries/cmake/mlrt"
$quiet uninstall "$@"
leaves_nothing "$folder/apart"
leaves_nothing "$folder/libraries"

check_help

echo "test-install: built and run:$done_list"
