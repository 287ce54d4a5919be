# SPDX-License-Identifier: MIT
"""Arrays for results: new ones, or the caller's, as an mlrt_hits or an mlrt_hit_lists."""

from collections.abc import Iterable
from functools import lru_cache
from math import prod
from typing import Any, Optional

import numpy as np

from ._abi import pack_hit_lists, pack_hits, pack_plain_hits
from ._arrays import FLOAT, INT, UINT, address, packed_address
from .typing import Outputs
from ._results import DTYPES, HIT_FIELDS, HitLists, Hits, check_names, make_hits

_NO_ARRAY = (0, 0, 0)

Placed = tuple[int, np.ndarray]  # with its address

_TYPES = (FLOAT, UINT, INT)
_DTYPES_OF_HITS = tuple((DTYPES[name],) for name in Hits._fields)


@lru_cache(maxsize=256)
def _rows(names: Optional[tuple[str, ...]], lights: bool) -> tuple[int, tuple[tuple[int, int], ...], bool]:
    """How many rows a block of results has, for each field of Hits but `occluded` its row and the number of its type (-1 = none),
    and whether `occluded` is wanted.
    """
    known = check_names(names, Hits._fields if lights else HIT_FIELDS)
    names = tuple(name for name in known if name != "occluded")
    rows = [(names.index(name) if name in names else -1, _TYPES.index(DTYPES[name])) for name in HIT_FIELDS]
    return len(names), tuple(rows), "occluded" in known


def new_hits(outputs: Outputs, shape: tuple[int, ...], lights: Optional[int] = None) -> tuple[Hits, bytes]:
    """The arrays named in `outputs` (None = all), which share one block of memory but for `occluded`, and the mlrt_hits of them.

    lights: how many there are; without them (None) there is no `occluded`.
    """
    names = (outputs,) if isinstance(outputs, str) else outputs if outputs is None else tuple(outputs)
    count, rows, shadows = _rows(names, lights is not None)
    block = np.empty((count, *shape), FLOAT)
    views = block, block.view(UINT), block.view(INT)
    start, size = address(block), 4 * prod(shape)
    arrays: list[Any] = [None if row < 0 else views[kind][row, ...] for row, kind in rows]
    starts = [0 if row < 0 else start + row * size for row, _ in rows]
    bits = np.zeros(shape, np.uint8) if shadows else None
    occluded = address(bits) if bits is not None and lights else 0
    arrays.append(bits)
    return make_hits(Hits, arrays), pack_plain_hits(0, *starts, occluded)


def _caller_array(array: np.ndarray, name: str, dtypes: tuple[np.dtype, ...], shape: tuple[int, ...]) -> tuple[int, int, int]:
    """Address, stride and row stride of an array that the caller wants results in."""
    if array.__class__ is np.ndarray and array.dtype in dtypes and array.shape == shape:
        start = packed_address(array)
        if start and start % array.itemsize == 0:
            return start, 0, 0
    if not isinstance(array, np.ndarray) or array.dtype not in dtypes or array.shape != shape:
        raise ValueError(f"out: {name} must be an array of {dtypes[0]} and shape {shape}")
    if not array.flags.writeable:
        raise ValueError(f"out: {name} is read-only")
    if array.flags.c_contiguous and array.flags.aligned:
        return address(array), 0, 0
    strides = array.strides
    if not 1 <= len(shape) <= 2 or min(strides) <= 0 or any(stride % array.itemsize for stride in strides) or not array.flags.aligned:
        raise ValueError(f"out: {name} must be contiguous, or have one or two axes with positive strides")
    if len(shape) == 2:
        (step, count), (leap, _) = sorted(zip(strides, shape))
        if leap < step * count:
            raise ValueError(f"out: {name} has elements that share memory")
    return address(array), strides[-1], strides[0] if len(strides) == 2 else 0


