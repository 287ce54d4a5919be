#!/bin/sh
# SPDX-License-Identifier: MIT
# Tests the binding of each language whose tools are here: sh bindings/test.sh FOLDER, where libmlrt is installed in
# FOLDER/prefix (make test-bindings does that). Each test prints the hash of the same answers, which must be that of the
# one in C. A line per language, and the log of what fails; then N passed, N failed, N skipped.
#
# CC, CXX: compilers. REQUIRE='rust go': languages that must not be skipped.
source=$(cd "$(dirname "$0")" && pwd)
work=$(cd "$1" && pwd) || exit 1
prefix=$work/prefix
flags="-I$prefix/include -L$prefix/lib"
export LD_LIBRARY_PATH="$prefix/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
export MLRT_LIBRARY="$prefix/lib/libmlrt.so.0"

skip() {
    echo "$*"
    exit 77
}

need() {
    for tool in "$@"; do command -v "$tool" >/dev/null || skip "no $tool"; done
}

# What a tool writes beside its sources goes to a copy of them.
copy() {
    mkdir -p "$work/$1"
    cp -R "$source/$1/." "$work/$1"
    cd "$work/$1"
}

test_c() {
    ${CC:-cc} -std=c99 -Wall -Wextra -pedantic -Werror $flags "$source/c/test.c" -lmlrt -o "$work/test-c"
    "$work/test-c"
}

test_cpp() {
    need "${CXX:-c++}"
    for compiler in "${CXX:-c++}" $(command -v clang++); do
        for standard in c++11 c++20; do
            $compiler -std=$standard -Wall -Wextra -pedantic -Werror $flags "$source/cpp/test.cpp" -lmlrt -o "$work/test-cpp"
            "$work/test-cpp"
        done
    done
}

test_rust() {
    need cargo pkg-config
    copy rust
    export CARGO_TARGET_DIR="$work/rust/target"
    cargo fetch || cargo fetch --offline || skip "cargo cannot fetch bindgen"
    if ! cargo test --offline -- --nocapture >log 2>&1; then
        cat log
        grep -q 'Unable to find libclang' log && skip "no libclang, which bindgen needs"
        exit 1
    fi
    cat log
}

test_go() {
    need go pkg-config
    copy go
    GOTOOLCHAIN=local CGO_ENABLED=1 go test -count=1 -v .
}

test_node() {
    need node npm
    copy node
    if ! npm ls koffi >/dev/null 2>&1; then
        npm install --no-package-lock --no-audit --no-fund --prefer-offline || skip "npm cannot install koffi"
    fi
    node --expose-gc test.js
}

# The newest Java kit from 22 on, where java.lang.foreign came to stay.
test_java() {
    newest=0
    for home in "$JAVA_HOME" "$(dirname "$(dirname "$(readlink -f "$(command -v javac)")")")" /usr/lib/jvm/*; do
        version=$(sed -n 's/^JAVA_VERSION="\([0-9]*\).*/\1/p' "$home/release" 2>/dev/null || true)
        if [ -x "$home/bin/javac" ] && [ "${version:-0}" -gt "$newest" ]; then newest=$version kit=$home; fi
    done
    [ "$newest" -ge 22 ] || skip "no JDK 22 or later"
    rm -rf "$work/java"
    "$kit/bin/javac" -Xlint:all,-restricted -Werror -d "$work/java" "$source"/java/*.java
    "$kit/bin/java" --enable-native-access=ALL-UNNAMED -Dmlrt.path="$MLRT_LIBRARY" -cp "$work/java" mlrt.Test
}

test_lua() {
    need luajit
    cd "$source/lua"
    luajit test.lua
}

# Tests whose layouts are written by hand print a line `layout STRUCT FIELD OFFSET` for each field, or `layout STRUCT
# sizeof SIZE`. The compiler compares them with the header.
check_layouts() {
    {
        echo '#include <mlrt.h>'
        sed -n -e 's/.*layout \([a-z_]*\) sizeof \([0-9]*\)$/_Static_assert(sizeof(\1) == \2, "size of \1");/p; t' \
            -e 's/.*layout \([a-z_]*\) \([a-z_]*\) \([0-9]*\)$/_Static_assert(offsetof(\1, \2) == \3, "place of \1.\2");/p' "$work/$language.log"
    } >"$work/$language.c"
    case $language in node | java | lua) grep -q offsetof "$work/$language.c" ;; esac
    ${CC:-cc} -std=c11 -fsyntax-only $flags "$work/$language.c"
}

test_python() {
    need python3
    python3 -c 'import numpy' || skip "no numpy"
    cd "$source/python/tests" # the library is that in build/
    PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=.. python3 -m unittest test_scene
}

languages='c cpp python rust go node java lua'
for language in $languages; do
    (
        set +e
        (set -e; "test_$language"; check_layouts >&2) >"$work/$language.log" 2>&1
        echo $? >"$work/$language.status"
    ) &
done
wait

passed=0 failed=0 skipped=0 golden=
for language in $languages; do
    log=$work/$language.log
    status=$(cat "$work/$language.status")
    hash=$(grep -oE '\b[0-9a-f]{16}$' "$log" | sort -u) # a test may run several times
    [ "$language" = c ] && golden=$hash
    case " $REQUIRE " in *" $language "*) required=1 ;; *) required= ;; esac
    if [ "$status" -eq 77 ] && [ -z "$required" ]; then
        echo "$language: skipped ($(tail -n 1 "$log"))"
        skipped=$((skipped + 1))
    elif [ "$status" -eq 0 ] && [ -n "$hash" ] && [ "$hash" = "$golden" ]; then
        echo "$language: ok $hash"
        passed=$((passed + 1))
    else
        echo "$language: FAILED (status $status, hash ${hash:-none}, expected ${golden:-one})"
        cat "$log"
        failed=$((failed + 1))
    fi
done
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
