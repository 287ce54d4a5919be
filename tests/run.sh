#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs the given test programs, JOBS of them at a time (default: one per processor), shows how long each took and the
# output of those that fail, and ends with one line: N passed, N failed.

# run.sh --one FOLDER PROGRAM runs one of them and writes the numbers of passed and failed tests to a file in FOLDER.
if [ "$1" = --one ]; then
    folder=$2 program=$3
    start=$(date +%s)
    output=$("$program" 2>&1)
    status=$?
    seconds=$(($(date +%s) - start))
    ok=$(printf '%s\n' "$output" | grep -c '^\[       OK \]')
    bad=$(printf '%s\n' "$output" | grep -c '^\[  FAILED  \] [A-Za-z_]*$')
    run=$(printf '%s\n' "$output" | sed -n 's/^\[==========\].* Running \([0-9]*\) test.*/\1/p' | awk '{n += $1} END {print n + 0}')
    # If a program ends early (a crash, a sanitizer's report), every test that it did not reach has failed.
    missing=$((run - ok - bad))
    if [ "$status" -ne 0 ] && [ "$bad" -eq 0 ] && [ "$missing" -eq 0 ]; then missing=1; fi
    line=$(printf '%-28s %4d passed %4d failed %4d s' "$(basename "$program")" "$ok" "$((bad + missing))" "$seconds")
    if [ "$status" -ne 0 ] || [ "$missing" -ne 0 ]; then line=$(printf '%s\n%s' "$line" "$output"); fi
    printf '%s\n' "$line"
    echo "$ok $((bad + missing))" > "$folder/$(basename "$program")"
    exit 0
fi

folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
printf '%s\n' "$@" | xargs -n 1 -P "${JOBS:-$(getconf _NPROCESSORS_ONLN)}" sh "$0" --one "$folder"
# A program that wrote no file has failed.
for program in "$@"; do
    cat "$folder/$(basename "$program")" 2>/dev/null || echo 0 1
done | awk '{passed += $1; failed += $2} END {print passed + 0 " passed, " failed + 0 " failed"; exit failed > 0 || !passed}'
