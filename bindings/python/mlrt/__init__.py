# SPDX-License-Identifier: MIT
"""Where do rays hit triangles: exact ray tracing for numpy arrays.

    import mlrt
    tree = mlrt.Tree(vertices, faces)           # float32 (n, 3), uint32 (m, 3)
    hits = tree.trace(origins, directions)      # float32 (..., 3) each
    hits.t, hits.triangle                       # float32, uint32 (...)

Every answer equals exact arithmetic on the float32 numbers given; include/mlrt.h of the library states the rules.
"""

from ._abi import NONE, Counters
from ._camera import Camera
from ._errors import (
    ArgumentError,
    CameraError,
    CancelledError,
    Error,
    IndexRangeError,
    OutOfMemoryError,
    StructSizeError,
    ThreadError,
    TooLargeError,
    UnsupportedError,
)
from ._pool import Pool
from ._results import HitLists, Hits
from ._tree import Tree, TreeInfo


def version() -> tuple[int, int, int]:
    """The library's version: major, minor, patch."""
    from ._abi import library

    number = library.mlrt_version()
    return number // 10000, number // 100 % 100, number % 100


__all__ = [
    "NONE",
    "ArgumentError",
    "Camera",
    "CameraError",
    "CancelledError",
    "Counters",
    "Error",
    "HitLists",
    "Hits",
    "IndexRangeError",
    "OutOfMemoryError",
    "Pool",
    "StructSizeError",
    "ThreadError",
    "TooLargeError",
    "Tree",
    "TreeInfo",
    "UnsupportedError",
    "version",
]
