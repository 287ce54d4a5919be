# SPDX-License-Identifier: MIT
"""Every place where rays meet a mesh, one entry per place, for trimesh.

Place after place: all rays together are traced again from behind the triangle they hit, which they skip. That is faster than
lists of hits, as long as many rays go together. Few rays, and those that hit another triangle at the same t, get lists.
"""

from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from ._origins import Begins
from ._results import Hits
from ._tree import Tree
from .typing import Threads

Index = NDArray[np.int64]
Floats = NDArray[np.float32]

_FEW = 512  # rays that are not worth a pass of their own
_FIRST_CAPACITY = 8  # of a list, and how much longer it gets for rays that need more
_GROWTH = 4
_NO_LIMIT = 1 << 62
_NO_FLOATS = np.zeros(0, np.float32)


class Places(NamedTuple):
    """Where rays hit: arrays with an element per place, the first of all rays, then the second, and so on. t, u, v can be empty."""

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

    def __init__(self, weights: bool) -> None:
        self.weights = weights
        self._parts: list[tuple[Index, Any, list[Any]]] = []

    def add(self, rays: Index, ranks: Any, arrays: list[Any]) -> None:
        """ranks: one for all places, which are then by ray, or an array."""
        self._parts.append((rays, ranks, arrays if self.weights else arrays[:1]))

    def places(self) -> Places:
        """All of them: the first of all rays, then the second of all, and so on."""
        if not self._parts:
            return _nowhere()
        rays, ranks, arrays = zip(*self._parts)
        ray = np.concatenate(rays)
        columns = [np.concatenate(column) for column in zip(*arrays)]
        if any(np.ndim(rank) for rank in ranks) or any(np.diff(ranks) <= 0):
            of_parts = [np.broadcast_to(rank, len(part)) for rank, part in zip(ranks, rays)]
            key = np.concatenate(of_parts).astype(np.int64) * (int(ray.max(initial=0)) + 1) + ray
            order = np.argsort(key, kind="stable")  # fast: these are a few pieces that are ordered already
            ray, columns = ray.take(order), [column.take(order) for column in columns]
        triangle, *weights = columns
        return Places(ray, triangle.astype(np.int64), *(weights if self.weights else [_NO_FLOATS] * 3))


def _nowhere() -> Places:
    nothing = np.zeros(0, np.int64)
    return Places(nothing, nothing, _NO_FLOATS, _NO_FLOATS, _NO_FLOATS)


def first_places(
    tree: Tree, origins: Floats, directions: Floats, begins: Optional[Begins], weights: bool, pool: Threads
) -> Places:
    """The first place of each ray that hits anything. `begins`: what rays begin on. `weights`: with t, u and v."""
    hits = tree.trace(origins, directions, outputs=("triangle", "t", "u", "v") if weights else ("triangle",), pool=pool)
    if begins is not None:
        hits.triangle[begins.ray] = begins.triangle
        if weights:
            hits.t[begins.ray], hits.u[begins.ray], hits.v[begins.ray] = 0, begins.u, begins.v
    ray = np.flatnonzero(hits.hit)
    t, u, v = (array.take(ray) if weights else _NO_FLOATS for array in (hits.t, hits.u, hits.v))
    return Places(ray, hits.triangle.take(ray).astype(np.int64), t, u, v)


def all_places(
    tree: Tree,
    origins: Floats,
    directions: Floats,
    begins: Optional[Begins],
    max_hits: Optional[int],
    weights: bool,
    pool: Threads,
) -> Places:
    """Every place of each ray, the first `max_hits` if it is not None. Arguments as for `first_places`.

    Of triangles that a ray hits at the same t, as rounded, only the first is listed.
    """
    limit = _NO_LIMIT if max_hits is None else max_hits
    found = _Collector(weights)
    rays = _Rays(np.arange(len(origins)), origins, directions, None, None)
    if begins is None or len(begins.ray) == 0:
        _add_all(found, tree, rays, 0, limit, pool)
        return found.places()
    if limit > 0:
        t = np.zeros(len(begins.ray), np.float32)
        found.add(begins.ray, 0, [begins.triangle, t, begins.u, begins.v])
    others = np.ones(len(origins), np.bool_)
    others[begins.ray] = False
    _add_all(found, tree, rays.take(np.flatnonzero(others)), 0, limit, pool)
    _add_all(found, tree, rays.take(begins.ray), 1, limit, pool)
    return found.places()


def _add_all(found: _Collector, tree: Tree, rays: _Rays, rank: int, limit: int, pool: Threads) -> None:
    """Adds all places of rays, the first of which has the given rank."""
    while len(rays.number) > _FEW and rank < limit:
        rays = _add_next(found, tree, rays, rank, limit, pool)
        rank += 1
    if rank < limit:
        _add_lists(found, tree, rays, rank, limit, pool)


def _add_next(found: _Collector, tree: Tree, rays: _Rays, rank: int, limit: int, pool: Threads) -> _Rays:
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


def _add_lists(found: _Collector, tree: Tree, rays: _Rays, rank: int, limit: int, pool: Threads) -> None:
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
