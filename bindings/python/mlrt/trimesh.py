# SPDX-License-Identifier: MIT
"""A RayMeshIntersector for trimesh, with the methods of trimesh.ray.ray_triangle and trimesh.ray.ray_pyembree.

    mesh.ray = mlrt.trimesh.RayMeshIntersector(mesh)

What a ray hits is decided exactly on float32 numbers: vertices, origins and directions are rounded once. A mesh that lies
further from zero than its own size is moved to zero first, in float64; if its coordinates are float32, as those of STL files
are, that loses nothing (differences of floats within a factor of two are exact: P. H. Sterbenz, 1974).

Or for all meshes, whatever they are made by:

    mlrt.trimesh.install()

As with trimesh's own classes, a ray that begins on a face hits it; here this is decided exactly, and can be turned off. Hits are
in the order that trimesh has with embreex. Different from trimesh's own: a ray through an edge or a corner hits one triangle there,
the first, in all methods. contains_points counts crossings exactly, without random directions.
"""

from __future__ import annotations

import importlib
from typing import Any, Literal, Optional, Union, overload

import numpy as np
from numpy.typing import NDArray

from ._origins import Begins, begins
from ._places import Floats, Index, Places, all_places, first_places
from ._tree import Tree
from .typing import Threads, Vectors

# How far from the place that float32 found a plane may be met, in sizes of the triangle.
_TOLERANCE = 1e-3
_PIECE = 1 << 14  # places worked on at once: their arrays stay in the cache

