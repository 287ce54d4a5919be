# SPDX-License-Identifier: MIT
"""Arrays of rays as an mlrt_rays."""

from math import prod
from typing import Any, Optional

import numpy as np

from ._abi import NONE, pack_rays
from ._arrays import elements, floats, ids, vectors

_NO_ARRAY = (0, 0)


class Rays:
    """Broadcast arrays of rays: `packed` is the mlrt_rays, valid as long as this lives; `shape` that of the results."""

    __slots__ = ("packed", "shape", "count", "_alive")

    def __init__(
        self,
        origins: Any,
        directions: Any,
        t_min: Any = None,
        t_max: Any = None,
        skip: Any = None,
        row_length: int = 0,
        mask: Optional[np.ndarray] = None,
    ) -> None:
        """mask: uint32, one for each ray."""
        if not 0 <= row_length <= NONE:
            raise ValueError(f"row_length: {row_length} does not fit into 32 bits")
        origins, directions = vectors(origins, "origins"), vectors(directions, "directions")
        t_min = None if t_min is None else floats(t_min)
        t_max = None if t_max is None else floats(t_max)
        skip = None if skip is None else ids(skip, "skip")
        shape = origins.shape[:-1]
        if (
            directions.shape != origins.shape
            or t_min is not None
            or t_max is not None
            or skip is not None
            or mask is not None
        ):
            shape = _common_shape(origins, directions, t_min, t_max, skip, mask)
        self.shape = shape
        self.count = shape[0] if len(shape) == 1 else prod(shape)
        self._alive: list[np.ndarray] = []
        self.packed = pack_rays(
            row_length or _row_length(shape, origins, directions),
            self.count,
            *self._array(origins, 3),
            *self._array(directions, 3),
            *(_NO_ARRAY if t_min is None else self._array(t_min, 1)),
            *(_NO_ARRAY if t_max is None else self._array(t_max, 1)),
            *(_NO_ARRAY if skip is None else self._array(skip, 2)),
            *(_NO_ARRAY if mask is None else self._array(mask, 1)),
        )

    def _array(self, array: np.ndarray, width: int) -> tuple[int, int]:
        """Address and stride."""
        whole = self.shape if width == 1 else self.shape + (width,)
        if array.shape != whole:
            array = np.broadcast_to(array, whole)
        array, where, stride = elements(array, width)
        self._alive.append(array)
        return where, stride


def _common_shape(
    origins: np.ndarray, directions: np.ndarray, t_min: Any, t_max: Any, skip: Any, mask: Any
) -> tuple[int, ...]:
    shapes = [origins.shape[:-1], directions.shape[:-1]]
    shapes += [array.shape for array in (t_min, t_max, mask) if array is not None]
    shapes += [skip.shape[:-1]] if skip is not None else []
    return np.broadcast_shapes(*shapes)


# A flat list is looked at for rows only if it is so long that this takes less than a hundredth of tracing it.
_FLAT_ROWS_COUNT = 1 << 16
_FLAT_ROW_LENGTH = 8192  # the longest row found


def _row_length(shape: tuple[int, ...], origins: np.ndarray, directions: np.ndarray) -> int:
    """Rays of an array with two axes or more come in rows, as pixels do; groups are squares of 4x4 at least.

    Long flat lists of pixels are rows as well, if they look so. Wrong guesses cost time, never answers.
    """
    if len(shape) >= 2:
        return shape[-1] if shape[-1] >= 4 else 0
    if len(shape) == 0 or shape[0] < _FLAT_ROWS_COUNT:
        return 0
    return _period(directions, shape[0]) or _period(origins, shape[0])


def _period(vectors: np.ndarray, count: int) -> int:
    """The distance of the jumps in a list of vectors, if they come at even distances that divide `count`, else 0.

    A jump is a step of more than half of the largest one, which is that from the end of a row to the start of the next.
    """
    if vectors.ndim != 2 or len(vectors) != count:
        return 0
    with np.errstate(all="ignore"):
        steps = np.diff(vectors[: 2 * _FLAT_ROW_LENGTH + 1], axis=0)
        np.abs(steps, out=steps)
        lengths = steps[:, 0] + steps[:, 1]
        lengths += steps[:, 2]
        jumps = np.flatnonzero(lengths > lengths.max() / 2) + 1
    period = int(jumps[0]) if len(jumps) else 0
    if period < 4 or len(jumps) < 2 or count % period:
        return 0
    return period if np.array_equal(jumps, np.arange(period, len(lengths) + 1, period)) else 0
