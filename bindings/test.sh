#!/bin/sh
# SPDX-License-Identifier: MIT
# Tests the binding of each language whose tools are here: sh bindings/test.sh FOLDER, where libmlrt is installed in
# FOLDER/prefix (make test-bindings does that). Each test prints the hash of the same answers, which must be that of the
# one in C. A line per language, and the log of what fails; then N passed, N failed, N skipped.
#
# LANGUAGES: those to test; c must be one of them. CC, CXX: compilers. VERSION: that of the packages. REQUIRE='rust go': languages that must not be skipped.
source=$(cd "$(dirname "$0")" && pwd)
work=$(cd "$1" && pwd) || exit 1
prefix=$work/prefix
build=$(cd "$work/.." && pwd) # with the amalgamation
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

# Packs a binding, with the library inside, into $work/packages: package LANGUAGE. Prints the path of the package; where a
# tool is missing, says so in the log and prints nothing.
package() {
    if sh "$source/package.sh" "$1" "$build" "$work/packages" >"$work/package-$1.log" 2>&1; then
        tail -n 2 "$work/package-$1.log" >&2
        tail -n 1 "$work/package-$1.log"
    else
        [ $? -eq 77 ] || { cat "$work/package-$1.log" >&2; return 1; }
        echo "not packed: $(tail -n 1 "$work/package-$1.log")" >&2
    fi
}

# The package is installed as a user would, in an empty folder: the library that it brings, the same compiled from its
# source, and the installed one. All must give the same hash. Then the types, by TypeScript's compiler.
test_node() {
    need node npm
    package=$(package node)
    rm -rf "$work/node" && mkdir "$work/node"
    cd "$work/node"
    echo '{"private": true}' >package.json
    npm install --no-package-lock --no-audit --no-fund --prefer-offline "$package" || skip "npm cannot install koffi"
    cp "$source/node/test.js" "$source/node/types.test.ts" "$source/node/tsconfig.json" .
    node --expose-gc test.js
    CFLAGS=-O0 MLRT_LIBRARY= node node_modules/mlrt/build.js
    node --test-name-pattern='common scene' test.js
    node node_modules/mlrt/build.js
    node --test-name-pattern='common scene' test.js
    rm -r node_modules/mlrt/build node_modules/mlrt/prebuilt
    node -e 'require("mlrt")' 2>&1 | grep -F 'npx mlrt-build'
    if npm install --no-package-lock --no-audit --no-fund --prefer-offline typescript@5; then node_modules/.bin/tsc -p .
    else echo "npm cannot install TypeScript: types are not checked"; fi
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
    "$kit/bin/javac" -Xlint:all,-restricted -Werror -d "$work/java" $(find "$source/java/src" -name '*.java')
    run="$kit/bin/java --enable-native-access=ALL-UNNAMED"
    $run -Dmlrt.path="$MLRT_LIBRARY" -cp "$work/java" mlrt.Test
    $run -Djava.library.path="$prefix/lib" -cp "$work/java" mlrt.Test | grep -v layout
    (unset LD_LIBRARY_PATH && ! $run -cp "$work/java" mlrt.Test 2>&1) | grep -F 'name its file by -Dmlrt.path=FILE'
    "$kit/bin/javadoc" -quiet -Xdoclint:all -Werror -d "$work/javadoc" "$source"/java/src/main/java/mlrt/*.java
    package=$(package java)
    [ -n "$package" ] || return 0
    cp -R "$work/java" "$work/java-test" && find "$work/java-test" -name '*.class' ! -name 'Test*' -delete
    (unset LD_LIBRARY_PATH && $run -cp "$package:$work/java-test" mlrt.Test) | grep -v layout # by the library in the jar
}

test_lua() {
    need luajit
    cd "$source/lua"
    luajit test.lua
    (unset LD_LIBRARY_PATH MLRT_LIBRARY && ! luajit test.lua 2>&1) | grep -F 'luarocks install mlrt'
    package=$(package lua)
    [ -n "$package" ] || return 0
    rm -rf "$work/rocks" && mkdir "$work/rocks"
    cd "$work/rocks"
    luarocks --lua-version 5.1 --tree "$work/rocks" install "$package" CFLAGS='-O0 -fPIC'
    cp "$source/lua/test.lua" .
    (
        unset LD_LIBRARY_PATH MLRT_LIBRARY
        eval "$(luarocks --lua-version 5.1 --tree "$work/rocks" path)"
        luajit test.lua hash
    ) | grep -v layout
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

languages=${LANGUAGES:-c cpp python rust go node java lua}
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