class RayMeshIntersector:
    """Ray queries for a trimesh.Trimesh, or any object with vertices (n, 3), faces (m, 3) and a __hash__ of its contents.

    The tree is built at the first query, and again when the mesh has changed. Arrays of rays are float (n, 3).
    """

    def __init__(
        self, mesh: Any, pool: Threads = None, hits_at_origin: Optional[bool] = None, **kwargs: Any
    ) -> None:
        """pool: threads to share all work with: a Pool, which copies and pickles do without, or a number of threads.

        hits_at_origin: does a ray hit a face that it begins on, exactly on it, after rounding to float32? None = as `install` was
        told, else yes, as trimesh's own classes do. It does not, if it lies in the plane of the face.
        Arguments like `scale_to_box` of trimesh's classes are accepted and have no effect: nothing depends on scale.
        """
        self.mesh = mesh
        self._pool = _installed["pool"] if pool is None else pool
        self.hits_at_origin: bool = _installed["hits_at_origin"] if hits_at_origin is None else hits_at_origin
        self._tree: Optional[Tree] = None
        self._planes: Optional[_Planes] = None
        self._hash: Any = None

    def __getstate__(self) -> dict[str, Any]:
        return {"mesh": self.mesh, "pool": self._pool_of_copies(), "hits_at_origin": self.hits_at_origin}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(**state)  # type: ignore[misc]

    def __deepcopy__(self, memo: Any) -> RayMeshIntersector:
        return self.__copy__()

    def __copy__(self) -> RayMeshIntersector:
        return type(self)(self.mesh, self._pool_of_copies(), self.hits_at_origin)

    def _pool_of_copies(self) -> Optional[int]:
        return self._pool if isinstance(self._pool, int) else None

    def __repr__(self) -> str:
        """How large the mesh is, and whether there is a tree of it."""
        state = "no tree yet" if self._tree is None else f"a tree of {self._tree.info.memory_size} bytes"
        return f"<mlrt.trimesh.RayMeshIntersector of {len(self.mesh.faces)} faces, {state}>"

    def _prepare(self) -> Tree:
        """The tree of the mesh as it is now."""
        state = hash(self.mesh)
        if self._tree is None or state != self._hash:
            vertices = np.asarray(self.mesh.vertices, np.float64).reshape(-1, 3)
            self._shift = _shift(vertices)
            moved, faces = (vertices - self._shift).astype(np.float32), np.asarray(self.mesh.faces).reshape(-1, 3)
            self._tree = Tree(moved, faces, pool=self._pool)
            self._corners = moved, faces
            self._planes = None
            self._hash = state
        return self._tree

    def _rays(self, origins: Vectors, directions: Vectors) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """The rays in float32, where the tree is."""
        origins, directions = _points(origins, "ray_origins"), _points(directions, "ray_directions")
        if origins.shape != directions.shape:
            raise ValueError("Ray origin and direction don't match!")
        return _moved(origins, self._shift), directions.astype(np.float32, copy=False)

    def _begins(self, origins: Floats, directions: Floats) -> Optional[Begins]:
        """What rays begin on, if that counts."""
        if not self.hits_at_origin or self._tree is None:
            return None
        return begins(self._tree, *self._corners, origins, directions, self._pool)

    @overload
    def intersects_id(
        self,
        ray_origins: Vectors,
        ray_directions: Vectors,
        return_locations: Literal[False] = False,
        multiple_hits: bool = True,
        max_hits: Optional[int] = None,
        **kwargs: Any,
    ) -> tuple[Index, Index]: ...

    @overload
    def intersects_id(
        self,
        ray_origins: Vectors,
        ray_directions: Vectors,
        return_locations: Literal[True],
        multiple_hits: bool = True,
        max_hits: Optional[int] = None,
        **kwargs: Any,
    ) -> tuple[Index, Index, NDArray[np.float64]]: ...

    def intersects_id(
        self,
        ray_origins: Vectors,
        ray_directions: Vectors,
        return_locations: bool = False,
        multiple_hits: bool = True,
        max_hits: Optional[int] = None,
        **kwargs: Any,
    ) -> Union[tuple[Index, Index], tuple[Index, Index, NDArray[np.float64]]]:
        """The triangles that rays hit: the first of each ray, by ray, then the second of each that has two, and so on.

        Returns index_tri int64 (h,), index_ray int64 (h,) and, with return_locations, locations float64 (h, 3).
        multiple_hits=False: only the first of each ray. max_hits: at most so many places per ray.
        """
        tree = self._prepare()
        rays = self._rays(ray_origins, ray_directions)
        if multiple_hits:
            places = all_places(tree, *rays, self._begins(*rays), max_hits, return_locations, self._pool)
        else:
            places = first_places(tree, *rays, self._begins(*rays), return_locations, self._pool)
        if not return_locations:
            return places.triangle, places.ray
        return places.triangle, places.ray, self._locations(ray_origins, ray_directions, places)

    def _locations(self, origins: Vectors, directions: Vectors, places: Places) -> NDArray[np.float64]:
        """Where rays meet the planes of the triangles they hit, in float64.

        A ray nearly in the plane may meet it outside of the triangle: then the point that float32 arithmetic found is taken.
        """
        planes = self._planes  # another thread may forget them, as it builds the same tree
        if planes is None:
            planes = self._planes = _Planes(self.mesh)
        rays = _points(origins, ""), _points(directions, "")
        locations = np.empty((len(places.ray), 3))
        for start in range(0, len(places.ray), _PIECE):
            piece = slice(start, start + _PIECE)
            planes.meet(*rays, Places._make(array[piece] for array in places), locations[piece])
        return locations

    def intersects_location(
        self, ray_origins: Vectors, ray_directions: Vectors, multiple_hits: bool = True, **kwargs: Any
    ) -> tuple[NDArray[np.float64], Index, Index]:
        """Where rays hit the mesh: locations float64 (h, 3), index_ray int64 (h,), index_tri int64 (h,)."""
        kwargs.pop("return_locations", None)
        index_tri, index_ray, locations = self.intersects_id(
            ray_origins, ray_directions, return_locations=True, multiple_hits=multiple_hits, **kwargs
        )
        return locations, index_ray, index_tri

    def intersects_first(self, ray_origins: Vectors, ray_directions: Vectors, **kwargs: Any) -> Index:
        """The first triangle that each ray hits: int64 (n,), -1 = none."""
        tree = self._prepare()
        rays = self._rays(ray_origins, ray_directions)
        triangle = tree.trace(*rays, outputs="triangle", pool=self._pool).triangle.view(np.int32).astype(np.int64)
        found = self._begins(*rays)
        if found is not None:
            triangle[found.ray] = found.triangle
        return triangle

    def intersects_any(self, ray_origins: Vectors, ray_directions: Vectors, **kwargs: Any) -> NDArray[np.bool_]:
        """Whether each ray hits the mesh: bool (n,)."""
        tree = self._prepare()
        rays = self._rays(ray_origins, ray_directions)
        anything = tree.occluded(*rays, pool=self._pool)
        found = self._begins(*rays)
        if found is not None:
            anything[found.ray] = True
        return anything

    def contains_points(self, points: Vectors) -> NDArray[np.bool_]:
        """Whether each point, float (n, 3), is inside of the mesh: bool (n,). Undefined for points on the surface.

        A point is inside if rays from it cross the surface an odd number of times, both upwards and downwards. For a closed
        mesh the two always agree.
        """
        tree = self._prepare()
        points = _moved(_points(points, "points"), self._shift)
        inside = tree.contains(points, (0, 0, 1), pool=self._pool)
        if not getattr(self.mesh, "is_watertight", False):
            inside &= tree.contains(points, (0, 0, -1), pool=self._pool)
        return inside


# What meshes get that are made from now on.
_installed: dict[str, Any] = {"pool": None, "hits_at_origin": True}

