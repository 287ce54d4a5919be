# SPDX-License-Identifier: MIT
"""Trees of triangles, and the questions that can be asked of them."""

from __future__ import annotations

import ctypes
import pickle
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from types import TracebackType
from typing import Any, Literal, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from . import _abi, _saved, _single
from ._abi import Counters, TreeHandle, library
from ._arrays import mask_word, mask_words, named
from ._build import build_kdtree, build_tree, kdtree_options, tree_options
from ._camera import Camera, shape_of
from ._errors import check
from ._host import TileCounter
from ._lights import light_structs
from ._meshes import Meshes, in_32_bits
from ._outputs import given_hits, new_hit_lists, new_hits, occluded
from ._pool import pool_handle
from ._progress import Bar, pieces, wants_bar
from ._rays import Rays
from ._results import HitLists, Hits
from ._single import Hit
from .typing import (
    Faces,
    Isa,
    KdTreePreset,
    Lights,
    Masks,
    Meshes as ManyMeshes,
    Method,
    Numbers,
    Outputs,
    Path,
    Preset,
    Skips,
    Source,
    Threads,
    Vector,
    Vectors,
)


class TreeInfo(NamedTuple):
    """The build report."""

    structure: Literal["bvh", "kdtree"]  #: what the tree is: boxes, of Tree, or a kd-tree, of Tree.kdtree
    depth: int  #: inner nodes above the deepest leaf
    triangle_count: int  #: as given, left-out ones included
    non_finite_count: int  #: left out: a vertex is NaN or infinite
    zero_area_count: int  #: left out: the area is exactly zero
    node_count: int  #: inner nodes and leaves; of boxes: nodes, each of up to sixteen boxes
    leaf_count: int  #: empty ones included
    empty_leaf_count: int
    reference_count: int  #: entries of all leaves together
    retracted_count: int  #: subtrees turned back into leaves; of boxes: 0
    memory_size: int  #: bytes held by the tree
    peak_memory_size: int  #: bytes held at most at one time while building
    tree_hash: int  #: equal trees have equal hashes
    sah_cost: float  #: expected cost of a random ray: in triangle tests, of boxes: in nodes
    build_seconds: float
    bounds: NDArray[np.float32]  #: (2, 3): lower and upper corner; all 0 if there is no triangle


@lru_cache(maxsize=256)
def _shared_options(query: int, method: Method, isa: Isa, mask: int) -> Any:
    if query == _abi.QUERY_CLOSEST and method is None and isa is None and mask == 0:
        return None
    return ctypes.byref(_make_options(query, method, isa, mask))


def _make_options(query: int, method: Method, isa: Isa, mask: int) -> _abi.TraceOptions:
    numbers = named(method, _abi.METHODS, "method"), named(isa, _abi.ISAS, "isa")
    return _abi.TraceOptions(query=query, method=numbers[0], isa=numbers[1], mask=mask)


def _options(
    query: int,
    method: Method,
    isa: Isa,
    mask: int,
    pool: Threads,
    counters: Optional[Counters],
    lights: Any = None,
) -> Any:
    """A pointer to mlrt_trace_options, which keeps them alive, or None for defaults. lights: an array of mlrt_light."""
    if pool is None and counters is None and not lights:
        return _shared_options(query, method, isa, mask)
    options = _make_options(query, method, isa, mask)
    if pool is not None:
        options.handle = pool_handle(pool)  # kept as long as the options
        options.pool = options.handle.value
    if counters is not None:
        options.counters = ctypes.pointer(counters)
    if lights:
        options.lights, options.light_count = lights, len(lights)
    return ctypes.byref(options)


_ANY_HIT = _shared_options(_abi.QUERY_ANY, None, None, 0)


