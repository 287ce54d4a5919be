#!/bin/sh
# SPDX-License-Identifier: MIT
# Compiles the amalgamation in one step and checks the object:
#
#     amalgamation.sh FOLDER TARGET RUN COMPILER [FLAG...]
#
# FOLDER holds mlrt.c. TARGET is empty for this machine, or the prefix of gcc and tools for the machine that COMPILER
# compiles for; RUN is as in golden.sh.
set -eu
folder=$1 target=$2 run=$3
shift 3
name=${target:+$target-}${1#"$target-"}
gcc=${target:+$target-}gcc
static=${target:+-static}
if [ -z "$target" ]; then gcc=$1; fi
object=$folder/$name.o

fail() {
    echo "amalgamation, $name: $*"
    exit 1
}

"$@" -O2 -Wall -Wextra -Werror -c "$folder/mlrt.c" -o "$object"

# It must export the functions of the interface and no other names, but for the compiler's own.
cat src/api/*.c | sed -n 's/^MLRT_API .*[ *]\(mlrt_[a-z0-9_]*\)(.*/\1/p' | sort >"$folder/$name.public"
"$("$gcc" -print-prog-name=nm)" -g --defined-only "$object" |
    awk '$2 ~ /[TDBC]/ && $3 !~ /^__x86\./ {print $3}' | sort >"$folder/$name.exported"
diff "$folder/$name.public" "$folder/$name.exported" || fail "exports other names than the library"

# Error bounds count the roundings of products and of sums, so on any processor only the kernels themselves may fuse a
# multiplication with an addition. Golden numbers hardly show a violation. So there must be as many fused instructions
# as with -ffp-contract=off.
fused_in() {
    "$("$gcc" -print-prog-name=objdump)" -d "$1" | grep -cE 'fn?m(add|sub|la|ls)|[[:space:]]m[as][ed]br?[[:space:]]|[wv]fm[as]' || true
}
fused=$(fused_in "$object")
case $target in i?86-*) fused=0 ;; esac # its kernels are those of this machine
if [ "$fused" != 0 ]; then
    "$@" -O2 -ffp-contract=off -c "$folder/mlrt.c" -o "$folder/$name-off.o"
    meant=$(fused_in "$folder/$name-off.o")
    [ "$fused" = "$meant" ] || fail "$fused fused multiply-adds, of which $meant are meant"
fi

# shellcheck disable=SC2086 # $static may be no word
sh tests/golden.sh "amalgamation, $name, $(wc -c <"$object") bytes" "$run" "$folder" "$object" "$folder/$name.exe" \
    "$gcc" $static
