# SPDX-License-Identifier: MIT
"""Where do rays hit triangles: exact ray tracing for numpy arrays.

    import mlrt
    tree = mlrt.Tree(vertices, faces)           # float32 (n, 3), uint32 (m, 3)
    hits = tree.trace(origins, directions)      # float32 (..., 3) each
    hits.t, hits.triangle, hits.points          # float32 (...), uint32 (...), float32 (..., 3)

mlrt.typing has the names of arguments' types, mlrt.trimesh a ray class for trimesh, mlrt.distributed traces over a cluster of Dask.
Every answer equals exact arithmetic on the float32 numbers given; include/mlrt.h of the library states the rules.
"""

from ._abi import NONE, Counters
from ._build import MemoryEstimate, estimate_kdtree, estimate_tree
from ._camera import Camera
from ._errors import (
    ArgumentError,
    CameraError,
    CancelledError,
    DataError,
    Error,
    IndexRangeError,
    OutOfMemoryError,
    StructSizeError,
    ThreadError,
    TooLargeError,
    UnsupportedError,
)
from ._lights import DirectionalLight
from ._meshes import geometry_hash, geometry_hash_of_meshes
from ._pool import Pool
from ._results import HitLists, Hits
from ._single import Hit
from ._tree import Tree, TreeInfo


def version() -> tuple[int, int, int]:
    """The library's version: major, minor, patch."""
    from ._abi import library

    number = library.mlrt_version()
    return number // 10000, number // 100 % 100, number % 100


def capabilities() -> frozenset[str]:
    """What the library can do on this machine: names out of "sse", "avx2", "avx512", "neon" (isa)."""
    from ._abi import CAPABILITIES, library

    bits = library.mlrt_capabilities()
    return frozenset(name for name, bit in CAPABILITIES.items() if bits & bit)


__all__ = [
    "NONE",
    "ArgumentError",
    "Camera",
    "CameraError",
    "CancelledError",
    "Counters",
    "DataError",
    "DirectionalLight",
    "Error",
    "Hit",
    "HitLists",
    "Hits",
    "IndexRangeError",
    "MemoryEstimate",
    "OutOfMemoryError",
    "Pool",
    "StructSizeError",
    "ThreadError",
    "TooLargeError",
    "Tree",
    "TreeInfo",
    "UnsupportedError",
    "capabilities",
    "estimate_kdtree",
    "estimate_tree",
    "geometry_hash",
    "geometry_hash_of_meshes",
    "version",
]
