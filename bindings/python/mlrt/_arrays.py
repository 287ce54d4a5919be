# SPDX-License-Identifier: MIT
"""numpy arrays as pointers and byte strides: passed as they are where the library can read them, else copied once."""

import ctypes
from operator import index
from typing import Any, Optional

import numpy as np

from ._abi import NONE

FLOAT = np.dtype(np.float32)
UINT = np.dtype(np.uint32)
INT = np.dtype(np.int32)

_from_buffer: Any = ctypes.c_char.from_buffer
_addressof = ctypes.addressof


def named(value: Any, names: dict[Any, int], what: str) -> int:
    """The number of a name."""
    try:
        return names[value]
    except (KeyError, TypeError):
        raise ValueError(f"{what}: {value!r} is none of {', '.join(map(repr, names))}") from None


def packed_address(array: np.ndarray) -> int:
    """Where an array's first element lies; 0 if the array is read-only or empty, or has strides. Takes 0.25 us."""
    try:
        start: int = _addressof(_from_buffer(array))
        return start
    except (TypeError, ValueError):
        return 0


def address(array: np.ndarray) -> int:
    """Where an array's first element lies. `__array_interface__` takes 1.7 us."""
    start: int = packed_address(array) or array.__array_interface__["data"][0]
    return start


def floats(values: Any) -> np.ndarray:
    """`values` as float32: itself if it is, else a copy, rounded to nearest."""
    if values.__class__ is np.ndarray and values.dtype is FLOAT:
        return values
    return np.asarray(_whole(values), FLOAT)


def _whole(values: Any) -> Any:
    """`values`, if none of them is masked: numpy would take what lies below the mask."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise ValueError("an array has masked elements: fill them, with NaN for example")
    return values


def vectors(values: Any, name: str) -> np.ndarray:
    """`values` as float32 of shape (..., 3)."""
    array = floats(values)
    shape = array.shape
    if not shape or shape[-1] != 3:
        raise ValueError(f"{name}: the shape must be (..., 3), not {shape}")
    return array


def ids(values: Any, name: str) -> np.ndarray:
    """`values` as uint32 of shape (..., 2): mesh and triangle. -1 becomes mlrt.NONE."""
    array = np.asarray(_whole(values))
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name}: integers are needed, not {array.dtype}")
    if array.ndim == 0 or array.shape[-1] != 2:
        raise ValueError(f"{name}: the shape must be (..., 2), not {array.shape}")
    if array.dtype != UINT and array.size:
        for extreme in (array.min(), array.max()):
            id_word(extreme, name)
    return array.astype(UINT, copy=False)


def id_word(value: Any, name: str) -> int:
    """An id of a mesh or a number of a triangle as 32 bits, of which -1 becomes mlrt.NONE."""
    number = index(value)
    if not -1 <= number <= NONE:
        raise ValueError(f"{name}: {number} does not fit into 32 bits")
    return number & NONE


def mask_word(value: Any, name: str) -> int:
    """A mask as 32 bits. Negative numbers are taken as C does, so that ~3 is all bits but two."""
    number = index(value)
    if not -(1 << 31) <= number < 1 << 32:
        raise ValueError(f"{name}: {number} does not fit into 32 bits")
    return number & NONE


def mask_words(values: Any) -> tuple[int, Optional[np.ndarray]]:
    """One mask for all rays, or 0 and an array of uint32, one for each."""
    if values.__class__ is int:
        return mask_word(values, "mask"), None
    array = np.asarray(_whole(values))
    if array.dtype.kind not in "iu":
        raise TypeError(f"mask: integers are needed, not {array.dtype}")
    if array.ndim == 0:
        return mask_word(array[()], "mask"), None
    if array.itemsize > 4 and array.size:
        for extreme in (array.min(), array.max()):
            mask_word(extreme, "mask")
    return 0, array.astype(UINT, copy=False)


def elements(array: np.ndarray, width: int) -> tuple[np.ndarray, int, int]:
    """An array of elements `width` numbers long, as (array to keep alive, address, byte stride).

    It is passed through if it is packed, or if one positive stride, a multiple of the item size, leads from each element
    to the next and the numbers of an element are packed. Anything else is copied.
    """
    flags = array.flags
    if flags.c_contiguous and flags.aligned:
        return array, address(array), 0
    rows = array.reshape(-1, width)
    row_stride, stride = rows.strides
    size = rows.itemsize
    if not (row_stride > 0 and row_stride % size == 0 and (width == 1 or stride == size) and rows.flags.aligned):
        rows = np.array(rows, order="C")
    return rows, address(rows[0] if len(rows) else rows), rows.strides[0]


def faces(values: Any) -> np.ndarray:
    """`values` as uint16 or uint32 of shape (n, 3), rows passed through or copied as in `elements`.

    Indices that do not fit into 32 bits, negative ones included, become 0xFFFFFFFF, which no vertex has.
    """
    array = np.asarray(_whole(values))
    if array.dtype.kind not in "iu":
        raise TypeError(f"faces: integers are needed, not {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces: the shape must be (n, 3), not {array.shape}")
    if not array.dtype.isnative or array.dtype not in (np.uint16, np.uint32, np.int32):
        array = np.minimum(array.astype(np.int64).view(np.uint64), 0xFFFFFFFF).astype(UINT)
    return array.view(UINT) if array.dtype == np.int32 else array
