# SPDX-License-Identifier: MIT
"""One ray a call, as cheap as Python allows: no arrays, no structs made anew, no pause for other threads.

Calls go through a PyDLL, which keeps the GIL: a ray takes less time than to give the GIL away and to take it again.
"""

import ctypes
import struct
from functools import lru_cache
from math import inf
from typing import Any, NamedTuple, Optional

import numpy as np

from ._abi import NONE, library
from ._arrays import FLOAT, INT, UINT
from ._errors import check
from ._results import HIT_FIELDS, Hits, check_names

# A t_max that no ray has hits below. In an mlrt_ray and an mlrt_camera, 0 means no limit.
NOTHING = -1.0
_ROUNDS_TO_ZERO = 2.0**-150  # and what is less than it; what is greater is at least the smallest float

_SKIP = 1  # MLRT_RAY_SKIP

# mlrt_ray and mlrt_hit.
_RAY = struct.Struct("=II3f3fffII")
_HIT = struct.Struct("=IfffIIiI")
_RESULT = struct.Struct("=fffIIi")
_RESULT_START = 4
_OCCLUDED_START = 28
_RAY_SIZE, _HIT_SIZE = _RAY.size, _HIT.size

_trace: Any = ctypes.PyDLL(library._name, handle=library._handle).mlrt_trace_ray  # no argtypes: arguments are pointers already
_pack = _RAY.pack_into
_unpack = _RESULT.unpack_from


class Hit(NamedTuple):
    """The closest hit of one ray, in numbers. True if there is one: `if hit := tree.trace_ray(...)`."""

    t: float  #: distance in units of the direction's length, rounded to float32; inf = miss, or beyond the range of float
    u: float  #: weight of the triangle's second vertex
    v: float  #: weight of its third
    mesh: int  #: id of the mesh; mlrt.NONE = miss
    triangle: int  #: number of the triangle in its mesh; mlrt.NONE = miss
    facing: int  #: +1: the ray travels along the normal, -1: against it, 0 = miss

    def __bool__(self) -> bool:
        return self.facing != 0


class _Slot:
    """An mlrt_ray and an mlrt_hit, for one call at a time."""

    __slots__ = ("ray", "hit", "ray_pointer", "hit_pointer")

    def __init__(self) -> None:
        self.ray, self.hit = ctypes.create_string_buffer(_RAY_SIZE), ctypes.create_string_buffer(_HIT_SIZE)
        self.ray_pointer, self.hit_pointer = ctypes.byref(self.ray), ctypes.byref(self.hit)
        _HIT.pack_into(self.hit, 0, _HIT_SIZE, inf, 0, 0, NONE, NONE, 0, 0)


_free: list[_Slot] = []  # as many as there ever were calls at the same time


def _slot() -> _Slot:
    try:
        return _free.pop()
    except IndexError:
        return _Slot()


def limit(t_max: Optional[float]) -> float:
    """The t_max of an mlrt_ray or an mlrt_camera, where 0 means no limit."""
    if t_max is None:
        return 0.0
    return t_max if abs(t_max) > _ROUNDS_TO_ZERO or t_max != t_max else NOTHING


def _numbers(vector: Any) -> Any:
    return vector.tolist() if vector.__class__ is np.ndarray else vector


def _call(slot: _Slot, handle: Any, origin: Any, direction: Any, t_min: Any, t_max: Any, skip: Any, options: Any) -> int:
    flags = mesh = triangle = 0
    try:
        x, y, z = _numbers(origin)
        dx, dy, dz = _numbers(direction)
        if t_max is not None or skip is not None:
            t_max = limit(t_max)
            if skip is not None:
                flags, (mesh, triangle) = _SKIP, skip
                mesh, triangle = int(mesh) & NONE, int(triangle) & NONE
            _pack(slot.ray, 0, _RAY_SIZE, flags, x, y, z, dx, dy, dz, t_min, t_max, mesh, triangle)
        else:
            _pack(slot.ray, 0, _RAY_SIZE, 0, x, y, z, dx, dy, dz, t_min, 0.0, 0, 0)
    except (struct.error, OverflowError, TypeError, ValueError) as error:
        raise ValueError(
            f"one ray: origin and direction must be three numbers each within the range of float32, t_min and t_max one, and skip "
            f"two integers: not {origin!r}, {direction!r}, {t_min!r}, {t_max!r}, {skip!r}"
        ) from error
    status: int = _trace(handle, slot.ray_pointer, options, slot.hit_pointer)
    return status


