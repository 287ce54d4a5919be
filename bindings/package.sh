#!/bin/sh
# SPDX-License-Identifier: MIT
# Puts a package together that carries the library: package.sh rust|go AMALGAMATION FOLDER VERSION
#
#   rust   FOLDER is the crate, and FOLDER/target/package/mlrt-VERSION.crate what crates.io gets
#   go     FOLDER/go is the module, and FOLDER/proxy what a module proxy serves of it (GOPROXY=file://...)
set -e
language=$1 amalgamation=$2 folder=$3 version=$4
source=$(cd "$(dirname "$0")" && pwd)

case $language in
rust)
    mkdir -p "$folder/c"
    rm -rf "$folder/src" "$folder/tests" "$folder"/target/package/*
    cp -R "$source"/rust/src "$source"/rust/tests "$source"/rust/Cargo.toml "$source"/rust/build.rs "$source"/rust/README.md "$folder"
    cp "$source/../LICENSE" "$folder"
    cp "$amalgamation/mlrt.c" "$amalgamation/mlrt.h" "$folder/c"
    grep -qx "version = \"$version\"" "$folder/Cargo.toml" || { echo "bindings/rust/Cargo.toml: the version is not $version"; exit 1; }
    cd "$folder"
    # Not verified here: the tests unpack and build it.
    CARGO_TARGET_DIR=$PWD/target cargo package --quiet --allow-dirty --no-verify
    ls -l "$PWD/target/package/mlrt-$version.crate" | awk '{ print $5 " bytes: " $NF }'
    ;;
go)
    rm -rf "$folder/go" "$folder/proxy"
    mkdir -p "$folder/go"
    cp "$source"/go/*.go "$source"/go/bridge.[ch] "$source"/go/go.mod "$source"/go/README.md "$source/../LICENSE" "$folder/go"
    cp "$amalgamation/mlrt.h" "$folder/go"
    { printf '//go:build !mlrt_system\n\n'; cat "$amalgamation/mlrt.c"; } >"$folder/go/mlrt.c"
    module=$(sed -n 's/^module //p' "$source/go/go.mod")
    python3 - "$folder" "$module" "v$version" <<'END'
import pathlib, sys, zipfile
folder, module, version = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3]
versions = folder / "proxy" / module / "@v"
versions.mkdir(parents=True)
(versions / "list").write_text(version + "\n")
(versions / f"{version}.info").write_text(f'{{"Version":"{version}","Time":"2025-01-01T00:00:00Z"}}')
(versions / f"{version}.mod").write_text((folder / "go" / "go.mod").read_text())
with zipfile.ZipFile(versions / f"{version}.zip", "w", zipfile.ZIP_DEFLATED) as archive:
    for file in sorted((folder / "go").iterdir()):
        archive.writestr(zipfile.ZipInfo(f"{module}@{version}/{file.name}"), file.read_bytes(), zipfile.ZIP_DEFLATED)
print((versions / f"{version}.zip").stat().st_size, f"bytes: {versions / f'{version}.zip'}")
END
    ;;
esac
