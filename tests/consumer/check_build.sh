#!/bin/sh
# SPDX-License-Identifier: MIT
#
# make test-packaging: uses the sources from other projects, each in a fresh folder: CMake with FetchContent and with
# add_subdirectory, Meson with a wrap, and the vcpkg port. Each builds programs in C and C++ with the shared and the
# static library, which must give the golden answers; the library must be that of the Makefile, byte for byte, though
# the settings of the projects are hostile. tests/consumer/check_build.sh FOLDER LIBRARY ARCHIVE
#
# The program vcpkg itself is not run: no package of Debian, PyPI, npm or crates.io has it, and it fetches itself and its
# ports' tools from GitHub. vcpkg/run_port.cmake stands in for the functions that a port calls.
#
# CC, CXX: the compilers that LIBRARY was built with. WAYS: those to test; default fetch subdirectory meson vcpkg. Tools
# that are missing are named, and what needs them is left out.
set -eu
mkdir -p "$1"
folder=$(cd "$1" && pwd)
library=$2 archive=$3
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
: "${CC:=cc}" "${CXX:=c++}" "${WAYS:=fetch subdirectory meson vcpkg}"
export CC CXX
version=$(sed -n 's/^#define MLRT_VERSION_STRING "\(.*\)".*/\1/p' "$root/include/mlrt.h")
done_list=

fail()
{
    echo "test-packaging: $*"
    exit 1
}

wants()
{
    case " $WAYS " in *" $1 "*) ;; *) return 1 ;; esac
}

has()
{
    command -v "$1" >/dev/null || { echo "test-packaging: no $1: $2 is not tested"; return 1; }
}

# quietly LOG COMMAND...
quietly()
{
    log=$1
    shift
    "$@" >"$log" 2>&1 || { tail -n 30 "$log"; fail "fails: $*"; }
}

