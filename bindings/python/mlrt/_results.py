# SPDX-License-Identifier: MIT
"""What tracing returns: arrays of hits, one entry per ray, and lists of hits, several entries per ray."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Callable, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import NDArray

from ._abi import LIGHT_LIMIT, NONE
from ._meshes import parts
from .typing import Mesh, Meshes, Outputs

# An array that was not asked for. Whoever asked for it need not tell a type checker that it is there.
_ABSENT: Any = None

Floats = NDArray[np.float32]


class _Arrays(NamedTuple):
    t: NDArray[np.float32] = _ABSENT
    u: NDArray[np.float32] = _ABSENT
    v: NDArray[np.float32] = _ABSENT
    mesh: NDArray[np.uint32] = _ABSENT
    triangle: NDArray[np.uint32] = _ABSENT
    facing: NDArray[np.int32] = _ABSENT
    occluded: NDArray[np.uint8] = _ABSENT


HIT_FIELDS = _Arrays._fields[:-1]


class Hits(_Arrays):
    """The closest hits of rays: a tuple of arrays of the rays' shape. One that was not asked for is None.

    t: float32, distance in units of the direction's length, rounded; inf = miss, or beyond the range of float.
    u, v: float32, weights of the triangle's second and third vertex.
    mesh: uint32, id of the mesh; mlrt.NONE = miss.
    triangle: uint32, number of the triangle in its mesh; mlrt.NONE = miss.
    facing: int32, +1: the ray travels along the normal, -1: against it, 0 = miss.
    occluded: uint8, of Tree.render with lights: bit k = light k does not reach the hit; 0 = miss.
    """

    # Origins and directions of the rays, or what makes them, if a Tree made this: for `points`.
    _rays: Union[tuple[Any, Any], Callable[[], tuple[Any, Any]], None] = None

    def __reduce__(self) -> Any:
        return type(self), tuple(self)

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
        shadow: NDArray[np.bool_] = _given(self.occluded, "occluded") & (1 << light) != 0
        return shadow

    @property
    def points(self) -> Floats:
        """Where the rays hit, o + t d: float32 (..., 3), computed in float64 from the rounded t. Misses are NaN.

        The arrays of rays are not copied for this, so it is of the rays as they are in the arrays now. Hits that were unpickled,
        or that no Tree made, know no rays.
        """
        t = _given(self.t, "t")
        if self._rays is None:
            raise ValueError("points: these hits know no rays, since no call of a Tree in this process returned them")
        origins, directions = self._rays() if callable(self._rays) else self._rays
        with np.errstate(all="ignore"):
            points = np.asarray(origins, np.float32) + t[..., None].astype(np.float64) * np.asarray(directions, np.float32)
            return self._at_hits(points)

    @property
    def barycentrics(self) -> Floats:
        """The weights 1 - u - v, u, v of the three vertices: float32 (..., 3). Misses are NaN."""
        u, v = _given(self.u, "u"), _given(self.v, "v")
        first = 1 - u.astype(np.float64) - v
        return self._at_hits(np.stack((first, u, v), axis=-1))

    def normals(self, mesh: Union[Mesh, Meshes]) -> Floats:
        """Unit normals of the triangles that are hit: float32 (..., 3). Misses are NaN.

        Vertices of a triangle go counterclockwise around its normal; multiply by `-facing[..., None]` for normals towards the rays.

        mesh: that of the tree: (vertices, faces), or an object that has them. Of a tree with several: a list of them, as
        Tree.from_meshes got it, or a dictionary by their ids.
        """
        triangle, hit = _given(self.triangle, "triangle"), self.hit
        normals = np.full((*triangle.shape, 3), np.nan, np.float32)
        several = _several(mesh)
        ids = np.zeros_like(triangle) if several is None else _given(self.mesh, "mesh")
        for number, (vertices, faces) in ({0: parts(mesh)} if several is None else several).items():
            of_it = hit & (ids == number) if several is not None else hit
            normals[of_it] = _unit_normals(vertices, faces, triangle[of_it].astype(np.int64), number if several else None)
            hit &= ~of_it
        if hit.any():
            raise ValueError(f"mesh: there is none with id {int(ids[hit].flat[0])}, which is hit")
        return normals

    def _at_hits(self, values: NDArray[Any]) -> Floats:
        result: Floats = np.where(self.hit[..., None], values, np.nan).astype(np.float32)
        return result

    def __repr__(self) -> str:
        """How many there are, and the range of t."""
        first = next((array for array in self if array is not None), None)
        if first is None:
            return "Hits()"
        size = f"{first.size} rays" + (f" {first.shape}" if first.ndim != 1 else "")
        names = ", ".join(name for name, array in zip(self._fields, self) if array is not None)
        if not isinstance(first, np.ndarray) or all(array is None for array in self[:1] + self[3:6]):
            return f"<Hits of {size}: {names}>"
        hit = self.hit
        text = f"<Hits of {size}: {np.count_nonzero(hit)} hit"
        if self.t is not None and hit.any():
            text += f", t from {self.t[hit].min():.6g} to {self.t[hit].max():.6g}"
        return f"{text}; {names}>"


_new_tuple: Any = tuple.__new__
make_hits: Callable[[type[Hits], Iterable[Any]], Hits] = _new_tuple  # Hits._make in half the time


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

    def __repr__(self) -> str:
        """How many there are, in all and of the ray that has most."""
        lists = next((array for array in self[:7] if array is not None), None)
        total = next((array for array in self[7:] if array is not None), None)
        shape = total.shape if total is not None else lists.shape[:-1] if lists is not None else ()
        if lists is None and total is None:
            return "HitLists()"
        text = f"<HitLists of {int(np.prod(shape))} rays" + (f" {shape}" if len(shape) != 1 else "")
        if lists is not None:
            text += f", k = {lists.shape[-1]}"
        for name, array in (("hits", self.total), ("crossings", self.crossing_total)):
            if array is not None and array.size:
                text += f": {int(array.sum(dtype=np.uint64))} {name}, at most {int(array.max())} of a ray"
        return text + "; " + ", ".join(name for name, array in zip(self._fields, self) if array is not None) + ">"


def check_names(outputs: Outputs, known: tuple[str, ...]) -> tuple[str, ...]:
    """`outputs` as names without repetitions, each of which is known; None = all."""
    if outputs is None:
        return known
    names = (outputs,) if isinstance(outputs, str) else tuple(dict.fromkeys(outputs))
    if not names:
        raise ValueError("outputs: at least one is needed")
    for name in names:
        if name not in known:
            raise ValueError(f"outputs: {name!r} is none of {', '.join(known)}")
    return names


def _given(array: Any, name: str) -> Any:
    if array is None:
        raise ValueError(f"{name} was not asked for")
    return array


def _several(mesh: Any) -> Optional[dict[int, tuple[Any, Any]]]:
    """Meshes by id; None if it is one."""
    if isinstance(mesh, Mapping):
        return {number: parts(one) for number, one in mesh.items()}
    if hasattr(mesh, "vertices") or not isinstance(mesh, Iterable):
        return None
    meshes = list(mesh)
    if len(meshes) == 2 and not isinstance(meshes[0], tuple) and not hasattr(meshes[0], "vertices"):
        return None  # (vertices, faces)
    return {number: parts(one) for number, one in enumerate(meshes)}


def _unit_normals(vertices: Any, faces: Any, triangles: NDArray[np.int64], number: Optional[int]) -> NDArray[np.float64]:
    vertices = np.asarray(vertices, np.float32).reshape(-1, 3)
    count = len(vertices) // 3 if faces is None else len(faces)
    if len(triangles) and triangles.max() >= count:
        which = "it" if number is None else f"number {number}"
        raise ValueError(f"mesh: {which} has {count} triangles, but number {triangles.max()} is hit")
    corners = triangles[:, None] * 3 + np.arange(3) if faces is None else np.asarray(faces)[triangles]
    a, b, c = np.moveaxis(vertices.astype(np.float64)[corners], 1, 0)
    normals = np.cross(b - a, c - a)
    unit: NDArray[np.float64] = normals / np.linalg.norm(normals, axis=1)[:, None]
    return unit


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
