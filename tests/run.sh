#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs the test programs given, shows what fails, and closes with one line: N passed, N failed.
passed=0
failed=0
for program in "$@"; do
    output=$("$program" 2>&1)
    status=$?
    ok=$(printf '%s\n' "$output" | grep -c '^\[       OK \]')
    bad=$(printf '%s\n' "$output" | grep -c '^\[  FAILED  \] [A-Za-z_]*$')
    run=$(printf '%s\n' "$output" | sed -n 's/^\[==========\].* Running \([0-9]*\) test.*/\1/p' | awk '{n += $1} END {print n + 0}')
    # A program that ends early (a crash, a sanitizer's report) fails with every test it did not get to.
    missing=$((run - ok - bad))
    if [ "$status" -ne 0 ] && [ "$bad" -eq 0 ] && [ "$missing" -eq 0 ]; then missing=1; fi
    passed=$((passed + ok))
    failed=$((failed + bad + missing))
    printf '%-28s %4d passed %4d failed\n' "$(basename "$program")" "$ok" "$((bad + missing))"
    if [ "$status" -ne 0 ] || [ "$missing" -ne 0 ]; then printf '%s\n' "$output"; fi
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
