#!/bin/sh
# SPDX-License-Identifier: MIT
#
# What a binary of the library promises, against the files in tests/abi, and what it must not have: tests/abi/check.sh
# FOLDER LIBRARY, or with `update` before them to write the files anew. FOLDER holds the interface.inc that the Makefile made.
#
#   symbols.txt         the exported names
#   imports.txt         the names it takes from other libraries, as this machine's compiler leaves them
#   layout-lp64.txt     sizes, alignments and places of all fields; layout-ilp32.txt on i386, if a compiler for it is there
#   constants.txt       the constants
#   mlrt.abi            types of functions and structs, by abidw, if it is there
set -u
update=
if [ "$1" = update ]; then update=1; shift; fi
folder=$1
library=$2
files=tests/abi
: "${CC:=cc}" "${MAXIMUM_SIZE:=600000}"
export LC_ALL=C
failures=0

fail()
{
    echo "check-abi: $*"
    failures=$((failures + 1))
}

# compare NAME FILE: a file made now with the one recorded.
compare()
{
    if [ "$update" ]; then cp "$2" "$files/$1"; return; fi
    diff -u "$files/$1" "$2" || fail "$1 is not what is recorded. If that is meant: make update-abi"
}

nm -D --defined-only "$library" | awk '$2 != "A" {sub(/@.*/, "", $3); print $3}' | sort > "$folder/symbols.txt"
compare symbols.txt "$folder/symbols.txt"

# Of imports, fewer are as good: compilers call some functions, or do without. Five they may call whenever they like.
nm -D --undefined-only "$library" | awk '$1 != "w" {sub(/@.*/, "", $2); print $2}' |
    { cat; printf '%s\n' __tls_get_addr memcmp memcpy memmove memset; } | sort -u > "$folder/imports.txt"
if [ "$update" ]; then cp "$folder/imports.txt" "$files/imports.txt"; fi
news=$(comm -13 "$files/imports.txt" "$folder/imports.txt" | tr '\n' ' ')
[ -z "$news" ] || fail "imports what imports.txt does not have: $news"
if grep -nE '^_*(printf|vprintf|fprintf|vfprintf|puts|putchar|fputs|fputc|fwrite|perror|std(out|err|in)|fopen|exit|_exit|_Exit|quick_exit|abort|assert.*|signal|raise|kill|getenv|secure_getenv|dlopen|system|fork|atexit|setlocale|rand|srand|errno|stack_chk_fail)(_chk)?$' \
    "$folder/imports.txt"; then
    fail "takes names that print, exit, or hold state"
fi

# layout FILE COMPILER...: fails where the compiler, or what it makes, does not work here.
layout()
{
    layout_file=$1
    shift
    "$@" -std=c99 -Iinclude -I"$folder" tests/abi/print.c -o "$folder/print" 2>/dev/null &&
        "$folder/print" > "$folder/$layout_file" 2>/dev/null || return 1
    compare "$layout_file" "$folder/$layout_file"
    if grep -n unnamed "$folder/$layout_file"; then fail "$layout_file: bytes that no field names"; fi
    return 0
}
if layout layout-lp64.txt "$CC"; then
    "$folder/print" constants > "$folder/constants.txt"
    compare constants.txt "$folder/constants.txt"
else
    fail "$CC cannot compile tests/abi/print.c"
fi
layout layout-ilp32.txt "$CC" -m32 || layout layout-ilp32.txt i686-linux-gnu-gcc -static ||
    echo "check-abi: no compiler for i386 (Debian: gcc-i686-linux-gnu): layout-ilp32.txt not looked at"

# Only the libraries that the README names.
readelf -dW "$library" > "$folder/dynamic.txt"
needed=$(sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' "$folder/dynamic.txt")
for name in $needed; do
    case $name in
    libc.so.* | libm.so.* | libpthread.so.* | ld-linux*) ;;
    *) fail "needs $name" ;;
    esac
done
if grep -E 'TEXTREL|RPATH|RUNPATH' "$folder/dynamic.txt"; then fail "has text relocations or a search path"; fi
own=$(readelf -rW "$library" | grep -oFwf "$folder/symbols.txt" | sort -u | tr '\n' ' ')
[ -z "$own" ] || fail "a program can replace what it calls of its own: $own"
readelf -lW "$library" > "$folder/segments.txt"
grep -q 'GNU_STACK.* RW ' "$folder/segments.txt" || fail "has an executable stack"
if grep -E 'LOAD.* RWE ' "$folder/segments.txt"; then fail "has a segment to write and to execute"; fi
grep -q 'GNU_EH_FRAME' "$folder/segments.txt" || fail "has no tables for unwinding"

# No state: what can be written holds nothing but what the compiler puts there, what the processor can do, and the last
# message of each thread.
state=$(nm "$library" | awk '$2 ~ /^[dDbBsSgGC]$/ {print $3}' |
    grep -vE '^(_DYNAMIC|_GLOBAL_OFFSET_TABLE_|__TMC_END__|mlrt_known_isa|last_message|__dso_handle|completed\.[0-9]+|__.*_array_entry|_edata|_end|__bss_start)$')
for name in $state; do
    # Tables of addresses are constant once the library is loaded: they lie in .data.rel.ro.
    section=$(objdump -t "$library" | awk -v name="$name" '$NF == name {for (i = 1; i <= NF; i++) if ($i ~ /^\./) {print $i; exit}}')
    [ "$section" = .data.rel.ro ] || fail "has state: $name in $section"
done

strip -o "$folder/stripped.so" "$library"
size=$(wc -c < "$folder/stripped.so")
echo "check-abi: $(wc -l < "$folder/symbols.txt") names exported, $(wc -l < "$folder/imports.txt") imported, needs $(echo $needed)," \
    "$size bytes stripped"
[ "$size" -lt "$MAXIMUM_SIZE" ] || fail "$size bytes stripped: not under $MAXIMUM_SIZE"

# What types look like from outside: the header's, with nothing of what is inside.
if command -v abidw >/dev/null && [ "$(uname -m)" = x86_64 ]; then
    abidw --headers-dir include --drop-private-types --exported-interfaces-only --no-corpus-path --no-comp-dir-path \
        --no-show-locs --no-parameter-names --type-id-style hash "$library" |
        awk '{ if (/<abi-instr/) sub(/path=.[^ ]*/, "path=\047" ++files "\047"); print }' > "$folder/mlrt.abi"
    grep -q "class-decl name='mlrt_mesh'" "$folder/mlrt.abi" || fail "abidw found no types: compile with -g"
    # Which functions share a source file is in there too, and is no difference.
    if [ "$update" ] && ! abidiff --no-show-locs "$files/mlrt.abi" "$folder/mlrt.abi" >/dev/null 2>&1; then
        cp "$folder/mlrt.abi" "$files/mlrt.abi"
    fi
    abidiff --no-show-locs "$files/mlrt.abi" "$folder/mlrt.abi"
    status=$?
    if [ $((status & 3)) -ne 0 ]; then fail "abidiff failed"
    elif [ $((status & 8)) -ne 0 ]; then fail "incompatible with what is recorded: programs break. Once released, SOVERSION must grow"
    elif [ $((status & 4)) -ne 0 ]; then fail "types or functions are not what is recorded. If that is meant: make update-abi"
    fi
else
    echo "check-abi: no abidw (Debian: abigail-tools), or not x86-64: types of functions not looked at"
fi

[ "$failures" -eq 0 ]
