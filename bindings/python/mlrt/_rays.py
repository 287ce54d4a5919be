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
            # Rays of an array with two axes or more come in rows, as pixels do. Of a list, the library finds them.
            row_length or (shape[-1] if len(shape) >= 2 and shape[-1] >= 4 else 0),
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
