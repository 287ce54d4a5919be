#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Compiles mlrt.h alone, in every version of C and C++ that the compilers here know, with all warnings as errors: twice
# in one file, with macros that other headers are known to define, and with its functions renamed.
set -u
failures=0
count=0
warnings='-Wall -Wextra -pedantic -Werror -Wundef -Wshadow -Wconversion -Wpadded'
names='near far small hyper interface min max IN OUT OPTIONAL ERROR DELETE None Bool Status Success Always True False
    major minor linux unix check verify I'

# compile LANGUAGE COMPILER FLAGS...: compiles a file that includes the header twice.
compile()
{
    language=$1
    shift
    count=$((count + 1))
    printf '#include "mlrt.h"\n#include "mlrt.h"\nextern int nothing;\n' |
        "$@" -fsyntax-only -Iinclude -x "$language" - || { echo "check-header: $*"; failures=$((failures + 1)); }
}

# knows LANGUAGE COMPILER -std=VERSION: does the compiler know this version of the language?
knows()
{
    echo 'extern int nothing;' | "$2" "$3" -fsyntax-only -x "$1" - 2>/dev/null
}

for compiler in gcc clang; do
    command -v $compiler >/dev/null || { echo "check-header: no $compiler"; continue; }
    for standard in c99 c11 c17 c2x gnu11; do
        knows c $compiler -std=$standard || continue
        compile c $compiler -std=$standard $warnings -Wstrict-prototypes -Wc++-compat
        compile c $compiler -std=$standard $warnings -DMLRT_PREFIX=game_
    done
    # Names that windows.h, X11 and others are known to define: a header that used one would not compile.
    for name in $names; do compile c $compiler -std=c99 "-D$name=@"; done
done
for compiler in g++ clang++; do
    command -v $compiler >/dev/null || { echo "check-header: no $compiler"; continue; }
    for standard in c++11 c++14 c++17 c++20 c++23 gnu++17; do
        knows c++ $compiler -std=$standard || continue
        compile c++ $compiler -std=$standard $warnings -Wold-style-cast -Wzero-as-null-pointer-constant
        compile c++ $compiler -std=$standard $warnings -DMLRT_PREFIX=game_
    done
done

# Every function must have the new prefix.
declared=$(${CC:-cc} -E -P -DMLRT_API=MLRT_API -DMLRT_PREFIX=game_ include/mlrt.h | tr '\n;' ' \n' |
    sed -n 's/.*MLRT_API[^(]*[ *]\([A-Za-z0-9_]*\)(.*/\1/p')
kept=$(printf '%s\n' "$declared" | grep -v '^game_' | tr '\n' ' ')
[ -z "$kept" ] || { echo "check-header: not renamed by MLRT_PREFIX: $kept"; failures=$((failures + 1)); }

echo "check-header: $count times compiled, $(printf '%s\n' "$declared" | wc -l) functions renamed, $failures failed"
[ "$failures" -eq 0 ]