_MODULES = ("trimesh.ray.ray_triangle", "trimesh.ray.ray_pyembree")
_replaced: dict[str, Any] = {}


def install(pool: Threads = None, hits_at_origin: bool = True) -> None:
    """Makes this the ray class of all meshes of trimesh that are made from now on, in place of both of its own.

    Meshes that exist already keep what they have, as long as nobody says `mesh.ray = mlrt.trimesh.RayMeshIntersector(mesh)`.
    Arguments as for RayMeshIntersector, of all those whose maker gives none. Calling it again changes them.
    """
    for name in _MODULES:
        try:
            module = importlib.import_module(name)
        except ImportError as error:
            if name == _MODULES[0]:
                raise ImportError("mlrt.trimesh.install needs trimesh: pip install trimesh") from error
            continue  # without embreex, trimesh has one class only
        _replaced.setdefault(name, module.RayMeshIntersector)
        module.RayMeshIntersector = RayMeshIntersector  # type: ignore[attr-defined]
    _installed.update(pool=pool, hits_at_origin=hits_at_origin)


def uninstall() -> None:
    """Ends what `install` did: meshes made from now on have trimesh's own classes. Those made meanwhile keep this one."""
    for name, original in _replaced.items():
        importlib.import_module(name).RayMeshIntersector = original  # type: ignore[attr-defined]
    _replaced.clear()
    _installed.update(pool=None, hits_at_origin=True)


class _Planes:
    """The planes of a mesh's triangles, in float64."""

    def __init__(self, mesh: Any) -> None:
        a, b, c = np.moveaxis(np.asarray(mesh.vertices, np.float64)[np.asarray(mesh.faces)], 1, 0)
        self.corners, self.first_edges, self.second_edges = np.ascontiguousarray(a), b - a, c - a
        self.normals = np.cross(self.first_edges, self.second_edges)
        sizes = np.abs(self.first_edges).max(axis=1, initial=0) + np.abs(self.second_edges).max(axis=1, initial=0)
        self.tolerances = _TOLERANCE * sizes

    def meet(
        self, origins: NDArray[Any], directions: NDArray[Any], places: Places, locations: NDArray[np.float64]
    ) -> None:
        """Writes the point of each place to `locations`."""
        origin, direction = (array.take(places.ray, axis=0) for array in (origins, directions))
        normal, to_corner = (array.take(places.triangle, axis=0) for array in (self.normals, self.corners))
        tolerance = self.tolerances.take(places.triangle)
        to_corner -= origin
        with np.errstate(all="ignore"):
            t = np.einsum("ij,ij->i", to_corner, normal) / np.einsum("ij,ij->i", direction, normal)
            for axis in range(3):
                locations[:, axis] = origin[:, axis] + t * direction[:, axis]
            lengths = np.sqrt(np.einsum("ij,ij->i", direction, direction))
            # Most planes are met where the exact answer, rounded to float32, says; the others are looked at more closely.
            far = np.flatnonzero(~(np.abs(t - places.t) * lengths <= tolerance))
            if len(far) == 0:
                return
            triangle = places.triangle[far]
            found = self.corners[triangle].copy()
            for weights, edges in ((places.u, self.first_edges), (places.v, self.second_edges)):
                found += weights[far, None].astype(np.float64) * edges[triangle]
            wrong = ~(np.abs(locations[far] - found).max(axis=1) <= tolerance[far])
            locations[far[wrong]] = found[wrong]


def _points(values: Vectors, name: str) -> NDArray[Any]:
    """`values` as float64 of shape (n, 3), or as float32 if they are."""
    array = np.asarray(values)
    if array.dtype != np.float32:
        array = array.astype(np.float64, copy=False)
    if array.ndim == 1 and array.size == 0:
        return array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} must be (n,3)")
    return array


def _moved(points: NDArray[Any], shift: NDArray[np.float64]) -> NDArray[np.float32]:
    """points - shift, rounded to float32 once. Axis by axis, since numpy is slow where the last axis is short."""
    if not shift.any():
        return points.astype(np.float32, copy=False)
    moved = np.empty(points.shape, np.float32)
    for axis in range(3):
        moved[:, axis] = points[:, axis] - shift[axis]
    return moved


def _shift(vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """What to subtract from all points: per axis the middle of the mesh, if the mesh lies further from zero than its size."""
    finite = vertices[np.isfinite(vertices).all(axis=1)]
    if len(finite) == 0:
        return np.zeros(3)
    lower, upper = finite.min(axis=0), finite.max(axis=0)
    middle = (lower / 2 + upper / 2).astype(np.float32).astype(np.float64)
    return np.where(np.abs(middle) > upper - lower, middle, 0.0)
