# SPDX-License-Identifier: MIT
"""Meshes as an array of mlrt_mesh, and their hash."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from operator import index
from typing import Any, Optional

import numpy as np

from . import _abi
from ._abi import library
from ._arrays import elements, faces as face_array, mask_word, vectors
from ._errors import check
from .typing import Faces, Meshes as ManyMeshes, Vectors


class Meshes:
    """`structs` is the array, valid as long as this lives."""

    @classmethod
    def of(cls, meshes: ManyMeshes, ids: Optional[Sequence[int]], masks: Optional[Sequence[int]]) -> Meshes:
        """Of what Tree.from_meshes takes."""
        if isinstance(meshes, Mapping):
            if ids is not None:
                raise ValueError("ids: the dictionary of meshes has the ids already")
            ids, meshes = list(meshes), list(meshes.values())
        return cls([parts(mesh) for mesh in meshes], ids, masks)

    def __init__(
        self, meshes: Sequence[tuple[Any, Any]], ids: Optional[Sequence[int]], masks: Optional[Sequence[int]]
    ) -> None:
        for name, given in (("ids", ids), ("masks", masks)):
            if given is not None and len(given) != len(meshes):
                raise ValueError(f"{name}: {len(given)} are given for {len(meshes)} meshes")
        self.structs: Any = (_abi.Mesh * len(meshes))()
        self._alive = [_fill_mesh(struct, *mesh) for struct, mesh in zip(self.structs, meshes)]
        for struct, number in zip(self.structs, () if ids is None else ids):
            struct.id = in_32_bits(number, "ids")
        for struct, mask in zip(self.structs, () if masks is None else masks):
            struct.mask = mask_word(mask, "masks")

    @property
    def triangle_count(self) -> int:
        return sum(struct.triangle_count for struct in self.structs)


def parts(mesh: Any) -> tuple[Any, Any]:
    """Vertices and faces of (vertices, faces), or of an object that has them."""
    if hasattr(mesh, "vertices"):
        return mesh.vertices, mesh.faces
    vertices, faces = mesh
    return vertices, faces


def in_32_bits(number: int, what: str) -> int:
    return _in_bits(number, what, 32)


def in_64_bits(number: int, what: str) -> int:
    return _in_bits(number, what, 64)


def _in_bits(number: Any, what: str, bits: int) -> int:
    try:
        number = index(number)
    except TypeError:
        raise TypeError(f"{what}: an integer is needed, not {number!r}") from None
    if not 0 <= number < 1 << bits:
        raise ValueError(f"{what}: {number} does not fit into {bits} bits")
    return int(number)


def _hash(meshes: Meshes) -> int:
    number = ctypes.c_uint64()
    check(library.mlrt_hash_geometry(meshes.structs, len(meshes.structs), ctypes.byref(number)))
    return number.value


def geometry_hash(vertices: Vectors, faces: Faces = None, *, mask: int = 0) -> int:
    """A hash of what Tree takes: of the corners of all triangles in order, and the mask. An int of 64 bits.

    The same however triangles are indexed and laid out in memory, and on every machine: is a saved tree still that of my
    mesh? Vertices are hashed as float32. Arguments as for Tree.
    """
    return _hash(Meshes([(vertices, faces)], None, [mask]))


def geometry_hash_of_meshes(
    meshes: ManyMeshes, ids: Optional[Sequence[int]] = None, masks: Optional[Sequence[int]] = None
) -> int:
    """Likewise, of what Tree.from_meshes takes: ids and masks are hashed too."""
    return _hash(Meshes.of(meshes, ids, masks))


def _fill_mesh(struct: _abi.Mesh, vertices: Any, faces: Any) -> list[np.ndarray]:
    """Fills an mlrt_mesh; returns the arrays that must live as long as it."""
    vertices = vectors(vertices, "vertices")
    if faces is None:
        vertices = vertices.reshape(-1, 3)
    if vertices.ndim != 2:
        raise ValueError(f"vertices: the shape must be (n, 3), not {vertices.shape}")
    struct.struct_size = ctypes.sizeof(struct)
    struct.vertex_count = len(vertices)
    vertices, struct.vertices, struct.vertex_stride = _apart(vertices)
    if faces is None:
        if len(vertices) % 3:
            raise ValueError(f"vertices: {len(vertices)} are no triangles of three each; give faces")
        struct.triangle_count = len(vertices) // 3
        return [vertices]
    faces = face_array(faces)
    struct.triangle_count, struct.index_size = len(faces), faces.itemsize
    faces, struct.indices, struct.triangle_stride = _apart(faces)
    return [vertices, faces]


def _apart(array: np.ndarray) -> tuple[np.ndarray, int, int]:
    """As `elements`, for arrays whose elements may not overlap."""
    if array.strides[0] < 3 * array.itemsize:
        array = np.ascontiguousarray(array)
    return elements(array, 3)
