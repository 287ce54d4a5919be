#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs trimesh's own tests with mlrt.trimesh.RayMeshIntersector in place of its classes: of a checkout, or of the source distribution
# of the trimesh that is installed, which is fetched once and unpacked.
#
#   sh trimesh_own.sh PYTHON FOLDER [CHECKOUT]      works in FOLDER
set -eu
python=$1 folder=$2 checkout=${3:-}
here=$(cd "$(dirname "$0")" && pwd)
if ! "$python" -c 'import trimesh, pytest, scipy' 2>/dev/null; then
    echo "test-trimesh: no trimesh, pytest and scipy: nothing tested (make deps-python installs them)"
    exit 0
fi
if [ -z "$checkout" ]; then
    version=$("$python" -c 'import trimesh; print(trimesh.__version__)')
    checkout=$folder/trimesh-$version
    mkdir -p "$folder"
    if [ ! -d "$checkout" ]; then
        if ! "$python" -m pip --disable-pip-version-check download -q --no-deps --no-binary trimesh -d "$folder" "trimesh==$version"; then
            echo "test-trimesh: no network, or no source distribution of trimesh $version there: nothing tested"
            exit 0
        fi
        tar xzf "$checkout.tar.gz" -C "$folder"
    fi
fi
PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$(dirname "$here") exec "$python" "$here/trimesh_own.py" "$checkout"
