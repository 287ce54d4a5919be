# SPDX-License-Identifier: MIT
"""Which triangles rays begin on, exactly, for trimesh: both of its ray classes count a hit at t = 0, and libmlrt does not.

A point p lies on a triangle that is not parallel to an axis exactly if two rays along this axis hit it at p: one begins at the
float below p's coordinate, the other at the float above, and both end in p. The distance h to a neighbouring float is a float, so
p is the ray's point at t = h without rounding. A triangle met at t <= h from both sides contains p; one that is met up to h from
one side only lies less than an ulp from p. No triangle is parallel to all three axes.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._tree import Tree
from .typing import Threads

Index = NDArray[np.int64]
Floats = NDArray[np.float32]

_LIST_NUMBERS = 1 << 22  # of all lists that are asked for at once
_SURE = 1e-14  # relative: a sum of products of differences, in float64, has at most a tenth of this error


class Begins(NamedTuple):
    """Rays that begin on a triangle: their numbers, ascending, the first triangle of the mesh that each hits there, and its weights."""

    ray: Index
    triangle: Index
    u: Floats
    v: Floats


def begins(
    tree: Tree, vertices: Floats, faces: NDArray[Any], origins: Floats, directions: Floats, pool: Threads
) -> Begins:
    """vertices, faces: those of the tree."""
    one = len(origins) > 1 and bool((origins == origins[0]).all())
    found = _containing(tree, origins[:1] if one else origins, pool)
    if one and len(found.ray):
        count, size = len(origins), len(found.ray)
        all_of_it: list[Any] = [np.tile(array, count) for array in found[1:]]
        found = Begins(np.repeat(np.arange(count), size), *all_of_it)
    crossing = _crosses(vertices[faces[found.triangle]], directions[found.ray])
    found = Begins._make(array[crossing] for array in found)
    return Begins._make(array[np.unique(found.ray, return_index=True)[1]] for array in found)


def _containing(tree: Tree, points: Floats, pool: Threads) -> Begins:
    """All triangles on which points lie, by point and then by triangle."""
    parts = []
    for axis in range(3):
        below = _towards(points, axis, -1)
        near = np.flatnonzero(tree.occluded(*below, pool=pool))  # of nearly all points this alone says that there is none
        longest = int(_totals(tree, points[near], axis, -1, pool).max(initial=1))
        size = max(_LIST_NUMBERS // longest, 1)
        for start in range(0, len(near), size):
            piece = near[start : start + size]
            lists = [_listed(tree, points[piece], axis, side, pool) for side in (-1, 1)]
            from_below, from_above = (rays * (1 << 32) + triangles for rays, triangles, _, _ in lists)
            which = np.flatnonzero(np.isin(from_below, from_above))
            ray, triangle, u, v = lists[0]
            parts.append(Begins(piece[ray[which]], triangle[which], u[which], v[which]))
    if not parts:
        nothing, no_weights = np.zeros(0, np.int64), np.zeros(0, np.float32)
        return Begins(nothing, nothing, no_weights, no_weights)
    together = Begins._make(np.concatenate(arrays) for arrays in zip(*parts))
    _, which = np.unique(together.ray * (1 << 32) + together.triangle, return_index=True)
    return Begins._make(array[which] for array in together)


def _towards(points: Floats, axis: int, side: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Rays to points from their neighbours below (-1) or above (1): origins, direction, t_min, t_max. None hits behind its point."""
    origins, direction = points.copy(), np.zeros(3, np.float32)
    direction[axis] = -side
    with np.errstate(all="ignore"):
        origins[:, axis] = np.nextafter(points[:, axis], np.float32(np.inf * side))
        t_max = np.abs(points[:, axis] - origins[:, axis])
    return origins, direction, np.nextafter(t_max, np.float32(0)), t_max


def _totals(tree: Tree, points: Floats, axis: int, side: int, pool: Threads) -> NDArray[np.uint32]:
    """How many triangles are met on the way."""
    origins, direction, t_min, t_max = _towards(points, axis, side)
    return tree.hits(origins, direction, 0, t_min, t_max, outputs="total", pool=pool).total


def _listed(tree: Tree, points: Floats, axis: int, side: int, pool: Threads) -> tuple[Index, Index, Floats, Floats]:
    """These triangles: numbers of points and of triangles, and weights."""
    totals = _totals(tree, points, axis, side, pool)
    origins, direction, t_min, t_max = _towards(points, axis, side)
    longest = int(totals.max(initial=1)) or 1
    lists = tree.hits(origins, direction, longest, t_min, t_max, outputs=("triangle", "u", "v"), pool=pool)
    ray, column = np.nonzero(np.arange(longest) < totals[:, None])
    return ray, lists.triangle[ray, column].astype(np.int64), lists.u[ray, column], lists.v[ray, column]


def _crosses(corners: Floats, directions: Floats) -> NDArray[np.bool_]:
    """Whether each direction leads out of the plane of a triangle: d . n is not 0. In integers where float64 cannot tell.

    corners: (n, 3, 3).
    """
    finite = np.isfinite(directions).all(axis=1)
    crosses = np.zeros(len(corners), np.bool_)
    with np.errstate(all="ignore"):
        volume, size = _volume(corners.astype(np.float64), directions.astype(np.float64))
        sure = np.abs(volume) > _SURE * size
    crosses[sure] = True
    unsure = np.flatnonzero(finite & ~sure)
    if len(unsure):
        integers = [_integers(array) for array in (corners[unsure], directions[unsure])]
        crosses[unsure] = _volume(*integers)[0] != 0
    return crosses & finite


def _integers(values: Floats) -> NDArray[Any]:
    """Each float32 times 2^149, which is an integer, as a Python int."""
    scaled = values.astype(np.float64) * 2.0**149
    return np.array([int(number) for number in scaled.flat], object).reshape(values.shape)


def _volume(corners: NDArray[Any], directions: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """d . ((b - a) x (c - a)), and the sum of its terms' sizes."""
    first, second = (corners[:, corner] - corners[:, 0] for corner in (1, 2))
    terms = []
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        terms += [directions[:, x] * first[:, y] * second[:, z], -directions[:, x] * first[:, z] * second[:, y]]
    return sum(terms[1:], terms[0]), sum(map(abs, terms[1:]), abs(terms[0]))
