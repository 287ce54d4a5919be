# SPDX-License-Identifier: MIT
"""Every place where rays meet a mesh, one entry per place, for trimesh.

Place after place: all rays together are traced again from behind the triangle they hit, which they skip. That is faster than
lists of hits, as long as many rays go together. Few rays, and those that hit another triangle at the same t, get lists.
"""

from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from ._pool import Pool
from ._results import Hits
from ._tree import Tree

Index = NDArray[np.int64]

_FEW = 512  # rays that are not worth a pass of their own
_FIRST_CAPACITY = 8  # of a list, and how much longer it gets for rays that need more
_GROWTH = 4
_NO_LIMIT = 1 << 62
_NO_FLOATS = np.zeros(0, np.float32)


class Places(NamedTuple):
    """Where rays hit: arrays with an element per place, by ray and then by distance. t, u, v are empty if not asked for."""

    ray: Index
    triangle: Index
    t: NDArray[np.float32]
    u: NDArray[np.float32]
    v: NDArray[np.float32]


class _Rays(NamedTuple):
    """Rays under way: the places up to t_min, on the triangles in `skip`, are known. None = there are none yet."""

    number: Index
    origins: NDArray[np.float32]
    directions: NDArray[np.float32]
    t_min: Optional[NDArray[np.float32]]
    skip: Optional[NDArray[np.uint32]]

    def take(self, which: Index) -> "_Rays":
        return _Rays._make(None if array is None else array.take(which, axis=0) for array in self)


class _Collector:
    """Takes places in any order, each with its rank among those of its ray."""

    def __init__(self, ray_count: int, weights: bool) -> None:
        self.weights = weights
        self._parts: list[tuple[Index, Any, list[Any]]] = []
        self._counts = np.zeros(ray_count + 1, np.int64)

    def add(self, rays: Index, ranks: Any, arrays: list[Any]) -> None:
        """ranks: one for all places, which are then of different rays, or an array."""
        if np.ndim(ranks):
            np.add.at(self._counts, rays + 1, 1)
        else:
            self._counts[rays + 1] += 1
        self._parts.append((rays, ranks, [array for array in arrays if array is not None]))

    def places(self) -> Places:
        starts = np.cumsum(self._counts)
        count = int(starts[-1])
        ray, triangle = np.empty(count, np.int64), np.empty(count, np.int64)
        t, u, v = (np.empty(count if self.weights else 0, np.float32) for _ in range(3))
        for rays, ranks, arrays in self._parts:
            places = starts[rays] + ranks
            ray[places] = rays
            targets: tuple[NDArray[Any], ...] = (triangle, t, u, v) if self.weights else (triangle,)
            for target, array in zip(targets, arrays):
                target[places] = array
        return Places(ray, triangle, t, u, v)


def first_places(
    tree: Tree, origins: NDArray[np.float32], directions: NDArray[np.float32], weights: bool, pool: Optional[Pool]
) -> Places:
    """The first place of each ray that hits anything. `weights`: with t, u and v."""
    hits = tree.trace(origins, directions, outputs=("triangle", "t", "u", "v") if weights else ("triangle",), pool=pool)
    ray = np.flatnonzero(hits.hit)
    t, u, v = (array.take(ray) if weights else _NO_FLOATS for array in (hits.t, hits.u, hits.v))
    return Places(ray, hits.triangle.take(ray).astype(np.int64), t, u, v)


def all_places(
    tree: Tree,
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    max_hits: Optional[int],
    weights: bool,
    pool: Optional[Pool],
) -> Places:
    """Every place of each ray, the first `max_hits` if it is not None. `weights`: with t, u and v.

    Of triangles that a ray hits at the same t, as rounded, only the first is listed.
    """
    limit = _NO_LIMIT if max_hits is None else max_hits
    found = _Collector(len(origins), weights)
    rays, rank = _Rays(np.arange(len(origins)), origins, directions, None, None), 0
    while len(rays.number) > _FEW and rank < limit:
        rays = _add_next(found, tree, rays, rank, limit, pool)
        rank += 1
    if rank < limit:
        _add_lists(found, tree, rays, rank, limit, pool)
    return found.places()


def _add_next(found: _Collector, tree: Tree, rays: _Rays, rank: int, limit: int, pool: Optional[Pool]) -> _Rays:
    """Adds the next place of each ray; returns the rays behind it. Rays that hit nothing more may be among them, with t_min = inf."""
    count = len(rays.number)
    ids = np.empty((count, 2), np.uint32)
    t, u, v = (np.empty(count, np.float32) if i == 0 or found.weights else None for i in range(3))
    out: Any = Hits(t, u, v, ids[:, 0], ids[:, 1])  # type: ignore[arg-type]
    hits = tree.trace(rays.origins, rays.directions, rays.t_min, skip=rays.skip, out=out, pool=pool)
    hit = hits.hit
    if rays.t_min is not None:
        same = np.flatnonzero(hit & (hits.t == rays.t_min))
        if len(same):
            _add_lists(found, tree, rays.take(same), rank, limit, pool)
            hit[same] = False
            hits.t[same] = np.inf
    alive = np.flatnonzero(hit)
    arrays = [None if array is None else array.take(alive) for array in (hits.triangle, hits.t, hits.u, hits.v)]
    found.add(rays.number.take(alive), rank, arrays)
    rays = rays._replace(t_min=hits.t, skip=ids)
    # Rays that are done take little time, and without them the others would not lie in rows any more.
    return rays.take(alive) if 2 * len(alive) < count else rays


def _add_lists(found: _Collector, tree: Tree, rays: _Rays, rank: int, limit: int, pool: Optional[Pool]) -> None:
    """Adds all places of rays with t > t_min, the first of which has the given rank.

    Lists are short for most rays: those that need more room are traced again.
    """
    outputs = ("triangle", "total", "t", "u", "v") if found.weights else ("triangle", "total", "t")
    capacity = _FIRST_CAPACITY
    while len(rays.number):
        lists = tree.hits(
            rays.origins, rays.directions, capacity, rays.t_min, skip=rays.skip, outputs=outputs, pool=pool
        )
        complete = lists.total <= capacity
        new = np.asarray(np.arange(capacity) < lists.total[:, None])
        new[:, 1:] &= lists.t[:, 1:] != lists.t[:, :-1]
        if rays.t_min is not None:
            new &= lists.t != rays.t_min[:, None]
        new &= complete[:, None]
        ranks = np.cumsum(new, axis=1) - 1 + rank
        new &= ranks < limit
        row, column = np.nonzero(new)
        arrays = [None if array is None else array[row, column] for array in (lists.triangle, lists.t, lists.u, lists.v)]
        found.add(rays.number[row], ranks[row, column], arrays)
        rays, capacity = rays.take(np.flatnonzero(~complete)), capacity * _GROWTH
