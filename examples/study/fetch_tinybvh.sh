#!/bin/sh
# SPDX-License-Identifier: MIT
# Puts tiny_bvh.h into a folder, out of the Rust package that carries it. Without cargo, or a network, it says that
# studies go without tinybvh.
set -eu
folder=$1
version=0.1.0-beta.3 # of the package; it has tinybvh 1.6.8
[ -f "$folder/tiny_bvh.h" ] && exit 0
command -v cargo >/dev/null || { echo "no cargo, which fetches tinybvh: studies go without it"; exit 0; }
mkdir -p "$folder/package/src"
: >"$folder/package/src/lib.rs"
printf '[package]\nname = "fetch"\nversion = "0.0.0"\n[dependencies]\ntinybvh-rs = "=%s"\n[workspace]\n' "$version" \
    >"$folder/package/Cargo.toml"
if cargo fetch --quiet --manifest-path "$folder/package/Cargo.toml"; then
    header=$(find "${CARGO_HOME:-$HOME/.cargo}/registry/src" -path "*tinybvh-rs-$version/*/tiny_bvh.h" | head -n 1)
    [ -n "$header" ] && cp "$header" "$folder/"
fi
rm -rf "$folder/package"
[ -f "$folder/tiny_bvh.h" ] || echo "tinybvh could not be fetched: studies go without it"