def closest(handle: Any, origin: Any, direction: Any, t_min: Any, t_max: Any, skip: Any, options: Any) -> Hit:
    """mlrt_trace_ray. options: a pointer to mlrt_trace_options, or None."""
    slot = _slot()
    status = _call(slot, handle, origin, direction, t_min, t_max, skip, options)
    if status:
        check(status)
    hit = tuple.__new__(Hit, _unpack(slot.hit, _RESULT_START))
    _free.append(slot)
    return hit


def occluded(handle: Any, origin: Any, direction: Any, t_min: Any, t_max: Any, skip: Any, options: Any) -> bool:
    """mlrt_trace_ray with options that have MLRT_QUERY_ANY."""
    slot = _slot()
    status = _call(slot, handle, origin, direction, t_min, t_max, skip, options)
    if status:
        check(status)
    hit = slot.hit[_OCCLUDED_START] != b"\0"
    _free.append(slot)
    return hit


# ---- a single ray in arrays --------------------------------------------------------------------------------------------

# An mlrt_ray whose origin and direction are bytes of arrays, and an mlrt_hit as an element of an array.
_RAY_OF_BYTES = struct.Struct("=II12s12sffII")
_pack_bytes = _RAY_OF_BYTES.pack_into
_HIT_TYPE = np.dtype(
    [("struct_size", UINT), ("t", FLOAT), ("u", FLOAT), ("v", FLOAT), ("mesh", UINT), ("triangle", UINT), ("facing", INT)]
    + [("occluded", UINT)]
)


def is_one(origins: Any, directions: Any) -> bool:
    """Are these arrays of float32 with one ray, of the same shape?"""
    return bool(
        origins.__class__ is np.ndarray
        and directions.__class__ is np.ndarray
        and origins.size == 3
        and origins.dtype is FLOAT
        and directions.dtype is FLOAT
        and origins.shape == directions.shape
        and origins.shape[-1] == 3
    )


@lru_cache(maxsize=256)
def _wanted(outputs: Any) -> Any:
    """The names of all wanted outputs with their places in Hits; None = all of them."""
    names = check_names(outputs, HIT_FIELDS)
    return None if names == HIT_FIELDS else tuple((HIT_FIELDS.index(name), name) for name in names)


def closest_in_arrays(handle: Any, origins: Any, directions: Any, outputs: Any) -> Hits:
    """What mlrt_trace_packet answers to one ray (is_one), in new arrays."""
    wanted = _wanted(outputs if outputs is None or outputs.__class__ is str else tuple(outputs))
    slot = _slot()
    _pack_bytes(slot.ray, 0, _RAY_SIZE, 0, origins.tobytes(), directions.tobytes(), 0.0, 0.0, 0, 0)
    status = _trace(handle, slot.ray_pointer, None, slot.hit_pointer)
    if status:
        check(status)
    hit = np.ndarray(origins.shape[:-1], _HIT_TYPE, bytearray(slot.hit))
    _free.append(slot)
    if wanted is None:
        return _new_hits(Hits, (hit["t"], hit["u"], hit["v"], hit["mesh"], hit["triangle"], hit["facing"], None))
    arrays: list[Any] = [None] * len(Hits._fields)
    for place, name in wanted:
        arrays[place] = hit[name]
    return _new_hits(Hits, arrays)


_new_hits = tuple.__new__


def occluded_in_array(handle: Any, origins: Any, directions: Any, options: Any) -> np.ndarray:
    """Likewise of any hit."""
    slot = _slot()
    _pack_bytes(slot.ray, 0, _RAY_SIZE, 0, origins.tobytes(), directions.tobytes(), 0.0, 0.0, 0, 0)
    status = _trace(handle, slot.ray_pointer, options, slot.hit_pointer)
    if status:
        check(status)
    found = np.empty(origins.shape[:-1], np.bool_)
    found.fill(slot.hit[_OCCLUDED_START] != b"\0")
    _free.append(slot)
    return found
