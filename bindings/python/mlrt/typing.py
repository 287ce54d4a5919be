# SPDX-License-Identifier: MIT
"""The kinds of arguments, under the names that signatures have for them.

Arrays of these dtypes, packed along their last axis, are read where they lie; others, and lists, are copied once.

To type checkers each is what it stands for. At run time each is a class without use but for its text, so that `help` and the pages of
`make docs-python` have a name where the whole type would be.
"""

from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Mapping
    from typing import Any, Literal, Optional, Union

    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Buffer  # in collections.abc since Python 3.12; to type checkers before that an array is none

    from ._lights import DirectionalLight
    from ._pool import Pool

    Vector = ArrayLike
    Vectors = ArrayLike
    Numbers = ArrayLike
    Faces = Optional[ArrayLike]
    Skips = Optional[ArrayLike]
    Masks = Optional[ArrayLike]
    Mesh = Any
    Meshes = Union[Iterable[Mesh], Mapping[int, Mesh]]
    Light = Union[Vector, DirectionalLight]
    Lights = Optional[Iterable[Light]]
    Outputs = Union[str, Iterable[str], None]
    Threads = Union[Pool, int, None]
    Preset = Literal["default", "fast", "best"]
    KdTreePreset = Literal["paper", "tuned"]
    Method = Optional[Literal["ray", "packet2", "packet4", "multilevel", "tile"]]
    Isa = Optional[Literal["scalar", "sse", "avx2", "avx512", "neon"]]
    Path = Union[str, os.PathLike[str]]
    Source = Union[Path, Buffer, NDArray[Any]]
else:
    class Vector:
        """Three numbers."""

    class Vectors:
        """float32 (..., 3): points or directions."""

    class Numbers:
        """float32 (...): a number for each ray, or one for all."""

    class Faces:
        """uint16, uint32 or int32 (m, 3): three vertices of each triangle. None: vertices 0, 1, 2 are a triangle, so are 3, 4, 5."""

    class Skips:
        """uint32 (..., 2): for each ray the mesh and the triangle that it passes through, (-1, -1) or None for none."""

    class Masks:
        """An int of 32 bits for all rays, or uint32 (...), one for each. 0 and None: all bits."""

    class Mesh:
        """(vertices, faces), or an object with attributes of these names, as a trimesh.Trimesh has."""

    class Meshes:
        """Several meshes, with the ids 0, 1, 2, ...; or a dictionary from ids to meshes."""

    class Light:
        """A point (3,) where a light is, or a mlrt.DirectionalLight."""

    class Lights:
        """Up to eight of them. None: no shadows are asked for."""

    class Outputs:
        """Names of the arrays that are wanted, or one name. None: all of them."""

    class Threads:
        """A mlrt.Pool; or a number of threads, 0 for one per processor, whose pool is made once and kept; None: the calling thread."""

    class Preset:
        """How carefully a tree is built."""

    class KdTreePreset:
        """Rules of a kd-tree's builder."""

    class Method:
        """How to trace, None: as is best. It never changes an answer."""

    class Isa:
        """The instruction set, None: the best of this machine. It never changes an answer."""

    class Path:
        """The name of a file."""

    class Source:
        """The name of a file, or anything with a buffer of bytes: bytes, mmap, memoryview, an array."""
