#!/bin/sh
# SPDX-License-Identifier: MIT
# measure.sh FILE COMMAND: writes what COMMAND prints to FILE, and to measured.csv beside it which machine and commit it is of.
#
# FILE changes only if COMMAND succeeds. Nothing is done if FILE is there and is of this machine and commit already, so that
# what was interrupted goes on; AGAIN=1 measures anew. The commit is the last that changed the library or its programs; a "+"
# means that files had changes since.
file=$1 command=$2 list=$(dirname "$1")/measured.csv
code='src include examples bindings/python Makefile'
commit=$(git log -1 --format=%h -- $code)$(git diff --quiet HEAD -- $code || echo +)
of_processor() { sed -n "s/^$1[[:space:]]*: //p" /proc/cpuinfo | head -n 1; }
has() { grep -qw "$1" /proc/cpuinfo; }
vectors=$(has avx512f && echo AVX-512 || { has avx2 && echo AVX2 || echo SSE2; })
processor="$(of_processor 'model name') family $(of_processor 'cpu family') model $(of_processor model)"
head='file,commit,processor,vectors,compiler,measured,seconds'
row="$(basename "$file"),$commit,$processor,$vectors,gcc $(gcc -dumpfullversion)"

[ -f "$list" ] || echo "$head" > "$list"
if [ -z "$AGAIN" ] && [ -f "$file" ] && grep -qF "$row," "$list"; then
    echo "$(basename "$file"): measured already, AGAIN=1 measures anew"
    exit 0
fi
echo "$(basename "$file"): $command"
begin=$(date +%s)
if ! sh -c "$command" > "$file.new"; then
    rm -f "$file.new"
    echo "$(basename "$file"): failed" >&2
    exit 1
fi
mv "$file.new" "$file"
{ grep -v "^$(basename "$file")," "$list"; echo "$row,$(date +%Y-%m-%d),$(($(date +%s) - begin))"; } > "$list.new"
{ echo "$head"; grep -v '^file,' "$list.new" | LC_ALL=C sort; } > "$list"
rm "$list.new"
