# SPDX-License-Identifier: MIT
"""Arrays of rays as an mlrt_rays."""

from math import prod
from typing import Any, Optional

import numpy as np

from ._abi import STRIDE_ALL, pack_rays
from ._arrays import address, elements, floats, ids, vectors
from ._errors import TooLargeError
from ._meshes import in_32_bits

_NO_ARRAY = (0, 0)
_MOST_RAYS = 2**31 - 1  # of a call: checked before memory for results is asked for


class Rays:
    """Broadcast arrays of rays: `packed` is the mlrt_rays, valid as long as this lives; `shape` that of the results; `arrays`
    are those that the library reads, each with its address.

    What is broadcast is not copied, if the library can do without: an array of one element, or origins, t_min and skip that
    are the same along the last axes.
    """

    __slots__ = ("packed", "shape", "count", "arrays")

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
        row_length = in_32_bits(row_length, "row_length") if row_length else 0
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
        self.count = prod(shape)
        if self.count > _MOST_RAYS:
            raise TooLargeError(f"rays: {self.count} is more than {_MOST_RAYS}")
        self.arrays: list[tuple[int, np.ndarray]] = []
        axes = self._group_axes(((origins, 3), (t_min, 1), (skip, 2)))
        self.packed = pack_rays(
            # Rays of an array with two axes or more come in rows, as pixels do. Of a list, the library finds them.
            row_length or (shape[-1] if len(shape) >= 2 and shape[-1] >= 4 else 0),
            self.count,
            *self._array(origins, 3, axes),
            *self._array(directions, 3, 0),
            *(_NO_ARRAY if t_min is None else self._array(t_min, 1, axes)),
            *(_NO_ARRAY if t_max is None else self._array(t_max, 1, 0)),
            *(_NO_ARRAY if skip is None else self._array(skip, 2, axes)),
            *(_NO_ARRAY if mask is None else self._array(mask, 1, 0)),
            prod(shape[len(shape) - axes :]) if axes else 1,
            0,
        )

    def _group_axes(self, arrays: tuple[tuple[Optional[np.ndarray], int], ...]) -> int:
        """How many of the last axes have rays_per_origin rays: all arrays have one element for them, or for all rays."""
        axes = len(self.shape)
        for array, width in arrays:
            if array is None:
                continue
            if array.size == self.count * width and array.flags.c_contiguous:
                return 0
            constant = _constant_axes(array, width)
            if constant is not None:
                axes = min(axes, constant)
        return axes if axes < len(self.shape) and self.count else 0

    def _array(self, array: np.ndarray, width: int, group_axes: int) -> tuple[int, int]:
        """Address and stride: of the elements for each ray, for each group of rays in the last axes, or for all."""
        if array.size != self.count * width or not array.flags.c_contiguous:
            whole = self.shape if width == 1 else self.shape + (width,)
            if _constant_axes(array, width) is None:
                array = np.require(array[_first(array, width, array.ndim)], requirements=("C", "A"))
                where = address(array)
                self.arrays.append((where, array))
                return where, STRIDE_ALL
            if group_axes:
                array = array[_first(array, width, group_axes)]
                whole = self.shape[:-group_axes] + whole[len(self.shape) :]
            if array.shape != whole:
                array = np.broadcast_to(array, whole)
        array, where, stride = elements(array, width)
        self.arrays.append((where, array))
        return where, stride


def _axes(array: np.ndarray, width: int) -> int:
    """How many axes an array has, but that of the numbers of an element."""
    return array.ndim - (width > 1)


def _constant_axes(array: np.ndarray, width: int) -> Optional[int]:
    """Over how many of its last axes an array is the same; None = over all of them."""
    count = _axes(array, width)
    for axis in range(count):
        if array.shape[count - 1 - axis] > 1 and array.strides[count - 1 - axis]:
            return axis
    return None


def _first(array: np.ndarray, width: int, axes: int) -> Any:
    """An index that takes the first of everything along the last axes of an array: so many of them, if it has them."""
    count = _axes(array, width)
    kept = max(count - axes, 0)
    return (slice(None),) * kept + (0,) * (count - kept) + (Ellipsis,)


def _common_shape(
    origins: np.ndarray, directions: np.ndarray, t_min: Any, t_max: Any, skip: Any, mask: Any
) -> tuple[int, ...]:
    shapes = [origins.shape[:-1], directions.shape[:-1]]
    shapes += [array.shape for array in (t_min, t_max, mask) if array is not None]
    shapes += [skip.shape[:-1]] if skip is not None else []
    if shapes.count(shapes[0]) == len(shapes):  # broadcast_shapes takes 1.7 us
        return shapes[0]
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        raise ValueError(_misfit(origins=origins, directions=directions, t_min=t_min, t_max=t_max, skip=skip, mask=mask)) from None


def _misfit(**arrays: Any) -> str:
    """What does not fit what: the first two arrays whose counts differ, in the words of whoever gave them."""
    counts: dict[int, tuple[str, int]] = {}
    shapes = {name: array.shape for name, array in arrays.items() if array is not None}
    for name, shape in shapes.items():
        for back, count in enumerate(reversed(shape[:-1] if name in ("origins", "directions", "skip") else shape), 1):
            if count == 1:
                continue
            other, other_count = counts.setdefault(back, (name, count))
            if count != other_count:
                axis = "" if max(map(len, shapes.values())) <= 2 else f" along the axis of rays number -{back}"
                given = ", ".join(f"{one} {shape}" for one, shape in shapes.items())
                return f"{name}: {count} are given, but {other_count} {other}{axis}; the shapes are {given}"
    return "shapes of rays do not fit each other"
