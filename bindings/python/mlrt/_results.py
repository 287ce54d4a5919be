# SPDX-License-Identifier: MIT
"""What tracing returns: arrays of hits, one entry per ray, and lists of hits, several entries per ray."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._abi import LIGHT_LIMIT, NONE

# An array that was not asked for. Whoever asked for it need not tell a type checker that it is there.
_ABSENT: Any = None


class Hits(NamedTuple):
    """The closest hits of rays. All arrays have the rays' shape; one that was not asked for is None."""

    t: NDArray[np.float32] = _ABSENT  #: distance in units of the direction's length, rounded; inf = miss, or beyond the range of float
    u: NDArray[np.float32] = _ABSENT  #: weight of the triangle's second vertex
    v: NDArray[np.float32] = _ABSENT  #: weight of its third
    mesh: NDArray[np.uint32] = _ABSENT  #: id of the mesh; mlrt.NONE = miss
    triangle: NDArray[np.uint32] = _ABSENT  #: number of the triangle in its mesh; mlrt.NONE = miss
    facing: NDArray[np.int32] = _ABSENT  #: +1: the ray travels along the normal, -1: against it, 0 = miss
    occluded: NDArray[np.uint8] = _ABSENT  #: of Tree.render with lights: bit k = light k does not reach the hit; 0 = miss

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Which rays hit something. Needs any of triangle, mesh, facing, t; by t alone, a hit whose t rounds to inf is a miss."""
        for array, miss in ((self.triangle, NONE), (self.mesh, NONE), (self.facing, 0), (self.t, np.inf)):
            if array is not None:
                hit: NDArray[np.bool_] = array != miss
                return hit
        raise ValueError("none of triangle, mesh, facing and t was asked for")

    def shadow(self, light: int) -> NDArray[np.bool_]:
        """Which hits light number `light` does not reach: that bit of `occluded`. A miss has no shadow."""
        if not 0 <= light < LIGHT_LIMIT:
            raise IndexError(f"light: {light} is not in 0..{LIGHT_LIMIT - 1}")
        if self.occluded is None:
            raise ValueError("occluded was not asked for")
        shadow: NDArray[np.bool_] = self.occluded & (1 << light) != 0
        return shadow


class HitLists(NamedTuple):
    """All hits of rays, nearest first. Arrays of hits have the rays' shape and one more axis, of length k.

    Entries behind a ray's last hit are misses. An array that was not asked for is None, as are all arrays of hits if k is 0.
    """

    t: NDArray[np.float32] = _ABSENT
    u: NDArray[np.float32] = _ABSENT
    v: NDArray[np.float32] = _ABSENT
    mesh: NDArray[np.uint32] = _ABSENT
    triangle: NDArray[np.uint32] = _ABSENT
    facing: NDArray[np.int32] = _ABSENT
    crossing: NDArray[np.bool_] = _ABSENT  #: does this hit cross the surface (True) or only touch it?
    total: NDArray[np.uint32] = _ABSENT  #: per ray: how many hits it has, also beyond k
    crossing_total: NDArray[np.uint32] = _ABSENT  #: per ray: how many of these cross


DTYPES: dict[str, np.dtype[Any]] = {
    "t": np.dtype(np.float32),
    "u": np.dtype(np.float32),
    "v": np.dtype(np.float32),
    "mesh": np.dtype(np.uint32),
    "triangle": np.dtype(np.uint32),
    "facing": np.dtype(np.int32),
    "occluded": np.dtype(np.uint8),
    "crossing": np.dtype(np.bool_),
    "total": np.dtype(np.uint32),
    "crossing_total": np.dtype(np.uint32),
}
