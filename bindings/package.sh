#!/bin/sh
# SPDX-License-Identifier: MIT
# Packs a binding with all that it needs, for those who have no libmlrt: sh bindings/package.sh LANGUAGE BUILD OUT (make
# package-node and so on do that). BUILD is the folder where libmlrt and the amalgamation are built, OUT receives the
# package and, in a folder LANGUAGE, what was packed. The last line of output is the path of the package.
#
# CC: the compiler of BUILD's library. VERSION: the version, which the package's own files must have too.
set -e
language=$1
source=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$2" && pwd)
mkdir -p "$3"
out=$(cd "$3" && pwd)
stage=$out/$language
version=${VERSION:?}

# Like the tests in bindings/test.sh: 77 = a tool is missing.
need() {
    for tool in "$@"; do command -v "$tool" >/dev/null || { echo "no $tool"; exit 77; }; done
}

same_version() {
    grep -q "$version" "$1" || { echo "$1 is not of version $version"; exit 1; }
}

rm -rf "$stage"
mkdir -p "$stage"
cp -R "$source/$language/." "$stage"
cp "$source/../LICENSE" "$stage"
cd "$stage"

# The whole library in one file, to be compiled where the package is installed; and the same compiled for this machine.
package_node() {
    need node npm
    same_version package.json
    rm -rf node_modules
    cp "$build/amalgamation/mlrt.c" "$build/amalgamation/mlrt.h" .
    prebuilt=prebuilt/$(node -p 'process.platform + "-" + process.arch')
    mkdir -p "$prebuilt"
    ${CC:-cc} -O2 -fPIC -shared -I. native.c -Wl,--whole-archive "$build/libmlrt.a" -Wl,--no-whole-archive -Wl,-Bsymbolic-functions \
        -lm -pthread -o "$prebuilt/mlrt.node.so"
    strip "$prebuilt/mlrt.node.so"
    npm pack --silent --pack-destination "$out" >/dev/null
    package=$out/mlrt-$version.tgz
}

# The newest Java kit from 22 on, where java.lang.foreign came to stay.
find_kit() {
    newest=0
    for home in "$JAVA_HOME" "$(dirname "$(dirname "$(readlink -f "$(command -v javac)")")")" /usr/lib/jvm/*; do
        number=$(sed -n 's/^JAVA_VERSION="\([0-9]*\).*/\1/p' "$home/release" 2>/dev/null || true)
        if [ -x "$home/bin/javac" ] && [ "${number:-0}" -gt "$newest" ]; then newest=$number kit=$home; fi
    done
    [ "$newest" -ge 22 ] || { echo "no JDK 22 or later"; exit 77; }
}

# The library of this machine in the jar; sources and documentation in two jars more.
package_java() {
    need mvn
    find_kit
    same_version pom.xml
    native=src/main/resources/mlrt/native/$(uname -s | tr A-Z a-z)-$(uname -m)
    mkdir -p "$native" src/main/resources/META-INF
    cp LICENSE src/main/resources/META-INF
    cp "$build/libmlrt.so" "$native/libmlrt.so"
    strip "$native/libmlrt.so"
    if ! JAVA_HOME=$kit mvn -B -q package >log 2>&1; then
        cat log
        if grep -qE 'Could not transfer|cannot be resolved|could not be resolved|offline mode' log; then echo "mvn cannot fetch its plugins"; exit 77; fi
        exit 1
    fi
    if grep '^\[WARNING\]' log; then exit 1; fi
    cp target/mlrt-*.jar "$out"
    package=$out/mlrt-$version.jar
}

# A source rock: LuaRocks compiles the library where the rock is installed.
package_lua() {
    need luarocks
    rockspec=mlrt-$version-1.rockspec
    cp "$build/amalgamation/mlrt.c" "$build/amalgamation/mlrt.h" .
    folder=mlrt-lua-$version
    mkdir "$folder"
    cp mlrt.lua mlrt.c mlrt.h README.md LICENSE "$folder"
    tar -czf "$out/$folder.tar.gz" "$folder"
    sed -e "s|@VERSION@|$version|g" -e "s|@SOURCE@|${LUA_SOURCE:-file://$out/$folder.tar.gz}|" mlrt.rockspec.in >"$out/$rockspec"
    cd "$out"
    luarocks --lua-version 5.1 lint "$rockspec"
    luarocks --lua-version 5.1 pack "$rockspec" >/dev/null
    package=$out/mlrt-$version-1.src.rock
}

# The crate that crates.io gets, with the whole library in one file. It is not verified here: the tests unpack and build it.
package_rust() {
    need cargo
    grep -qx "version = \"$version\"" Cargo.toml || { echo "Cargo.toml is not of version $version"; exit 1; }
    mkdir c
    cp "$build/amalgamation/mlrt.c" "$build/amalgamation/mlrt.h" c
    rm -rf "$out/target"
    cargo fetch --quiet 2>/dev/null || { echo "cargo cannot fetch cc"; exit 77; }
    CARGO_TARGET_DIR=$out/target cargo package --quiet --allow-dirty --no-verify
    mv "$out/target/package/mlrt-$version.crate" "$out"
    rm -rf "$out/target"
    package=$out/mlrt-$version.crate
}

# The module, with the whole library in one file, and in $out/proxy as a module proxy serves it (GOPROXY=file://...).
package_go() {
    need python3
    cp "$build/amalgamation/mlrt.h" .
    { printf '//go:build !mlrt_system\n\n'; cat "$build/amalgamation/mlrt.c"; } >mlrt.c
    module=$(sed -n 's/^module //p' go.mod)
    package=$out/proxy/$module/@v/v$version.zip
    rm -rf "$out/proxy"
    mkdir -p "$(dirname "$package")"
    cp go.mod "$out/proxy/$module/@v/v$version.mod"
    echo "v$version" >"$out/proxy/$module/@v/list"
    echo "{\"Version\":\"v$version\",\"Time\":\"2025-01-01T00:00:00Z\"}" >"$out/proxy/$module/@v/v$version.info"
    python3 - "$package" "$module@v$version" *.go *.c *.h go.mod README.md LICENSE <<'END'
import pathlib, sys, zipfile
with zipfile.ZipFile(sys.argv[1], "w") as archive:
    for file in sorted(sys.argv[3:]):
        content = pathlib.Path(file).read_bytes()
        archive.writestr(zipfile.ZipInfo(f"{sys.argv[2]}/{file}"), content, zipfile.ZIP_DEFLATED)
END
}

"package_$language"
echo "$(wc -c <"$package") bytes"
echo "$package"
