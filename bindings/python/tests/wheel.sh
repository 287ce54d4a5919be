#!/bin/sh
# SPDX-License-Identifier: MIT
# Builds the source distribution and, from it alone, the wheel; installs that into a fresh environment and runs the tests
# there, far from the checkout. Says what the wheel weighs and, if auditwheel is there, what it fits.
#
#   sh wheel.sh FOLDER      works in FOLDER, which is emptied first
set -eu
python=${PYTHON:-python3}
here=$(cd "$(dirname "$0")/.." && pwd)
rm -rf "$1" && mkdir -p "$1/far/python/tests" && folder=$(cd "$1" && pwd)

cp -r "$here" "$folder/copy" # setuptools leaves folders where it builds
mkdir -p "$folder/checkout/bindings" && mv "$folder/copy" "$folder/checkout/bindings/python"
for part in Makefile LICENSE include src; do cp -r "$here/../../$part" "$folder/checkout/"; done
$python -m venv "$folder/venv"
pip="$folder/venv/bin/python -m pip --disable-pip-version-check"
$pip install -q build numpy
"$folder/venv/bin/python" -m build --sdist -o "$folder/dist" "$folder/checkout/bindings/python" >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
rm -rf "$folder/checkout"

$pip wheel -q --no-deps -w "$folder/dist" "$folder"/dist/mlrt-*.tar.gz
wheel=$(echo "$folder"/dist/mlrt-*.whl)
$pip install -q "$wheel"
cp "$here"/tests/*.py "$folder/far/python/tests/"
cp -r "$here/../c" "$folder/far/" # test_scene reads what all languages have in common
cd "$folder/far/python/tests"
unset PYTHONPATH
"$folder/venv/bin/python" - "$folder/venv" "$wheel" <<'END'
import os, sys, zipfile
import mlrt
from mlrt import _library

folder, wheel = sys.argv[1:]
path = _library.candidates()[0]
assert path.startswith(folder) and os.path.dirname(path) == os.path.dirname(mlrt.__file__), path
assert b".symtab" not in open(path, "rb").read(), "the library is not stripped"
assert {"mlrt/py.typed", "mlrt/LICENSE"} <= set(zipfile.ZipFile(wheel).namelist())
size = os.path.getsize(wheel)
assert size < 1_000_000, size
print(f"{os.path.basename(wheel)}: {size} bytes, the library in it {os.path.getsize(path)}")
END
"$folder/venv/bin/python" -m unittest -q
if command -v auditwheel >/dev/null; then
    auditwheel show "$wheel" | tr '\n' ' ' | grep -o 'consistent with.*tag: "[a-z0-9_]*"'
else
    echo "no auditwheel: not asked what it fits"
fi
