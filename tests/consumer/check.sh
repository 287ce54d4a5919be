#!/bin/sh
# SPDX-License-Identifier: MIT
#
# make test-install: installs into scratch folders in three ways, builds consumers there with pkg-config and with CMake,
# shared and static, runs them, and looks whether `make uninstall` leaves anything. tests/consumer/check.sh FOLDER
set -eu
mkdir -p "$1"
folder=$(cd "$1" && pwd)
source=$(cd "$(dirname "$0")" && pwd)
: "${CC:=cc}" "${MAKE:=make}"
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
        $CC -std=c99 "$source/main.c" $(pkg-config --cflags --libs mlrt) -o "$out/pkg-shared"
        run_shared "$out/pkg-shared" "$libdir"
        $CC -std=c99 -static "$source/main.c" $(pkg-config --cflags --static --libs mlrt) -o "$out/pkg-static"
        run_static "$out/pkg-static"
        unset PKG_CONFIG_LIBDIR
        done_list="$done_list $1/pkg-config"
    else
        echo "test-install: no pkg-config: not tested"
    fi
    if command -v cmake >/dev/null; then
        cmake -S "$source" -B "$out/cmake" -DCMAKE_C_COMPILER="$CC" -DCMAKE_PREFIX_PATH="$3" -Dmlrt_DIR="$4" -DWANTED=0.1 \
            >"$out/cmake.log" || fail "$1: cmake finds no mlrt 0.1: see $out/cmake.log"
        cmake --build "$out/cmake" >>"$out/cmake.log" || fail "$1: cmake cannot build: see $out/cmake.log"
        grep -q "mlrt_DIR.*=$libdir/cmake/mlrt" "$out/cmake/CMakeCache.txt" || fail "$1: cmake found another mlrt"
        run_shared "$out/cmake/use_mlrt" "$libdir"
        run_static "$out/cmake/use_mlrt_static"
        for version in 0.99 1.0; do
            if cmake -S "$source" -B "$out/cmake-$version" -DCMAKE_C_COMPILER="$CC" -DCMAKE_PREFIX_PATH="$3" -Dmlrt_DIR="$4" \
                -DWANTED=$version >"$out/cmake-$version.log" 2>&1; then fail "$1: cmake takes $VERSION for $version"; fi
        done
        done_list="$done_list $1/cmake"
    else
        echo "test-install: no cmake: not tested"
    fi
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
mv "$stage" "$folder/moved"
consume staged "$folder/moved/usr/lib/some-machine" "$folder/moved/usr" "$folder/moved/usr/lib/some-machine/cmake/mlrt"
mv "$folder/moved" "$stage"
$quiet uninstall "$@"
leaves_nothing "$stage"

# As people do, then moved as a whole.
set -- PREFIX="$folder/prefix"
$quiet install-strip "$@"
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

echo "test-install: built and run:$done_list"