def given_hits(
    out: Hits, shape: tuple[int, ...], rows: bool, lights: Optional[int] = None, read: Iterable[Placed] = ()
) -> bytes:
    """The mlrt_hits of the caller's arrays. `rows`: arrays of two axes may have a stride of their own for rows.

    lights: how many there are; without them (None) there is no `occluded`. read: arrays that are read meanwhile.
    """
    if not isinstance(out, Hits):
        raise TypeError(f"out: a mlrt.Hits is needed, not {type(out).__name__}")
    if out.occluded is not None and lights is None:
        raise ValueError("out: occluded is for pictures with lights")
    fields: list[int] = []
    written: list[Placed] = []
    arrays: tuple[Optional[np.ndarray], ...] = out
    for array, name, dtypes in zip(arrays, Hits._fields, _DTYPES_OF_HITS):
        if array is None:
            fields += _NO_ARRAY
            continue
        field = _caller_array(array, name, dtypes, shape)
        if field[2] and not rows:
            raise ValueError(f"out: {name} must be contiguous, or have one axis")
        fields += field
        written.append((field[0], array))
    if _may_overlap(written, read):
        _check_apart({name: array for name, array in zip(Hits._fields, arrays) if array is not None}, read)
    if out.occluded is not None and not lights:
        out.occluded[...] = 0
        fields[-3:] = _NO_ARRAY
    return pack_hits(0, *fields)


def _may_overlap(written: list[Placed], read: Iterable[Placed]) -> bool:
    """Does an array begin before another one ends that begins before it? They may have no elements in common even so."""
    end = 0
    for start, last in sorted([(start, start + _extent(array)) for start, array in [*written, *read]]):
        if start < end:
            return True
        end = last
    return False


def _check_apart(written: dict[str, np.ndarray], read: Iterable[Placed]) -> None:
    """Refuses arrays that results cannot be written to one by one, while `read` is read."""
    names = list(written)
    for place, name in enumerate(names):
        for other in names[place + 1 :]:
            if np.shares_memory(written[name], written[other]):
                raise ValueError(f"out: {name} and {other} share memory")
        if any(np.shares_memory(written[name], array) for _, array in read):
            raise ValueError(f"out: {name} shares memory with the rays")


def _extent(array: np.ndarray) -> int:
    """Bytes from the beginning of the first element to the end of the last one; strides are not negative."""
    if array.flags.c_contiguous:
        return array.nbytes
    return sum((count - 1) * stride for count, stride in zip(array.shape, array.strides)) + array.itemsize


def occluded(
    out: Optional[np.ndarray], shape: tuple[int, ...], read: Iterable[Placed] = ()
) -> tuple[np.ndarray, bytes]:
    """An array of bool, `out` if it is given, and the mlrt_hits with nothing but it. read: as above."""
    array = np.empty(shape, np.bool_) if out is None else out
    field = _caller_array(array, "occluded", (np.dtype(np.bool_), np.dtype(np.uint8)), shape)
    if field[2]:
        raise ValueError("out: must be contiguous, or have one axis")
    if out is not None and _may_overlap([(field[0], out)], read):
        _check_apart({"occluded": out}, read)
    return array, pack_hits(0, *_NO_ARRAY * 6, *field)


def new_hit_lists(outputs: Outputs, shape: tuple[int, ...], k: int) -> tuple[HitLists, bytes]:
    """The arrays named in `outputs` (None = all) for k hits per ray, and the mlrt_hit_lists of them."""
    totals = ("total", "crossing_total")
    names = check_names(outputs, HitLists._fields)
    arrays: dict[str, np.ndarray] = {}
    fields: list[int] = []
    for name in HitLists._fields:
        if name in names and (k > 0 or name in totals):
            arrays[name] = np.empty(shape if name in totals else shape + (k,), DTYPES[name])
            fields += (address(arrays[name]), 0, 0)
        else:
            fields += _NO_ARRAY
    return HitLists(**arrays), pack_hit_lists(k, *fields)
