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

_LIST_NUMBERS = 1 << 20  # of all lists that are asked for at once
_FEW_POINTS = 64  # so many times as many vertices are not worth to be looked through
_SURE = 1e-14  # relative: a sum of products of differences, in float64, has at most a tenth of this error


class Begins(NamedTuple):
    """Rays that begin on a triangle: their numbers, ascending, the triangle that each hits there, and its weights.

    Of several it is the first of the mesh, or, if rays from many corners of the mesh come together, the first that has this corner.
    """

    ray: Index
    triangle: Index
    u: Floats
    v: Floats


def begins(
    tree: Tree, vertices: Floats, faces: NDArray[Any], origins: Floats, directions: Floats, pool: Threads
) -> Begins:
    """vertices, faces: those of the tree."""
    words = np.ascontiguousarray(origins).view(np.uint32).ravel()
    one = len(origins) > 1 and np.array_equal(words[:3], words[-3:]) and np.array_equal(words[3:], words[:-3])
    if one and len(_near(tree, origins[:1], pool)) == 0:
        nothing, no_weights = np.zeros(0, np.int64), np.zeros(0, np.float32)
        return Begins(nothing, nothing, no_weights, no_weights)
    if one:
        near = np.arange(len(origins))
        which, points = np.zeros(len(origins), np.int64), origins[:1]
    else:
        near = _near(tree, origins, pool)
        which, points = _different(origins[near])
    if len(points) * _FEW_POINTS < len(vertices):
        return _first_crossed(vertices, faces, directions, near, which, _containing(tree, points, pool))
    corners = _first_crossed(vertices, faces, directions, near, which, _corners(vertices, faces, points))
    # A point where a ray crosses no triangle that has it as a corner may lie within others.
    left = np.flatnonzero(~np.isin(near, corners.ray))
    rest, which = np.unique(which[left], return_inverse=True)
    inner = _first_crossed(vertices, faces, directions, near[left], which.ravel(), _containing(tree, points[rest], pool))
    order = np.argsort(np.concatenate((corners.ray, inner.ray)))
    pairs: Any = zip(corners, inner)
    return Begins._make(np.concatenate(pair)[order] for pair in pairs)


def _first_crossed(
    vertices: Floats, faces: NDArray[Any], directions: Floats, rays: Index, which: Index, found: Begins
) -> Begins:
    """Of the triangles at the points of rays the first that each crosses. which: the point of each ray; found: by point."""
    point, triangle, u, v = found
    counts = np.bincount(point, minlength=int(which.max(initial=-1)) + 1)
    starts, sizes = np.cumsum(counts) - counts, counts[which]
    ray = np.repeat(rays, sizes)
    index = np.repeat(starts[which] - (np.cumsum(sizes) - sizes), sizes) + np.arange(len(ray))
    crosses = _crosses(vertices[faces[triangle[index]]], directions[ray])
    ray, index = ray[crosses], index[crosses]
    first = np.ones(len(ray), np.bool_)
    first[1:] = ray[1:] != ray[:-1]
    index = index[first]
    return Begins(ray[first], triangle[index], u[index], v[index])


def _near(tree: Tree, points: Floats, pool: Threads) -> Index:
    """The numbers of all points that lie on triangles, and of some others that lie near one. Of most points this says enough."""
    near = np.zeros(len(points), np.bool_)
    for axis in range(3):
        near |= tree.occluded(*_towards(points, axis, -1), pool=pool)
    return np.flatnonzero(near)


def _different(points: Floats) -> tuple[Index, Floats]:
    """Which of the different points each point is, and these. -0 is not 0 here."""
    rows = np.ascontiguousarray(points).view(np.dtype((np.void, 12))).ravel()
    _, first, which = np.unique(rows, return_index=True, return_inverse=True)
    return which.ravel(), points[first]


def _corners(vertices: Floats, faces: NDArray[Any], points: Floats) -> Begins:
    """The triangles whose corners are points, by point and then by triangle: far faster than `_containing`."""
    number, _ = _different(np.concatenate((points, vertices)) + np.float32(0))  # -0 becomes 0
    point_of = np.full(len(number), -1)
    point_of[number[: len(points)]] = np.arange(len(points))
    corners = point_of[number[len(points) :]][faces]
    triangle, corner = np.nonzero(corners >= 0)
    point = corners[triangle, corner]
    order = np.argsort(point, kind="stable")
    triangle, corner = triangle[order], corner[order]
    return Begins(point[order], triangle, (corner == 1).astype(np.float32), (corner == 2).astype(np.float32))


def _containing(tree: Tree, points: Floats, pool: Threads) -> Begins:
    """All triangles on which points lie, by point and then by triangle."""
    nothing, no_weights = np.zeros(0, np.int64), np.zeros(0, np.float32)
    parts = [Begins(nothing, nothing, no_weights, no_weights)]
    for axis in range(3):
        totals = _totals(tree, points, axis, -1, pool)
        order = np.argsort(totals, kind="stable")  # so that lists of one piece are about equally long
        start = int(np.count_nonzero(totals == 0))
        while start < len(order):
            stop = start + max(int(np.count_nonzero(_sizes(totals[order[start:]]) <= _LIST_NUMBERS)), 1)
            piece, start = order[start:stop], stop
            (ray, triangle, u, v), above = (_listed(tree, points[piece], axis, side, pool) for side in (-1, 1))
            on = np.isin(ray * (1 << 32) + triangle, above[0] * (1 << 32) + above[1])
            parts.append(Begins(piece[ray[on]], triangle[on], u[on], v[on]))
    point, triangle, u, v = (np.concatenate(arrays) for arrays in zip(*parts))
    _, which = np.unique(point * (1 << 32) + triangle, return_index=True)
    return Begins(point[which], triangle[which], u[which], v[which])


def _sizes(totals: NDArray[np.uint32]) -> Index:
    """How many numbers the lists of the first one, two, three, ... points have, if all are as long as the last of them."""
    return np.arange(1, len(totals) + 1) * totals.astype(np.int64)


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
    longest = max(int(totals.max(initial=0)), 1)
    lists = tree.hits(origins, direction, longest, t_min, t_max, outputs=("triangle", "u", "v"), pool=pool)
    ray, column = np.nonzero(np.arange(longest) < totals[:, None])
    return ray, lists.triangle[ray, column].astype(np.int64), lists.u[ray, column], lists.v[ray, column]


def _crosses(corners: Floats, directions: Floats) -> NDArray[np.bool_]:
    """Whether each direction leads out of the plane of a triangle: d . n is not 0. In integers where float64 cannot tell.

    corners: (n, 3, 3).
    """
    finite = np.isfinite(directions).all(axis=1) & np.isfinite(corners).all(axis=(1, 2))
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
    terms: list[Any] = []
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        terms += [directions[:, x] * first[:, y] * second[:, z], -directions[:, x] * first[:, z] * second[:, y]]
    volume: Any = sum(terms[1:], terms[0])
    size: Any = sum(map(abs, terms[1:]), abs(terms[0]))
    return volume, size
