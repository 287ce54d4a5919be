# SPDX-License-Identifier: MIT
"""Bars of tqdm for calls that take long, when asked for; tqdm is imported only then."""

import ctypes
from collections.abc import Iterator
from types import TracebackType
from typing import Any, Optional

import numpy as np

from . import _abi

# Rays traced between two moves of the bar, or somewhat more: so many that pieces cost nothing. All threads share a piece.
PIECE_RAYS = 1 << 18
SHARED_PIECE_RAYS = 1 << 20

# Squares of pixels that rays are grouped in have at most so many rows, and no piece ends within one.
_SQUARE_ROWS = 64


def wants_bar(progress: bool) -> bool:
    """The argument `progress`. A function in its place is an error, since it would never be called."""
    if not isinstance(progress, (bool, np.bool_)):
        raise TypeError(f"progress: True or False, not {type(progress).__name__}")
    return bool(progress)


class Bar:
    """A bar that counts up to `total`, in a `with` statement."""

    def __init__(self, total: int, unit: str) -> None:
        try:
            from tqdm.auto import tqdm  # type: ignore[import-untyped, unused-ignore]
        except ImportError as error:
            raise ImportError("progress=True needs tqdm: pip install tqdm") from error
        self._bar: Any = tqdm(total=total, unit=unit, unit_scale=True)

    def add(self, count: int) -> None:
        self._bar.update(count)

    def __enter__(self) -> "Bar":
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self._bar.close()


def pieces(rays: bytes, results: bytes, kind: type[_abi.Struct], shared: bool) -> Iterator[tuple[int, bytes, bytes]]:
    """An mlrt_rays and the struct of results that belongs to it, cut into pieces: (count, rays, results) of each."""
    whole = _abi.Rays.from_buffer_copy(rays)
    group = whole.rays_per_origin
    row = group if group > 1 else whole.row_length * _SQUARE_ROWS or 1
    size = -(-(SHARED_PIECE_RAYS if shared else PIECE_RAYS) // row) * row
    for start in range(0, whole.count, size):
        part, part_results = _abi.Rays.from_buffer_copy(rays), kind.from_buffer_copy(results)
        part.count = min(size, whole.count - start)
        for name in ("origins", "t_min", "skip"):
            _advance(part, name, start // max(group, 1))
        for name in ("directions", "t_max", "mask"):
            _advance(part, name, start)
        for name, kind_of_field in ((field[0], field[1]) for field in part_results._fields_):
            if kind_of_field is _abi.Array:
                per_ray = 1 if name in ("total", "crossing_total") else getattr(part_results, "capacity", 1)
                _advance(part_results, name, start * per_ray)
        yield part.count, bytes(part), bytes(part_results)


def _advance(struct: Any, name: str, elements: int) -> None:
    """Lets an array begin so many elements later."""
    array = getattr(struct, name)
    if array.data and array.stride != _abi.STRIDE_ALL:
        array.data += elements * (array.stride or _abi.ELEMENT_SIZES[name])
