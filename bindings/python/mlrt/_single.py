# SPDX-License-Identifier: MIT
"""One ray a call, as cheap as Python allows: no arrays, no structs made anew, no pause for other threads.

Calls go through a PyDLL, which keeps the GIL: a ray takes less time than to give the GIL away and to take it again.
"""

import ctypes
import struct
import sys
from functools import lru_cache
from math import inf
from typing import Any, NamedTuple, Optional

import numpy as np

from ._abi import NONE, library
from ._arrays import FLOAT, INT, UINT, id_word
from ._errors import check
from ._results import HIT_FIELDS, Hits, check_names, make_hits

# A t_max that no ray has hits below. In an mlrt_ray and an mlrt_camera, 0 means no limit.
NOTHING = -1.0
_ROUNDS_TO_ZERO = 2.0**-150  # and what is less than it; what is greater is at least the smallest float

_SKIP = 1  # MLRT_RAY_SKIP

# mlrt_ray and mlrt_hit.
_RAY = struct.Struct("=II3f3fffII")
_HIT = struct.Struct("=IfffIIiI")
_RESULT = struct.Struct("=fffIIi")
_RESULT_START = 4
_OCCLUDED_START = 28 if sys.byteorder == "little" else 31  # the byte that is 0 or 1
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
        self.ray, self.hit = bytearray(_RAY_SIZE), bytearray(_HIT_SIZE)
        _RAY.pack_into(self.ray, 0, _RAY_SIZE, *[0] * 11)
        _HIT.pack_into(self.hit, 0, _HIT_SIZE, inf, 0, 0, NONE, NONE, 0, 0)
        self.ray_pointer = ctypes.byref((ctypes.c_char * _RAY_SIZE).from_buffer(self.ray))
        self.hit_pointer = ctypes.byref((ctypes.c_char * _HIT_SIZE).from_buffer(self.hit))


# As many as there ever were calls at the same time.
_free: list[_Slot] = []


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
                mesh, triangle = id_word(mesh, "skip"), id_word(triangle, "skip")
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
    hit = slot.hit[_OCCLUDED_START] != 0
    _free.append(slot)
    return hit


# ---- a single ray in arrays --------------------------------------------------------------------------------------------

# An mlrt_ray behind its struct_size, with vectors as bytes of arrays; an mlrt_hit as an element of an array: `occluded` is 0 or 1.
_pack_arrays = struct.Struct("=I12s12sffII").pack_into
_FLAGS_START = 4
_GREATEST = float(np.finfo(np.float32).max)
_NUMBERS = (float, int, np.float32, np.float64)
_HIT_TYPE: Any = np.dtype(
    {
        "names": [*HIT_FIELDS, "occluded"],
        "formats": [FLOAT, FLOAT, FLOAT, UINT, UINT, INT, np.bool_],
        "offsets": [4, 8, 12, 16, 20, 24, _OCCLUDED_START],
        "itemsize": _HIT_SIZE,
    }
)

# The shapes that arrays of one vector have, and those of its results.
_SHAPES = {(1,) * axes + (3,): (1,) * axes for axes in range(64)}

_ndarray = np.ndarray


def _one_number(value: Any, shape: tuple[int, ...]) -> Optional[float]:
    """A number that an mlrt_ray can have, of a number or an array of float32 of this shape; None for others."""
    if value.__class__ is _ndarray:
        return value.item() if value.dtype is FLOAT and value.shape == shape else None
    return float(value) if value.__class__ in _NUMBERS and not _GREATEST < abs(value) < inf else None


def _limits(t_min: Any, t_max: Any, skip: Any, shape: tuple[int, ...]) -> Any:
    """Flags, t_min, t_max, and the triangle to skip, of an mlrt_ray; None if these are not of one ray."""
    flags = mesh = triangle = 0
    begin = 0.0 if t_min is None else _one_number(t_min, shape)
    end = inf if t_max is None else _one_number(t_max, shape)
    if begin is None or end is None:
        return None
    if skip is not None:
        if skip.__class__ is not _ndarray or skip.shape != shape + (2,) or skip.dtype.kind not in "iu":
            return None
        flags, (mesh, triangle) = _SKIP, skip.ravel().tolist()
        mesh, triangle = id_word(mesh, "skip"), id_word(triangle, "skip")
    return flags, begin, limit(end), mesh, triangle


def _trace_arrays(handle: Any, origins: Any, directions: Any, t_min: Any, t_max: Any, skip: Any, options: Any) -> Any:
    """Traces the ray of two arrays of float32 with one vector each, of the same shape: an array of an mlrt_hit. None for others."""
    if origins.__class__ is not _ndarray or directions.__class__ is not _ndarray:
        return None
    shape = _SHAPES.get(origins.shape)
    if shape is None or origins.shape != directions.shape or origins.dtype is not FLOAT or directions.dtype is not FLOAT:
        return None
    flags, begin, end, mesh, triangle = 0, 0.0, 0.0, 0, 0
    if t_min is not None or t_max is not None or skip is not None:
        limits = _limits(t_min, t_max, skip, shape)
        if limits is None:
            return None
        flags, begin, end, mesh, triangle = limits
    slot = _slot()
    _pack_arrays(slot.ray, _FLAGS_START, flags, origins.tobytes(), directions.tobytes(), begin, end, mesh, triangle)
    status = _trace(handle, slot.ray_pointer, options, slot.hit_pointer)
    if status:
        check(status)
    hit = _ndarray(shape, _HIT_TYPE, slot.hit[:])
    _free.append(slot)
    return hit


@lru_cache(maxsize=256)
def _wanted(outputs: Any) -> Any:
    """The names of all wanted outputs with their places in Hits."""
    return tuple((HIT_FIELDS.index(name), name) for name in check_names(outputs, HIT_FIELDS))


def closest_in_arrays(
    handle: Any, origins: Any, directions: Any, t_min: Any, t_max: Any, skip: Any, options: Any, outputs: Any
) -> Optional[Hits]:
    """What mlrt_trace_packet answers to one ray, in new arrays; None if these are not arrays of one ray."""
    hit = _trace_arrays(handle, origins, directions, t_min, t_max, skip, options)
    if hit is None:
        return None
    wanted = None if outputs is None else _wanted(outputs if outputs.__class__ is str else tuple(outputs))
    if wanted is None:
        return make_hits(Hits, (hit["t"], hit["u"], hit["v"], hit["mesh"], hit["triangle"], hit["facing"], None))
    arrays: list[Any] = [None] * len(Hits._fields)
    for place, name in wanted:
        arrays[place] = hit[name]
    return make_hits(Hits, arrays)


def occluded_in_array(
    handle: Any, origins: Any, directions: Any, t_min: Any, t_max: Any, skip: Any, options: Any
) -> Optional[np.ndarray]:
    """Likewise of any hit."""
    hit = _trace_arrays(handle, origins, directions, t_min, t_max, skip, options)
    return None if hit is None else hit["occluded"]
