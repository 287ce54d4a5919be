#!/bin/sh
# SPDX-License-Identifier: MIT
# Tests builds for another machine, under an emulator if this machine cannot run them:
#
#     cross.sh TARGET BUILD AMALGAMATION [FLAG...]
#
# Runs print_golden of the normal build for TARGET, which is in BUILD. Then tests the amalgamation, compiled with the
# given flags by TARGET's gcc and by clang, if it is installed; for Windows also as a DLL. If there is no emulator,
# programs are linked but not run, and a line says so.
set -eu
target=$1 build=$2 amalgamation=$3
shift 3

# Prints the first of these programs that is installed, or "-".
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
    # Most x86-64 systems run such programs directly, with more instruction sets than the emulator has.
    if "$program" >/dev/null 2>&1; then run=; fi
    ;;
*mingw*)
    run=$(find_program wine64 wine /usr/lib/wine/wine64)
    program=$program.exe
    WINEPREFIX=$(cd "$build" && pwd)/wine WINEDEBUG=-all
    export WINEPREFIX WINEDEBUG
    if [ "$run" != - ]; then "$run" cmd /c exit >/dev/null 2>&1 || true; fi # the first run prints much
    ;;
*) run=- ;;
esac

sh tests/golden.sh "library, $target" "$run" "$program"

case $target in
*mingw*)
    # Functions that are marked for a DLL can be linked statically as well.
    sh tests/amalgamation.sh "$amalgamation" "$target" "$run" "$target-gcc" "$@" -DMLRT_BUILD_DLL
    "$target-gcc" -shared -static "$amalgamation/$target-gcc.o" -pthread -o "$amalgamation/mlrt.dll"
    sh tests/golden.sh "amalgamation, $target, DLL" "$run" "$amalgamation" "$amalgamation/mlrt.dll" \
        "$amalgamation/$target-dll.exe" "$target-gcc" -static -DMLRT_USE_DLL
    ;;
*) sh tests/amalgamation.sh "$amalgamation" "$target" "$run" "$target-gcc" "$@" ;;
esac

# QEMU 7.2 multiplies two floats into a double wrongly on s390x (MDEBR), which clang makes use of and gcc does not.
multiplies_rightly() {
    cat >"$amalgamation/$target-product.c" <<'EOF'
__attribute__((noinline)) static double product(float a, float b) { return (double)a * b; }
int main(int count, char **words) { (void)words; return product(1.5f * (float)count, 3.0f * (float)count) != 4.5; }
EOF
    clang --target="$target" -isystem "/usr/$target/include" -O2 -c "$amalgamation/$target-product.c" \
        -o "$amalgamation/$target-product.o"
    "$target-gcc" -static "$amalgamation/$target-product.o" -o "$amalgamation/$target-product"
    "$run" "$amalgamation/$target-product"
}

if ! command -v clang >/dev/null; then
    echo "amalgamation, $target: no clang: not tested with it"
elif [ "${target%%-*}" = s390x ] && [ "$run" != - ] && ! multiplies_rightly; then
    echo "amalgamation, $target: $run multiplies floats wrongly in programs of clang: not tested with it"
else
    sh tests/amalgamation.sh "$amalgamation" "$target" "$run" \
        clang --target="$target" -isystem "/usr/$target/include" "$@"
fi
