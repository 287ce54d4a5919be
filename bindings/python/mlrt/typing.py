# SPDX-License-Identifier: MIT
"""The kinds of arguments, under the names that signatures have for them. For type checkers: at run time any array will do.

Arrays of these dtypes, packed along their last axis, are read where they lie; others, and lists, are copied once.
"""

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, Optional, Union

from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:  # Buffer is in collections.abc since Python 3.12. To type checkers before that an array is none
    from typing_extensions import Buffer

    from ._lights import DirectionalLight
    from ._pool import Pool

__all__ = [
    "Faces",
    "Isa",
    "KdTreePreset",
    "Light",
    "Lights",
    "Masks",
    "Mesh",
    "Meshes",
    "Method",
    "Numbers",
    "Outputs",
    "Path",
    "Preset",
    "Skips",
    "Source",
    "Threads",
    "Vector",
    "Vectors",
]

Vector = ArrayLike
"""Three numbers."""

Vectors = ArrayLike
"""float32 (..., 3): points or directions."""

Numbers = ArrayLike
"""float32 (...): a number for each ray, or one for all."""

Faces = Optional[ArrayLike]
"""uint16, uint32 or int32 (m, 3): three vertices of each triangle. None: vertices 0, 1, 2 are a triangle, so are 3, 4, 5."""

Skips = Optional[ArrayLike]
"""uint32 (..., 2): for each ray the mesh and the triangle that it passes through, (-1, -1) or None for none."""

Masks = Optional[ArrayLike]
"""An int of 32 bits for all rays, or uint32 (...), one for each. 0 and None: all bits."""

Mesh = Any
"""(vertices, faces), or an object with attributes of these names, as a trimesh.Trimesh has."""

Meshes = Union[Iterable[Mesh], Mapping[int, Mesh]]
"""Several meshes, with the ids 0, 1, 2, ...; or a dictionary from ids to meshes."""

Light = Union[Vector, "DirectionalLight"]
"""A point (3,) where a light is, or a mlrt.DirectionalLight."""

Lights = Optional[Iterable[Light]]
"""Up to eight of them. None: no shadows are asked for."""

Outputs = Union[str, Iterable[str], None]
"""Names of the arrays that are wanted, or one name. None: all of them."""

Threads = Union["Pool", int, None]
"""A mlrt.Pool; or a number of threads, 0 for one per processor, whose pool is made once and kept; None: the calling thread."""

Preset = Literal["default", "fast", "best"]
"""How carefully a tree is built."""

KdTreePreset = Literal["paper", "tuned"]
"""Rules of a kd-tree's builder."""

Method = Optional[Literal["ray", "packet2", "packet4", "multilevel", "tile"]]
"""How to trace, None: as is best. It never changes an answer."""

Isa = Optional[Literal["scalar", "sse", "avx2", "avx512"]]
"""The instruction set, None: the best of this machine. It never changes an answer."""

Path = Union[str, "os.PathLike[str]"]
"""The name of a file."""

Source = Union[Path, "Buffer", NDArray[Any]]
"""The name of a file, or anything with a buffer of bytes: bytes, mmap, memoryview, an array."""