# project NAME: a fresh folder with the programs and the project's own files.
project()
{
    place=$folder/$1
    rm -rf "$place"
    mkdir -p "$place"
    cp "$here/main.c" "$here/main.cpp" "$root/bindings/c/scene.h" "$here/$1"/* "$place/"
}

# The same code, constants and exported names. The linker's own numbers and the compiler's name are left out.
same_library()
{
    for file in "$library" "$1"; do
        objcopy --strip-all -R .note.gnu.build-id -R .comment "$file" "$folder/stripped-$(basename "$file")" || fail "$1: objcopy"
    done
    cmp "$folder/stripped-$(basename "$library")" "$folder/stripped-$(basename "$1")" || fail "$1 is not the library that the Makefile builds"
}

# The archive holds one object, which exports the same names.
same_archive()
{
    [ "$(ar t "$1" | wc -l)" = 1 ] || fail "$1 has internal names"
    nm -g --defined-only "$archive" | awk 'NF == 3 {print $3}' >"$folder/names-meant"
    nm -g --defined-only "$1" | awk 'NF == 3 {print $3}' >"$folder/names"
    cmp "$folder/names-meant" "$folder/names" || fail "$1 exports other names than $archive"
}

# run SHARED PROGRAM...: programs that need the shared library (yes), or must not (no).
run()
{
    wanted=$1
    shift
    for program in "$@"; do
        needs=no
        if readelf -d "$program" | grep -q 'NEEDED.*libmlrt\.so\.0'; then needs=yes; fi
        [ "$needs" = "$wanted" ] || fail "$program: needs the shared library: $needs"
        "$program" >"$program.log" || fail "$program: not the golden answers: $(cat "$program.log")"
    done
}

compiled_once()
{
    count=$(find "$1" -name '*avx512.c.o' | wc -l)
    [ "$count" -le 1 ] || fail "$1: the library was compiled $count times"
}

# The sources as a repository of their own: what is in the working tree, and no more than others would get.
sources=$folder/sources
rm -rf "$sources"
mkdir -p "$sources/bindings"
cp -R "$root/include" "$root/src" "$root/Makefile" "$root/LICENSE" "$root/README.md" "$sources/"
cp -R "$root/bindings/c" "$root/bindings/cpp" "$sources/bindings/"
if has git "FetchContent and Meson's wrap"; then
    git -C "$sources" init -q
    git -C "$sources" add -A
    git -C "$sources" -c user.name=test -c user.email=test@localhost commit -q -m test
fi
generator='Unix Makefiles'
if command -v ninja >/dev/null; then generator=Ninja; fi

if wants fetch && has cmake "FetchContent" && has git "FetchContent"; then
    project fetch
    quietly "$place/log" cmake -S "$place" -B "$place/build" -G "$generator" -DREPOSITORY="file://$sources" -DCMAKE_BUILD_TYPE=Debug
    quietly "$place/log-build" cmake --build "$place/build" --parallel 2
    run yes "$place"/build/use_mlrt "$place"/build/use_mlrt_cpp
    run no "$place"/build/use_mlrt_static "$place"/build/use_mlrt_static_cpp
    same_library "$place/build/_deps/mlrt-build/libmlrt.so.$version"
    same_archive "$(find "$place/build" -name libmlrt.a)"
    compiled_once "$place/build"
    done_list="$done_list FetchContent"
fi

if wants subdirectory && has cmake "add_subdirectory"; then
    project subdirectory
    other=$CXX other_c=$CC
    if command -v clang++ >/dev/null; then other=clang++ other_c=clang; fi
    quietly "$place/log" cmake -S "$place" -B "$place/build" -DMLRT="$sources" -DCMAKE_CXX_COMPILER="$other" -DCMAKE_C_COMPILER="$other_c"
    quietly "$place/log-build" cmake --build "$place/build" --parallel 2
    run no "$place"/build/use_mlrt_static_cpp
    same_archive "$(find "$place/build" -name libmlrt.a)"
    [ -z "$(find "$place/build" -name 'libmlrt.so*')" ] || fail "builds the shared library that no program asks for"
    done_list="$done_list add_subdirectory($other)"
fi

if wants meson && has meson "Meson's wrap" && has git "Meson's wrap"; then
    project meson
    mkdir "$place/subprojects"
    cp -R "$root/src/packaging/meson/." "$place/subprojects/"
    sed -i "s|^url = .*|url = file://$sources|" "$place/subprojects/mlrt.wrap"
    quietly "$place/log" meson setup "$place/build" "$place"
    quietly "$place/log-build" meson compile -C "$place/build"
    run yes "$place"/build/use_mlrt "$place"/build/use_mlrt_cpp
    run no "$place"/build/use_mlrt_static "$place"/build/use_mlrt_static_cpp
    same_library "$place/build/subprojects/mlrt/libmlrt.so.$version"
    same_archive "$(find "$place/build" -name libmlrt.a)"
    compiled_once "$place/build"
    done_list="$done_list Meson"
fi

if wants vcpkg && has cmake "the vcpkg port"; then
    rm -rf "$folder/vcpkg"
    mkdir -p "$folder/vcpkg"
    port=$sources/src/packaging/vcpkg
    grep -q "\"version\": \"$version\"" "$port/vcpkg.json" || fail "vcpkg.json has another version than mlrt.h"
    for linkage in static dynamic; do
        place=$folder/vcpkg/$linkage
        mkdir "$place"
        quietly "$place/log" env CMAKE_BUILD_PARALLEL_LEVEL=2 cmake -DPORT_FOLDER="$port" -DBUILD="$folder/vcpkg/build" \
            -DPACKAGE="$place/installed" -DLINKAGE="$linkage" -DGENERATOR="$generator" -P "$here/vcpkg/run_port.cmake"
        mv "$place/installed" "$place/moved" # a package may lie anywhere
        prefix=$place/moved
        for file in include/mlrt.h include/mlrt.hpp share/mlrt/mlrtConfig.cmake share/mlrt/copyright share/mlrt/usage; do
            [ -f "$prefix/$file" ] || fail "the port installs no $file"
        done
        quietly "$place/log-use" cmake -S "$here" -B "$place/use" -DCMAKE_PREFIX_PATH="$prefix" -DWANTED=0.1 -DSCENE="$root/bindings/c"
        quietly "$place/log-use-build" cmake --build "$place/use"
        if [ "$linkage" = static ]; then
            run no "$place/use/use_mlrt_static" "$place/use/use_mlrt_static_cpp"
            [ -z "$(find "$prefix" -name '*.so*')" ] || fail "the static port installs a shared library"
        else
            run yes "$place/use/use_mlrt" "$place/use/use_mlrt_cpp"
            same_library "$prefix/lib/libmlrt.so.$version"
            [ -z "$(find "$prefix" -name '*.a')" ] || fail "the dynamic port installs a static library"
        fi
        done_list="$done_list vcpkg-port/$linkage"
    done
fi

[ -n "$done_list" ] || fail "nothing was tested"
echo "test-packaging: built and run:$done_list"