class Tree:
    """Triangles, and what finds them: boxes. It never changes: any number of threads may trace it at once, without the GIL.

    vertices: float32 (n, 3). faces: uint16, uint32 or int32 (m, 3), or None, then each three vertices in a row are a triangle.
    Other dtypes are copied; float64 is rounded to float32. The arrays may go when the tree is built.

    preset: "default", "fast" (built fastest, for scenes that change), "best" (built slowest, for many pictures of one scene).
    pool: a Pool that shares the work of building; the tree is the same. traversal_cost, intersection_cost: 0 = by itself. mlrt.h
    explains them. The paper's kd-tree is Tree.kdtree.

    mask: 32 bits; rays see the mesh if theirs has a bit in common; 0 = all bits. memory_limit: bytes held at one time at most, or
    it is an OutOfMemoryError, 0 = no limit (estimate_tree foresees them). progress: a bar, by tqdm; what is raised in it, or by
    Ctrl-C, ends the build. The logger "mlrt" gets a line for each tree, and warnings of triangles that were left out.

    Trees can be saved, loaded, and pickled; copies share the data.

    Usable in a `with` statement; otherwise the tree is freed with its last reference.
    """

    def __init__(
        self,
        vertices: Vectors,
        faces: Faces = None,
        *,
        mask: int = 0,
        preset: Preset = "default",
        pool: Threads = None,
        memory_limit: int = 0,
        traversal_cost: float = 0.0,
        intersection_cost: float = 0.0,
        progress: bool = False,
    ) -> None:
        self._handle: Optional[TreeHandle] = None
        options = tree_options(preset, pool, memory_limit, traversal_cost, intersection_cost)
        self._handle = build_tree(Meshes([(vertices, faces)], None, [mask]), options, progress)

    @classmethod
    def from_meshes(
        cls,
        meshes: ManyMeshes,
        ids: Optional[Sequence[int]] = None,
        masks: Optional[Sequence[int]] = None,
        *,
        preset: Preset = "default",
        pool: Threads = None,
        memory_limit: int = 0,
        traversal_cost: float = 0.0,
        intersection_cost: float = 0.0,
        progress: bool = False,
    ) -> Tree:
        """A tree over several meshes: each is (vertices, faces), or has attributes of these names.

        ids: what hits report as `mesh`, all different; None = 0, 1, 2, ...; or give a dictionary from ids to meshes. masks: of each mesh, 32 bits; rays see the meshes whose
        mask has a bit in common with theirs; 0 = all bits, as is None. Other options as for Tree.
        """
        options = tree_options(preset, pool, memory_limit, traversal_cost, intersection_cost)
        return cls._of(build_tree(Meshes.of(meshes, ids, masks), options, progress))

    @classmethod
    def kdtree(
        cls,
        vertices: Vectors,
        faces: Faces = None,
        *,
        mask: int = 0,
        preset: KdTreePreset = "paper",
        rules_off: Iterable[str] = (),
        max_depth: int = 0,
        max_references: int = 0,
        pool: Threads = None,
        memory_limit: int = 0,
        traversal_cost: float = 0.0,
        intersection_cost: float = 0.0,
        progress: bool = False,
    ) -> Tree:
        """The paper's kd-tree, whose rays the paper's method ("multilevel") traces if no other is named.

        It has the methods "packet2", "packet4", "multilevel" and "ray", where a Tree has "tile" and "ray"; the answers are the same.
        For study: it is slower to build and to trace.

        preset: "paper", or "tuned" (renders faster here, takes longer to build). rules_off: names out of "empty_space", "coplanar",
        "minimum_cell", "clipped_splits", "retraction". max_depth, max_references: 0 = by itself. Others as for Tree.
        """
        options = kdtree_options(
            preset, rules_off, max_depth, max_references, pool, memory_limit, traversal_cost, intersection_cost
        )
        return cls._of(build_kdtree(Meshes([(vertices, faces)], None, [mask]), options, progress))

    @classmethod
    def kdtree_from_meshes(
        cls,
        meshes: ManyMeshes,
        ids: Optional[Sequence[int]] = None,
        masks: Optional[Sequence[int]] = None,
        *,
        preset: KdTreePreset = "paper",
        rules_off: Iterable[str] = (),
        max_depth: int = 0,
        max_references: int = 0,
        pool: Threads = None,
        memory_limit: int = 0,
        traversal_cost: float = 0.0,
        intersection_cost: float = 0.0,
        progress: bool = False,
    ) -> Tree:
        """The paper's kd-tree over several meshes: as from_meshes, with the options of kdtree."""
        options = kdtree_options(
            preset, rules_off, max_depth, max_references, pool, memory_limit, traversal_cost, intersection_cost
        )
        return cls._of(build_kdtree(Meshes.of(meshes, ids, masks), options, progress))

    @classmethod
    def load(
        cls,
        source: Source,
        *,
        in_place: bool = True,
        geometry_hash: Optional[int] = None,
        memory_limit: int = 0,
    ) -> Tree:
        """The tree that `save` or `to_bytes` wrote, of the same structure. Anything else, or a damaged file, is a DataError.

        source: a path, or anything with a buffer of bytes in one piece: bytes, mmap, memoryview, an array.

        in_place: take next to no memory, and use the data where it lies. A file is mapped into memory, read-only, until the tree is
        closed or gone, and may be replaced or removed but not changed meanwhile (`save` replaces). A buffer is kept as long; one
        that can be written to (memoryview.toreadonly helps), or does not begin at a multiple of 64, is copied.
        geometry_hash: what mlrt.geometry_hash says the triangles are; others are a DataError; None = any.
        memory_limit: bytes that the tree may take of its own, or it is an OutOfMemoryError; 0 = no limit.
        """
        return cls._of(_saved.load(source, in_place, geometry_hash, memory_limit))

    @classmethod
    def _of(cls, handle: TreeHandle) -> Tree:
        tree = cls.__new__(cls)
        tree._handle = handle
        return tree

    def save(self, path: Path) -> None:
        """Writes the tree, triangles and all, to a file for `load`. A file of that name is replaced when the new one is whole."""
        _saved.write(path, _saved.saved_bytes(self._open_handle()))

    def to_bytes(self) -> bytes:
        """What `save` writes, for `load`."""
        return _saved.saved_bytes(self._open_handle()).tobytes()

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Pickles as what `to_bytes` gives; with protocol 5 and a buffer_callback without a copy."""
        data = _saved.saved_bytes(self._open_handle())
        content: Any = pickle.PickleBuffer(data.data) if protocol >= 5 else data.tobytes()
        return _restore, (type(self), content, {name: value for name, value in vars(self).items() if name != "_handle"})

    def __copy__(self) -> Tree:
        """Another one on the same data, which never changes: closing one of them leaves the other."""
        copy = self._of(self._open_handle())
        vars(copy).update({**vars(self), "_handle": copy._handle})
        return copy

    def __deepcopy__(self, memo: Any) -> Tree:
        return self.__copy__()

    def _open_handle(self) -> TreeHandle:
        if self._handle is None:
            raise ValueError("the tree is closed")
        return self._handle

    def close(self) -> None:
        """Frees the tree, as soon as no call uses it."""
        self._handle = None

    def __enter__(self) -> Tree:
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        """What it is, how large, and where."""
        if self._handle is None:
            return f"<{type(self).__name__}, closed>"
        info = self.info
        kind = "boxes" if info.structure == "bvh" else "a kd-tree"
        lower, upper = (", ".join(f"{number:.6g}" for number in corner) for corner in info.bounds)
        return (
            f"<{type(self).__name__} of {info.triangle_count} triangles: {kind} with {info.node_count} nodes, "
            f"{info.memory_size} bytes, from ({lower}) to ({upper})>"
        )

    @property
    def info(self) -> TreeInfo:
        """The build report."""
        info = _abi.TreeInfo()
        check(library.mlrt_get_tree_info(self._open_handle(), ctypes.byref(info)))
        numbers = {name: getattr(info, name) for name in TreeInfo._fields if name not in ("bounds", "structure")}
        structure: Any = _abi.STRUCTURES[info.structure]
        return TreeInfo(structure, bounds=np.array([info.bounds_min, info.bounds_max], np.float32), **numbers)

    def trace_ray(
        self,
        origin: Vector,
        direction: Vector,
        t_min: float = 0.0,
        t_max: Optional[float] = None,
        skip: Optional[tuple[int, int]] = None,
        *,
        mask: int = 0,
    ) -> Hit:
        """The closest hit of one ray, with t_min < t <= t_max, in numbers: the same bits as `trace`, in two thirds of the time.

        origin, direction: three numbers each, rounded to float32; t_max: None = no limit; skip: the mesh and the triangle that the
        ray passes; mask: as for `trace`. Holds the GIL. For more than a few rays, one call of `trace` is faster.
        """
        options = _shared_options(_abi.QUERY_CLOSEST, None, None, mask_word(mask, "mask")) if mask else None
        return _single.closest(self._handle or self._open_handle(), origin, direction, t_min, t_max, skip, options)

    def occluded_ray(
        self,
        origin: Vector,
        direction: Vector,
        t_min: float = 0.0,
        t_max: Optional[float] = None,
        skip: Optional[tuple[int, int]] = None,
        *,
        mask: int = 0,
    ) -> bool:
        """Whether one ray hits anything: arguments as for `trace_ray`."""
        options = _shared_options(_abi.QUERY_ANY, None, None, mask_word(mask, "mask")) if mask else _ANY_HIT
        return _single.occluded(self._handle or self._open_handle(), origin, direction, t_min, t_max, skip, options)

    def trace(
        self,
        origins: Vectors,
        directions: Vectors,
        t_min: Optional[Numbers] = None,
        t_max: Optional[Numbers] = None,
        skip: Skips = None,
        *,
        mask: Masks = None,
        outputs: Outputs = None,
        out: Optional[Hits] = None,
        row_length: int = 0,
        pool: Threads = None,
        method: Method = None,
        isa: Isa = None,
        counters: Optional[Counters] = None,
        progress: bool = False,
    ) -> Hits:
        """The closest hit of each ray, with t_min < t <= t_max.

        origins, directions: float32 (..., 3); t_min, t_max: float32 (...); skip: uint32 (..., 2), the mesh and triangle that a
        ray passes, -1 for none. They are broadcast against each other, and results have the common shape (...). Nothing is copied for
        that where one element serves all rays, or one of origins, t_min and skip all rays along the last axes: for k rays from each
        of m points give origins (m, 1, 3), directions (m, k, 3).

        mask: rays see the meshes whose mask has a bit in common with it, 0 = all bits, as is None. An int for all rays, or uint32
        (...), broadcast as well: a mask for each ray takes longer than one for all, where meshes have masks.

        outputs: names of the wanted fields of Hits, None = all. out: a Hits of arrays to write to instead, which share memory neither
        with each other nor with those of the rays.
        row_length: rays per row of a picture, a hint for speed; 0 = the length of the last of two or more axes, or for flat
        lists what they look like. float32 arrays whose numbers are packed and whose strides are positive are read where they are,
        others are copied once. Without the GIL.
        method, isa: how to trace. They never change the results. A method of the other structure (Tree.kdtree) is an
        UnsupportedError. progress: a bar, by tqdm, moves while rays are traced.
        """
        tree = self._handle or self._open_handle()
        if (
            (mask is None or mask.__class__ is int)
            and out is None
            and pool is None
            and method is None
            and isa is None
            and counters is None
            and not row_length
            and not progress
        ):
            shared = _shared_options(_abi.QUERY_CLOSEST, None, None, mask_word(mask, "mask")) if mask else None
            hits = _single.closest_in_arrays(tree, origins, directions, t_min, t_max, skip, shared, outputs)
            if hits is not None:
                hits._rays = origins, directions
                return hits
        one_mask, masks = (0, None) if mask is None else mask_words(mask)
        rays = Rays(origins, directions, t_min, t_max, skip, row_length, masks)
        if out is None:
            out, packed = new_hits(outputs, rays.shape)
        else:
            packed = given_hits(out, rays.shape, rows=False, read=rays.arrays)
        options = _options(_abi.QUERY_CLOSEST, method, isa, one_mask, pool, counters)
        out._rays = origins, directions  # also if the caller's knows others: its arrays are about to be written
        if wants_bar(progress):
            _trace_pieces(library.mlrt_trace_packet, tree, rays, options, packed, _abi.Hits, pool)
            return out
        status = library.mlrt_trace_packet(tree, rays.packed, options, packed)
        if status:
            check(status)
        return out

    def occluded(
        self,
        origins: Vectors,
        directions: Vectors,
        t_min: Optional[Numbers] = None,
        t_max: Optional[Numbers] = None,
        skip: Skips = None,
        *,
        mask: Masks = None,
        out: Optional[np.ndarray] = None,
        row_length: int = 0,
        pool: Threads = None,
        method: Method = None,
        isa: Isa = None,
        counters: Optional[Counters] = None,
        progress: bool = False,
    ) -> NDArray[np.bool_]:
        """Whether each ray hits anything: bool (...). Faster than `trace`, arguments as there; out: bool or uint8 (...)."""
        tree = self._handle or self._open_handle()
        if (
            (mask is None or mask.__class__ is int)
            and out is None
            and pool is None
            and method is None
            and isa is None
            and counters is None
            and not row_length
            and not progress
        ):
            shared = _shared_options(_abi.QUERY_ANY, None, None, mask_word(mask, "mask")) if mask else _ANY_HIT
            found = _single.occluded_in_array(tree, origins, directions, t_min, t_max, skip, shared)
            if found is not None:
                return found
        one_mask, masks = (0, None) if mask is None else mask_words(mask)
        rays = Rays(origins, directions, t_min, t_max, skip, row_length, masks)
        out, packed = occluded(out, rays.shape, rays.arrays)
        options = _options(_abi.QUERY_ANY, method, isa, one_mask, pool, counters)
        if wants_bar(progress):
            _trace_pieces(library.mlrt_trace_packet, tree, rays, options, packed, _abi.Hits, pool)
            return out
        status = library.mlrt_trace_packet(tree, rays.packed, options, packed)
        if status:
            check(status)
        return out

    def hits(
        self,
        origins: Vectors,
        directions: Vectors,
        k: int,
        t_min: Optional[Numbers] = None,
        t_max: Optional[Numbers] = None,
        skip: Skips = None,
        *,
        mask: Masks = None,
        outputs: Outputs = None,
        row_length: int = 0,
        pool: Threads = None,
        counters: Optional[Counters] = None,
        progress: bool = False,
    ) -> HitLists:
        """The k nearest hits of each ray, nearest first, and how many it has in all; k = 0: only how many.

        A ray through an edge or a corner hits each triangle there. `crossing` and `crossing_total` count such a place once if
        the ray goes through the surface, and not if it only touches it. Other arguments as for `trace`.
        """
        tree = self._handle or self._open_handle()
        one_mask, masks = (0, None) if mask is None else mask_words(mask)
        rays = Rays(origins, directions, t_min, t_max, skip, row_length, masks)
        lists, packed = new_hit_lists(outputs, rays.shape, in_32_bits(k, "k"))
        options = _options(_abi.QUERY_CLOSEST, None, None, one_mask, pool, counters)
        if wants_bar(progress):
            _trace_pieces(library.mlrt_trace_all_hits, tree, rays, options, packed, _abi.HitLists, pool)
            return lists
        check(library.mlrt_trace_all_hits(tree, rays.packed, options, packed))
        return lists

    def contains(
        self,
        points: Vectors,
        direction: Vectors = (0.0, 0.0, 1.0),
        *,
        mask: Masks = None,
        pool: Threads = None,
    ) -> NDArray[np.bool_]:
        """Whether each point, float32 (..., 3), is inside of a closed mesh: bool (...).

        Exact for points that do not lie on the surface, for any direction: a ray from the point crosses the surface an odd
        number of times. Nested closed meshes alternate between inside and outside. mask: as for `trace`.
        """
        lists = self.hits(points, direction, 0, outputs="crossing_total", mask=mask, pool=pool)
        return np.asarray(lists.crossing_total & 1, np.bool_)

    def render(
        self,
        camera: Camera,
        *,
        lights: Lights = None,
        mask: int = 0,
        outputs: Outputs = None,
        out: Optional[Hits] = None,
        pool: Threads = None,
        method: Method = None,
        isa: Isa = None,
        counters: Optional[Counters] = None,
        progress: bool = False,
    ) -> Hits:
        """The closest hit of each pixel's ray: arrays of shape (height, width). The same bits as `trace(*camera.rays())`.

        Faster than that, since no rays are stored and whole tiles are traced as beams. Arguments as for `trace`, but that arrays in
        `out` may also be windows of larger pictures, and `mask` is one for all.

        lights: up to eight, each a point (3,) or a DirectionalLight. With them there is one more output, `occluded`, uint8 (height,
        width): bit k says that light k does not reach what the pixel sees, since something lies between, or since it is not on that
        side of the triangle which is seen; a miss has 0. `Hits.shadow(k)` is that bit as bool. No triangle shades itself, and there
        is no epsilon: mlrt.h ("Shadows of a picture") says what the rays are. They see the meshes that `mask` says.
        """
        tree = self._open_handle()
        struct = camera.to_struct()
        shape = shape_of(struct)
        structs = None if lights is None else light_structs(lights)
        light_count = None if structs is None else len(structs)
        if out is None:
            out, packed = new_hits(outputs, shape, light_count)
        else:
            packed = given_hits(out, shape, rows=True, lights=light_count)
        if light_count == 0 and out.occluded is not None and all(array is None for array in out[:-1]):
            return out  # no light has shadows, and nothing else is asked for
        options = _options(_abi.QUERY_CLOSEST, method, isa, mask_word(mask, "mask"), pool, counters, structs)
        out._rays = replace(camera).rays  # as in trace
        if not wants_bar(progress):
            check(library.mlrt_render_tiles(tree, ctypes.byref(struct), options, packed, None, None))
            return out
        with Bar(shape[0] * shape[1], "pixels") as bar:
            with TileCounter(bar) as counter:
                status = library.mlrt_render_tiles(tree, ctypes.byref(struct), options, packed, counter.callback, None)
            check(status)
        return out


def _trace_pieces(
    function: Any, tree: TreeHandle, rays: Rays, options: Any, results: bytes, kind: type[_abi.Struct], pool: Threads
) -> None:
    """A call of mlrt_trace_packet or mlrt_trace_all_hits as several, with a bar."""
    with Bar(rays.count, "rays") as bar:
        for count, some_rays, some_results in pieces(rays.packed, results, kind, pool is not None):
            check(function(tree, some_rays, options, some_results))
            bar.add(count)


def _restore(kind: type[Tree], data: Any, state: dict[str, Any]) -> Tree:
    """Unpickles."""
    tree = kind.load(data)
    vars(tree).update(state)
    return tree
