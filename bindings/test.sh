#!/bin/sh
# SPDX-License-Identifier: MIT
# Tests the binding of each language whose tools are here: sh bindings/test.sh FOLDER, where libmlrt is installed in
# FOLDER/prefix (make test-bindings does that). Each test prints the hash of the same answers, which must be that of the
# one in C. A line per language, and the log of what fails; then N passed, N failed, N skipped.
#
# The tests run with a library that writes down in FOLDER/LANGUAGE.seen what they call (coverage.py); those of packages run
# with the library that the package carries, in a folder of their own.
#
# LANGUAGES: those to test; c must be one of them. CC, CXX: compilers. VERSION: that of the packages. REQUIRE='rust go':
# languages that must not be skipped.
source=$(cd "$(dirname "$0")" && pwd)
work=$(cd "$1" && pwd) || exit 1
prefix=$work/prefix
build=$(cd "$work/.." && pwd) # with the amalgamation
recorder=$work/recorder
flags="-I$prefix/include -L$prefix/lib"
export LD_LIBRARY_PATH="$recorder:$prefix/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
export PKG_CONFIG_PATH="$prefix/lib/pkgconfig"
export MLRT_LIBRARY="$recorder/libmlrt.so.0"
export MLRT_RECORDED="$prefix/lib/libmlrt.so.0"

make_recorder() {
    mkdir -p "$recorder"
    rm -f "$work"/*.seen
    python3 "$source/coverage.py" recorder "$recorder/recorder.c"
    echo 'MLRT_0 { global: mlrt_*; local: *; };' >"$recorder/map"
    ${CC:-cc} -std=c99 -Wall -Wextra -Werror -fPIC -shared -I"$prefix/include" -Wl,-soname,libmlrt.so.0 \
        -Wl,--version-script="$recorder/map" "$recorder/recorder.c" -ldl -o "$MLRT_LIBRARY"
}

if ! command -v python3 >/dev/null || ! make_recorder; then
    echo "no recorder: what the tests reach is not compared with the table"
    rm -rf "$recorder"
    MLRT_LIBRARY=$MLRT_RECORDED
fi

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

test_c() {
    ${CC:-cc} -std=c99 -Wall -Wextra -pedantic -Werror $flags "$source/c/test.c" -lmlrt -o "$work/test-c"
    "$work/test-c"
}

test_cpp() {
    need "${CXX:-c++}"
    for compiler in "${CXX:-c++}" $(command -v clang++); do
        for options in '-std=c++11' '-std=c++20' '-std=c++11 -fno-exceptions'; do
            $compiler $options -Wall -Wextra -pedantic -Werror $flags "$source/cpp/test.cpp" -lmlrt -pthread -o "$work/test-cpp"
            "$work/test-cpp"
        done
    done
}

test_rust() {
    need cargo pkg-config
    copy rust
    export CARGO_TARGET_DIR="$work/rust/target"
    python3 "$source/rust/make_ffi.py" --check
    cargo fetch || cargo fetch --offline || skip "cargo cannot fetch cc"
    if cargo fmt --version; then cargo fmt --check; fi
    if cargo clippy --version; then cargo clippy --offline --features system --all-targets -- -D warnings; fi
    RUSTDOCFLAGS='-D warnings' cargo doc --offline --features system --no-deps
    cargo test --offline --features system -- --nocapture
}

# As a user has it: the crate, unpacked in an empty folder.
test_rust_package() {
    package=$(package rust)
    [ -n "$package" ] || skip "no crate"
    rm -rf "$work/rust-package/unpacked"
    mkdir -p "$work/rust-package/unpacked"
    tar -C "$work/rust-package/unpacked" -xzf "$package"
    cd "$work/rust-package/unpacked/mlrt-$VERSION"
    unset LD_LIBRARY_PATH PKG_CONFIG_PATH
    CARGO_TARGET_DIR="$work/rust-package/target" cargo test --test test -- --nocapture

    # What a checkout says that has no library.
    rm c/mlrt.c
    if CARGO_TARGET_DIR="$work/rust-package/target" cargo check >without 2>&1; then exit 1; fi
    grep -q 'make amalgamation' without
}

# Go 1.26's vet may look for packages that another job of the same command still makes (golang/go#77116). So vet has one
# job, and tests, which would vet as well, do without.
test_go() {
    need go pkg-config
    copy go
    export GOTOOLCHAIN=local CGO_ENABLED=1
    unformatted=$(gofmt -l .)
    [ -z "$unformatted" ] || { echo "gofmt: $unformatted"; exit 1; }
    go vet -p=1 -tags mlrt_system .
    GOEXPERIMENT=cgocheck2 go test -vet=off -tags mlrt_system -count=1 -v .
    if go vet . >without 2>&1; then exit 1; fi
    grep -q 'make package-go' without
}

# As a user has it: an empty folder, the program of the README, and the module from a proxy. Go keeps, in its cache, an index
# of the files of a module by the folder that it is unpacked to, because a version never changes. This one does: so each
# package has a folder of its own (golang/go#69179).
test_go_package() {
    need go
    package=$(package go)
    [ -n "$package" ] || skip "no module"
    rm -rf "$work/go-package/user"
    mkdir -p "$work/go-package/user"
    cd "$work/go-package/user"
    unset LD_LIBRARY_PATH PKG_CONFIG_PATH
    export GOTOOLCHAIN=local CGO_ENABLED=1 GOPROXY="file://$work/packages/proxy" GONOSUMDB='*' GOFLAGS="-mod=mod -modcacherw"
    rm -rf "$work"/go-package/modules*
    export GOMODCACHE="$work/go-package/modules-$(cksum <"$package" | cut -d ' ' -f 1)"
    module=$(sed -n 's/^module //p' "$source/go/go.mod")
    sed -n '/^```go$/,/^```$/p' "$source/go/README.md" | sed '/^```/d' >main.go
    go mod init example.com/user
    go get "$module@v$VERSION"
    go run . | grep -qx '5 0'
    go test -vet=off -count=1 -v "$module"
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
    node --test-name-pattern='common scene' test.js
    CFLAGS=-O0 MLRT_LIBRARY= node node_modules/mlrt/build.js
    node --test-name-pattern='common scene' test.js
    node node_modules/mlrt/build.js # with the installed one, that of the recorder
    node --expose-gc test.js
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
    rm -rf "$work/java" "$work/java-test"
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
    case $language in rust | node | java | lua) grep -q offsetof "$work/$language.c" ;; esac
    ${CC:-cc} -std=c11 -fsyntax-only $flags "$work/$language.c"
}

test_python() {
    need python3
    python3 -c 'import numpy' || skip "no numpy"
    mkdir -p "$work/c" && cp "$source/c/scene.h" "$work/c"
    copy python
    cp "$MLRT_LIBRARY" mlrt/libmlrt.so.0
    cd tests
    PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=.. python3 -m unittest test_scene
    PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=.. python3 -m unittest discover
}

languages=${LANGUAGES:-c cpp python rust rust_package go go_package node java lua}
for language in $languages; do
    (
        set +e
        export MLRT_SEEN="$work/$language.seen"
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
# Whether the table in README.md says what the tests that ran have reached. A language whose tests failed is not looked at.
for language in $languages; do
    [ "$(cat "$work/$language.status")" -eq 0 ] || rm -f "$work/$language.seen"
done
if [ -d "$recorder" ]; then
    if python3 "$source/coverage.py" ${COVERAGE:-check} "$source/README.md" "$work"; then
        passed=$((passed + 1))
        echo "coverage: ok"
    else
        failed=$((failed + 1))
        echo "coverage: FAILED"
    fi
fi
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
