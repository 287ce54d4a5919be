# SPDX-License-Identifier: MIT
"""A RayMeshIntersector for trimesh, with the methods of trimesh.ray.ray_triangle and trimesh.ray.ray_pyembree.

    mesh.ray = mlrt.trimesh.RayMeshIntersector(mesh)

What a ray hits is decided exactly on float32 numbers: vertices, origins and directions are rounded once. A mesh that lies
further from zero than its own size is moved to zero first, in float64; if its coordinates are float32, as those of STL files
are, that loses nothing (differences of floats within a factor of two are exact: P. H. Sterbenz, 1974).

Different from trimesh's own: a ray does not hit a surface that it starts on. A ray through an edge or a corner hits one
triangle there, the first, in all methods. contains_points counts crossings exactly, without random directions.
"""

from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._tree import Tree

_FIRST_CAPACITY = 8
_GROWTH = 4

Index = NDArray[np.int64]


class RayMeshIntersector:
    """Ray queries for a trimesh.Trimesh, or any object with vertices (n, 3), faces (m, 3) and a __hash__ of its contents.

    The tree is built at the first query, and again when the mesh has changed. Arrays of rays are float (n, 3).
    """

    def __init__(self, mesh: Any, **kwargs: Any) -> None:
        """Arguments like `scale_to_box` of trimesh's classes are accepted and have no effect: nothing depends on scale."""
        self.mesh = mesh
        self._tree: Optional[Tree] = None
        self._hash: Any = None

    def __getstate__(self) -> dict[str, Any]:
        return {"mesh": self.mesh}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.mesh, self._tree, self._hash = state["mesh"], None, None

    def __deepcopy__(self, memo: Any) -> "RayMeshIntersector":
        return type(self)(self.mesh)

    def __copy__(self) -> "RayMeshIntersector":
        return type(self)(self.mesh)

    def _prepare(self) -> Tree:
        """The tree of the mesh as it is now."""
        state = hash(self.mesh)
        if self._tree is None or state != self._hash:
            vertices = np.asarray(self.mesh.vertices, np.float64).reshape(-1, 3)
            self._shift = _shift(vertices)
            self._tree = Tree(vertices - self._shift, np.asarray(self.mesh.faces).reshape(-1, 3))
            self._hash = state
        return self._tree

    def _rays(self, origins: ArrayLike, directions: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        origins, directions = _points(origins, "ray_origins"), _points(directions, "ray_directions")
        if origins.shape != directions.shape:
            raise ValueError("Ray origin and direction don't match!")
        return (origins - self._shift).astype(np.float32), directions.astype(np.float32)

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        return_locations: bool = False,
        multiple_hits: bool = True,
        max_hits: Optional[int] = None,
        **kwargs: Any,
    ) -> Union[tuple[Index, Index], tuple[Index, Index, NDArray[np.float64]]]:
        """The triangles that rays hit, by ray and then by distance.

        Returns index_tri int64 (h,), index_ray int64 (h,) and, with return_locations, locations float64 (h, 3).
        multiple_hits=False: only the first of each ray. max_hits: at most so many places per ray.
        """
        tree = self._prepare()
        rays = self._rays(ray_origins, ray_directions)
        if multiple_hits:
            index_ray, index_tri, weights = _all_places(tree, *rays, max_hits)
        else:
            hits = tree.trace(*rays, outputs=("t", "u", "v", "triangle"))
            index_ray = np.flatnonzero(hits.hit)
            index_tri = hits.triangle[index_ray].astype(np.int64)
            weights = np.column_stack((hits.u, hits.v))[index_ray]
        if not return_locations:
            return index_tri, index_ray
        return index_tri, index_ray, self._locations(ray_origins, ray_directions, index_ray, index_tri, weights)

    def _locations(
        self, origins: ArrayLike, directions: ArrayLike, index_ray: Index, index_tri: Index, weights: NDArray[np.float32]
    ) -> NDArray[np.float64]:
        """Where rays meet the planes of the triangles they hit, in float64.

        A ray nearly in the plane may meet it outside of the triangle: then the point that float32 arithmetic found is taken.
        """
        vertices = np.asarray(self.mesh.vertices, np.float64)
        corners = vertices[np.asarray(self.mesh.faces)[index_tri]]
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        u, v = weights[:, :1].astype(np.float64), weights[:, 1:].astype(np.float64)
        in_triangle = a + u * (b - a) + v * (c - a)
        normal = np.cross(b - a, c - a)
        origin, direction = _points(origins, "")[index_ray], _points(directions, "")[index_ray]
        with np.errstate(all="ignore"):
            t = np.sum((a - origin) * normal, axis=1) / np.sum(direction * normal, axis=1)
            on_ray = origin + t[:, None] * direction
            size = np.abs(b - a).max(axis=1, initial=0) + np.abs(c - a).max(axis=1, initial=0)
            near = np.abs(on_ray - in_triangle).max(axis=1, initial=0) <= 1e-3 * size
        return np.where(near[:, None], on_ray, in_triangle)

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True, **kwargs: Any
    ) -> tuple[NDArray[np.float64], Index, Index]:
        """Where rays hit the mesh: locations float64 (h, 3), index_ray int64 (h,), index_tri int64 (h,)."""
        kwargs.pop("return_locations", None)
        found: Any = self.intersects_id(
            ray_origins, ray_directions, return_locations=True, multiple_hits=multiple_hits, **kwargs
        )
        index_tri, index_ray, locations = found
        return locations, index_ray, index_tri

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike, **kwargs: Any) -> Index:
        """The first triangle that each ray hits: int64 (n,), -1 = none."""
        tree = self._prepare()
        hits = tree.trace(*self._rays(ray_origins, ray_directions), outputs="triangle")
        return hits.triangle.view(np.int32).astype(np.int64)

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike, **kwargs: Any) -> NDArray[np.bool_]:
        """Whether each ray hits the mesh: bool (n,)."""
        tree = self._prepare()
        return tree.occluded(*self._rays(ray_origins, ray_directions))

    def contains_points(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each point, float (n, 3), is inside of the mesh: bool (n,). Undefined for points on the surface.

        A point is inside if rays from it cross the surface an odd number of times, both upwards and downwards. For a closed
        mesh the two always agree.
        """
        tree = self._prepare()
        points = (_points(points, "points") - self._shift).astype(np.float32)
        inside = tree.contains(points, (0, 0, 1))
        if not getattr(self.mesh, "is_watertight", False):
            inside &= tree.contains(points, (0, 0, -1))
        return inside


def _points(values: ArrayLike, name: str) -> NDArray[np.float64]:
    array = np.asarray(values, np.float64)
    if array.ndim == 1 and array.size == 0:
        return array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} must be (n,3)")
    return array


def _shift(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """What to subtract from all points: per axis the middle of the mesh, if the mesh lies further from zero than its size."""
    finite = vertices[np.isfinite(vertices).all(axis=1)]
    if len(finite) == 0:
        return np.zeros(3)
    lower, upper = finite.min(axis=0), finite.max(axis=0)
    middle = (lower / 2 + upper / 2).astype(np.float32).astype(np.float64)
    return np.where(np.abs(middle) > upper - lower, middle, 0.0)


def _all_places(
    tree: Tree, origins: NDArray[np.float32], directions: NDArray[np.float32], max_hits: Optional[int]
) -> tuple[Index, Index, NDArray[np.float32]]:
    """Every place where rays hit: index_ray, index_tri, (u, v). Of triangles hit at the same t only the first is listed.

    Lists are short for most rays: those that need more room are traced again.
    """
    rays, capacity, found = np.arange(len(origins)), _FIRST_CAPACITY, []
    while len(rays):
        lists = tree.hits(origins[rays], directions[rays], capacity, outputs=("t", "u", "v", "triangle", "total"))
        complete = lists.total <= capacity
        new = np.asarray(np.arange(capacity) < lists.total[:, None])
        new[:, 1:] &= lists.t[:, 1:] != lists.t[:, :-1]
        new &= complete[:, None]
        if max_hits is not None:
            new &= np.cumsum(new, axis=1) <= max_hits
        row, column = np.nonzero(new)
        weights = np.column_stack((lists.u[row, column], lists.v[row, column]))
        found.append((rays[row], lists.triangle[row, column].astype(np.int64), weights))
        rays, capacity = rays[~complete], capacity * _GROWTH
    if not found:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 2), np.float32)
    index_ray, index_tri, weights = (np.concatenate(parts) for parts in zip(*found))
    order = np.argsort(index_ray, kind="stable")
    return index_ray[order], index_tri[order], weights[order]
