# SPDX-License-Identifier: MIT
"""Arrays for results: new ones, or the caller's, as an mlrt_hits or an mlrt_hit_lists."""

from collections.abc import Iterable
from math import prod
from typing import Optional

import numpy as np

from ._abi import pack_hit_lists, pack_hits
from ._arrays import address
from ._results import DTYPES, HitLists, Hits

_NO_ARRAY = (0, 0, 0)


def _check_names(outputs: Optional[Iterable[str]], known: tuple[str, ...]) -> tuple[str, ...]:
    if outputs is None:
        return known
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    for name in names:
        if name not in known:
            raise ValueError(f"outputs: {name!r} is none of {', '.join(known)}")
    return names


def new_hits(outputs: Optional[Iterable[str]], shape: tuple[int, ...]) -> tuple[Hits, bytes]:
    """The arrays named in `outputs` (None = all), which share one block of memory, and the mlrt_hits of them."""
    names = _check_names(outputs, Hits._fields)
    block = np.empty((len(names),) + shape, np.float32)
    as_type = {np.float32: block, np.uint32: block.view(np.uint32), np.int32: block.view(np.int32)}
    start, size = address(block), 4 * prod(shape)
    arrays, fields = {}, {}
    for row, name in enumerate(names):
        arrays[name] = as_type[DTYPES[name].type][row, ...]
        fields[name] = start + row * size
    data = [fields.get(name, 0) for name in Hits._fields]
    packed = pack_hits(0, data[0], 0, 0, data[1], 0, 0, data[2], 0, 0, data[3], 0, 0, data[4], 0, 0, data[5], 0, 0, 0, 0, 0)
    return Hits(**arrays), packed


def _caller_array(array: np.ndarray, name: str, dtypes: tuple[np.dtype, ...], shape: tuple[int, ...]) -> tuple[int, int, int]:
    """Address, stride and row stride of an array that the caller wants results in."""
    if not isinstance(array, np.ndarray) or array.dtype not in dtypes or array.shape != shape:
        raise ValueError(f"out: {name} must be an array of {dtypes[0]} and shape {shape}")
    if not array.flags.writeable:
        raise ValueError(f"out: {name} is read-only")
    if array.flags.c_contiguous and array.flags.aligned:
        return address(array), 0, 0
    strides = array.strides
    if len(shape) > 2 or min(strides) <= 0 or any(stride % array.itemsize for stride in strides) or not array.flags.aligned:
        raise ValueError(f"out: {name} must be contiguous, or have one or two axes with positive strides")
    return address(array), strides[-1], strides[0] if len(strides) == 2 else 0


def given_hits(out: Hits, shape: tuple[int, ...], rows: bool) -> bytes:
    """The mlrt_hits of the caller's arrays. `rows`: arrays of two axes may have a stride of their own for rows."""
    fields = []
    for name, array in zip(Hits._fields, out):
        field = _NO_ARRAY if array is None else _caller_array(array, name, (DTYPES[name],), shape)
        if field[2] and not rows:
            raise ValueError(f"out: {name} must be contiguous, or have one axis")
        fields += field
    return pack_hits(0, *fields, *_NO_ARRAY)


def occluded(out: Optional[np.ndarray], shape: tuple[int, ...]) -> tuple[np.ndarray, bytes]:
    """An array of bool, `out` if it is given, and the mlrt_hits with nothing but it."""
    array = np.empty(shape, np.bool_) if out is None else out
    field = _caller_array(array, "occluded", (np.dtype(np.bool_), np.dtype(np.uint8)), shape)
    if field[2]:
        raise ValueError("out: must be contiguous, or have one axis")
    return array, pack_hits(0, *_NO_ARRAY * 6, *field)


def new_hit_lists(outputs: Optional[Iterable[str]], shape: tuple[int, ...], k: int) -> tuple[HitLists, bytes]:
    """The arrays named in `outputs` (None = all) for k hits per ray, and the mlrt_hit_lists of them."""
    totals = ("total", "crossing_total")
    names = _check_names(outputs, HitLists._fields)
    arrays, fields = {}, []
    for name in HitLists._fields:
        if name in names and (k > 0 or name in totals):
            arrays[name] = np.empty(shape if name in totals else shape + (k,), DTYPES[name])
            fields += (address(arrays[name]), 0, 0)
        else:
            fields += _NO_ARRAY
    return HitLists(**arrays), pack_hit_lists(k, *fields)
