#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs what was built for another machine, under an emulator if this one cannot:
#
#     cross.sh TARGET BUILD AMALGAMATION [FLAG...]
#
# print_golden of the normal build for TARGET, which is in BUILD; then the amalgamation by TARGET's gcc and by clang, if
# it is there, with the flags given; for Windows also as a DLL. What cannot be run here is linked, and said.
set -eu
target=$1 build=$2 amalgamation=$3
shift 3

find_program() {
    for program in "$@"; do
        if command -v "$program"; then return; fi
    done
    echo -
}

program=$build/tests/print_golden
case $target in
aarch64-*) run=$(find_program qemu-aarch64 qemu-aarch64-static) ;;
s390x-*) run=$(find_program qemu-s390x qemu-s390x-static) ;;
i?86-*)
    run=$(find_program qemu-i386 qemu-i386-static)
    # Most x86-64 systems run it by themselves, and have more instruction sets than the emulator.
    if "$program" >/dev/null 2>&1; then run=; fi
    ;;
*mingw*)
    run=$(find_program wine64 wine /usr/lib/wine/wine64)
    program=$program.exe
    WINEPREFIX=$(cd "$build" && pwd)/wine WINEDEBUG=-all
    export WINEPREFIX WINEDEBUG
    if [ "$run" != - ]; then "$run" cmd /c exit >/dev/null 2>&1 || true; fi # has much to say the first time
    ;;
*) run=- ;;
esac

sh tests/golden.sh "library, $target" "$run" "$program"

case $target in
*mingw*)
    # Marked as a DLL's, functions can be linked statically as well.
    sh tests/amalgamation.sh "$amalgamation" "$target" "$run" "$target-gcc" "$@" -DMLRT_BUILD_DLL
    "$target-gcc" -shared -static "$amalgamation/$target-gcc.o" -pthread -o "$amalgamation/mlrt.dll"
    sh tests/golden.sh "amalgamation, $target, DLL" "$run" "$amalgamation" "$amalgamation/mlrt.dll" \
        "$amalgamation/$target-dll.exe" "$target-gcc" -static -DMLRT_USE_DLL
    ;;
*) sh tests/amalgamation.sh "$amalgamation" "$target" "$run" "$target-gcc" "$@" ;;
esac

if command -v clang >/dev/null; then
    sh tests/amalgamation.sh "$amalgamation" "$target" "$run" \
        clang --target="$target" -isystem "/usr/$target/include" "$@"
else
    echo "amalgamation, $target: no clang: not tested with it"
fi
