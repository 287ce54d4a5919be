#!/bin/sh
# SPDX-License-Identifier: MIT
# Builds print_golden against a library and runs it:
#
#     golden.sh NAME RUN INCLUDE LIBRARY PROGRAM COMPILER [FLAG...]
#
# NAME heads the line of the result. RUN is the emulator that runs programs of that machine: empty if none is needed,
# "-" if none is installed; then PROGRAM is only linked. INCLUDE is the folder of mlrt.h. The short form
#
#     golden.sh NAME RUN PROGRAM
#
# runs a PROGRAM that is already built.
set -eu
name=$1 run=$2
shift 2
if [ $# -gt 1 ]; then
    include=$1 library=$2 program=$3
    shift 3
    scenes=
    for file in scene import ply_check room office building doubled scan furniture shapes steady_math; do
        scenes="$scenes examples/common/$file.c"
    done
    # shellcheck disable=SC2086 # a list
    "$@" -O2 -ffp-contract=off -I"$include" -Iexamples -Itests tests/print_golden.c tests/golden.c $scenes "$library" \
        -lm -pthread -o "$program"
else
    program=$1
fi

if [ "$run" = - ]; then
    echo "$name: linked, not run: nothing here that runs it"
    exit
fi
# shellcheck disable=SC2086 # $run may be no word
$run "$program" >"$program.out" || {
    cat "$program.out"
    echo "$name: not golden"
    exit 1
}
echo "$name: golden, $(grep -c 0x "$program.out") ways"
