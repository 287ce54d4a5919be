# SPDX-License-Identifier: MIT
"""Trees of triangles, and the questions that can be asked of them."""

import ctypes
from collections.abc import Iterable, Sequence
from functools import lru_cache
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Optional, TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _abi
from ._abi import Counters, TreeHandle, library
from ._arrays import elements, faces as face_array, vectors
from ._camera import Camera
from ._errors import check
from ._outputs import given_hits, new_hit_lists, new_hits, occluded
from ._pool import Pool
from ._progress import Bar, TileCounter, pieces
from ._rays import Rays
from ._results import HitLists, Hits

if TYPE_CHECKING:  # in typing since Python 3.11
    from typing_extensions import Unpack

Method = Literal["ray", "packet2", "packet4", "multilevel", "tile"]
Isa = Literal["scalar", "sse", "avx2", "avx512"]
Preset = Literal["default", "paper", "fast", "best"]
Structure = Literal["kdtree", "bvh"]

MESSAGE_SIZE = 256


class TreeInfo(NamedTuple):
    """The build report: of the kd-tree if there is one, else of the hierarchy of boxes."""

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


class BuildSettings(TypedDict, total=False):
    """What Tree and Tree.from_meshes take by name."""

    preset: Preset
    rules_off: Iterable[str]
    max_depth: int
    max_references: int
    traversal_cost: float
    intersection_cost: float
    structures: Union[None, Structure, Iterable[Structure]]
    pool: Optional[Pool]


def _named(value: Any, names: dict[Any, int], what: str) -> int:
    try:
        return names[value]
    except (KeyError, TypeError):
        raise ValueError(f"{what}: {value!r} is none of {', '.join(map(repr, names))}") from None


def _structures(given: Union[None, Structure, Iterable[Structure]]) -> int:
    words = (given,) if isinstance(given, str) else given or ()
    return sum({_named(word, _abi.STRUCTURES, "structures") for word in words})


@lru_cache(maxsize=None)
def _shared_options(query: int, method: Optional[Method], isa: Optional[Isa]) -> Any:
    if query == _abi.QUERY_CLOSEST and method is None and isa is None:
        return None
    return ctypes.byref(_make_options(query, method, isa))


def _make_options(query: int, method: Optional[Method], isa: Optional[Isa]) -> _abi.TraceOptions:
    return _abi.TraceOptions(
        query=query, method=_named(method, _abi.METHODS, "method"), isa=_named(isa, _abi.ISAS, "isa")
    )


def _options(
    query: int, method: Optional[Method], isa: Optional[Isa], pool: Optional[Pool], counters: Optional[Counters]
) -> Any:
    """A pointer to mlrt_trace_options, which keeps them alive, or None for defaults."""
    if pool is None and counters is None:
        return _shared_options(query, method, isa)
    options = _make_options(query, method, isa)
    if pool is not None:
        options.handle = pool.handle()  # kept as long as the options
        options.pool = options.handle.value
    if counters is not None:
        options.counters = ctypes.pointer(counters)
    return ctypes.byref(options)


class Tree:
    """Triangles, and what finds them. It never changes: any number of threads may trace it at once, without the GIL.

    vertices: float32 (n, 3). faces: uint16, uint32 or int32 (m, 3), or None, then each three vertices in a row are a triangle.
    Other dtypes are copied; float64 is rounded to float32. The arrays may go when the tree is built.

    preset: "default", "fast" (built fastest, for scenes that change), "best" (built slowest, for many pictures of one scene),
    "paper" (the paper's kind of kd-tree). pool: a Pool that shares the work of building; the tree is the same. structures: what
    to search in, "bvh" (a hierarchy of boxes: methods "tile" and "ray"), "kdtree" (all methods but "tile"), or both of them;
    None = by the preset. traversal_cost, intersection_cost: 0 = by itself. mlrt.h explains them.

    For kd-trees only: rules_off, names out of "empty_space", "coplanar", "minimum_cell", "clipped_splits", "retraction";
    max_depth, max_references, 0 = by itself.

    Usable in a `with` statement; otherwise the tree is freed with its last reference.
    """

    def __init__(self, vertices: ArrayLike, faces: Optional[ArrayLike] = None, **options: "Unpack[BuildSettings]") -> None:
        self._build([(vertices, faces)], None, **options)

    @classmethod
    def from_meshes(
        cls, meshes: Iterable[Any], ids: Optional[Sequence[int]] = None, **options: "Unpack[BuildSettings]"
    ) -> "Tree":
        """A tree over several meshes: each is (vertices, faces), or has attributes of these names.

        ids: what hits report as `mesh`, all different; None = 0, 1, 2, ... Other options as for Tree.
        """
        tree = cls.__new__(cls)
        tree._build([_parts(mesh) for mesh in meshes], ids, **options)
        return tree

    def _build(
        self,
        meshes: Sequence[tuple[Any, Any]],
        ids: Optional[Sequence[int]],
        *,
        preset: Preset = "default",
        rules_off: Iterable[str] = (),
        max_depth: int = 0,
        max_references: int = 0,
        traversal_cost: float = 0.0,
        intersection_cost: float = 0.0,
        structures: Union[None, Structure, Iterable[Structure]] = None,
        pool: Optional[Pool] = None,
    ) -> None:
        self._handle: Optional[TreeHandle] = None
        if ids is not None and len(ids) != len(meshes):
            raise ValueError(f"ids: {len(meshes)} are needed, not {len(ids)}")
        structs = (_abi.Mesh * len(meshes))()
        alive = [_fill_mesh(struct, *mesh) for struct, mesh in zip(structs, meshes)]
        for struct, number in zip(structs, ids or ()):
            struct.id = _in_32_bits(number, "ids")
        message = ctypes.create_string_buffer(MESSAGE_SIZE)
        options = _abi.BuildOptions(
            preset=_named(preset, _abi.PRESETS, "preset"),
            rules_off=sum({_named(rule, _abi.RULES, "rules_off") for rule in rules_off}),
            max_depth=_in_32_bits(max_depth, "max_depth"),
            max_references=max_references,
            traversal_cost=traversal_cost,
            intersection_cost=intersection_cost,
            message=ctypes.addressof(message),
            message_size=MESSAGE_SIZE,
            structures=_structures(structures),
        )
        threads = None if pool is None else pool.handle()
        if threads is not None:
            options.pool = threads.value
        handle = TreeHandle()
        status = library.mlrt_build_kdtree(structs, len(meshes), ctypes.byref(options), ctypes.byref(handle))
        check(status, message.value.decode())
        del alive, threads
        self._handle = handle

    def _open_handle(self) -> TreeHandle:
        if self._handle is None:
            raise ValueError("the tree is closed")
        return self._handle

    def close(self) -> None:
        """Frees the tree, as soon as no call uses it."""
        self._handle = None

    def __enter__(self) -> "Tree":
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    @property
    def info(self) -> TreeInfo:
        """The build report."""
        info = _abi.TreeInfo()
        check(library.mlrt_get_tree_info(self._open_handle(), ctypes.byref(info)))
        numbers = {name: getattr(info, name) for name in TreeInfo._fields if name != "bounds"}
        return TreeInfo(bounds=np.array([info.bounds_min, info.bounds_max], np.float32), **numbers)

    def trace(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: Optional[ArrayLike] = None,
        t_max: Optional[ArrayLike] = None,
        skip: Optional[ArrayLike] = None,
        *,
        outputs: Optional[Iterable[str]] = None,
        out: Optional[Hits] = None,
        row_length: int = 0,
        pool: Optional[Pool] = None,
        method: Optional[Method] = None,
        isa: Optional[Isa] = None,
        counters: Optional[Counters] = None,
        progress: bool = False,
    ) -> Hits:
        """The closest hit of each ray, with t_min < t <= t_max.

        origins, directions: float32 (..., 3); t_min, t_max: float32 (...); skip: uint32 (..., 2), the mesh and triangle that a
        ray passes, -1 for none. They are broadcast against each other, and results have the common shape (...).

        outputs: names of the wanted fields of Hits, None = all. out: a Hits of arrays to write to instead.
        row_length: rays per row of a picture, a hint for speed; 0 = the length of the last of two or more axes, or for long flat
        lists what they look like. float32 arrays whose numbers are packed and whose strides are positive are read where they are,
        others are copied once. Without the GIL.
        method, isa: how to trace. They never change the results. A method that needs a structure the tree does not have is an
        UnsupportedError. progress: a bar, by tqdm, moves while rays are traced.
        """
        tree = self._open_handle()
        rays = Rays(origins, directions, t_min, t_max, skip, row_length)
        if out is None:
            out, packed = new_hits(outputs, rays.shape)
        else:
            packed = given_hits(out, rays.shape, rows=False)
        options = _options(_abi.QUERY_CLOSEST, method, isa, pool, counters)
        if progress:
            _trace_pieces(library.mlrt_trace_packet, tree, rays, options, packed, _abi.Hits, pool)
            return out
        status = library.mlrt_trace_packet(tree, rays.packed, options, packed)
        if status:
            check(status)
        return out

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        t_min: Optional[ArrayLike] = None,
        t_max: Optional[ArrayLike] = None,
        skip: Optional[ArrayLike] = None,
        *,
        out: Optional[np.ndarray] = None,
        row_length: int = 0,
        pool: Optional[Pool] = None,
        method: Optional[Method] = None,
        isa: Optional[Isa] = None,
        counters: Optional[Counters] = None,
        progress: bool = False,
    ) -> NDArray[np.bool_]:
        """Whether each ray hits anything: bool (...). Faster than `trace`, arguments as there; out: bool or uint8 (...)."""
        tree = self._open_handle()
        rays = Rays(origins, directions, t_min, t_max, skip, row_length)
        out, packed = occluded(out, rays.shape)
        options = _options(_abi.QUERY_ANY, method, isa, pool, counters)
        if progress:
            _trace_pieces(library.mlrt_trace_packet, tree, rays, options, packed, _abi.Hits, pool)
            return out
        status = library.mlrt_trace_packet(tree, rays.packed, options, packed)
        if status:
            check(status)
        return out

    def hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        k: int,
        t_min: Optional[ArrayLike] = None,
        t_max: Optional[ArrayLike] = None,
        skip: Optional[ArrayLike] = None,
        *,
        outputs: Optional[Iterable[str]] = None,
        row_length: int = 0,
        pool: Optional[Pool] = None,
        counters: Optional[Counters] = None,
        progress: bool = False,
    ) -> HitLists:
        """The k nearest hits of each ray, nearest first, and how many it has in all; k = 0: only how many.

        A ray through an edge or a corner hits each triangle there. `crossing` and `crossing_total` count such a place once if
        the ray goes through the surface, and not if it only touches it. Other arguments as for `trace`.
        """
        tree = self._open_handle()
        rays = Rays(origins, directions, t_min, t_max, skip, row_length)
        lists, packed = new_hit_lists(outputs, rays.shape, _in_32_bits(k, "k"))
        options = _options(_abi.QUERY_CLOSEST, None, None, pool, counters)
        if progress:
            _trace_pieces(library.mlrt_trace_all_hits, tree, rays, options, packed, _abi.HitLists, pool)
            return lists
        check(library.mlrt_trace_all_hits(tree, rays.packed, options, packed))
        return lists

    def contains(
        self, points: ArrayLike, direction: ArrayLike = (0.0, 0.0, 1.0), *, pool: Optional[Pool] = None
    ) -> NDArray[np.bool_]:
        """Whether each point, float32 (..., 3), is inside of a closed mesh: bool (...).

        Exact for points that do not lie on the surface, for any direction: a ray from the point crosses the surface an odd
        number of times. Nested closed meshes alternate between inside and outside.
        """
        lists = self.hits(points, direction, 0, outputs="crossing_total", pool=pool)
        return np.asarray(lists.crossing_total & 1, np.bool_)

    def render(
        self,
        camera: Camera,
        *,
        outputs: Optional[Iterable[str]] = None,
        out: Optional[Hits] = None,
        pool: Optional[Pool] = None,
        method: Optional[Method] = None,
        isa: Optional[Isa] = None,
        counters: Optional[Counters] = None,
        progress: bool = False,
    ) -> Hits:
        """The closest hit of each pixel's ray: arrays of shape (height, width). The same bits as `trace(*camera.rays())`.

        Faster than that, since no rays are stored and whole tiles are traced as beams. Arguments as for `trace`, but that arrays in
        `out` may also be windows of larger pictures.
        """
        tree = self._open_handle()
        struct, shape = camera.to_struct(), camera.check_shape()
        if out is None:
            out, packed = new_hits(outputs, shape)
        else:
            packed = given_hits(out, shape, rows=True)
        options = _options(_abi.QUERY_CLOSEST, method, isa, pool, counters)
        if not progress:
            check(library.mlrt_render_tiles(tree, ctypes.byref(struct), options, packed, None, None))
            return out
        with Bar(shape[0] * shape[1], "pixels") as bar:
            counter = TileCounter(bar)
            status = library.mlrt_render_tiles(tree, ctypes.byref(struct), options, packed, counter.callback, None)
            counter.raise_error()
            check(status)
        return out


def _trace_pieces(
    function: Any, tree: TreeHandle, rays: Rays, options: Any, results: bytes, kind: type[_abi.Struct], pool: Optional[Pool]
) -> None:
    """A call of mlrt_trace_packet or mlrt_trace_all_hits as several, with a bar."""
    with Bar(rays.count, "rays") as bar:
        for count, some_rays, some_results in pieces(rays.packed, results, kind, pool is not None):
            check(function(tree, some_rays, options, some_results))
            bar.add(count)


def _parts(mesh: Any) -> tuple[Any, Any]:
    """Vertices and faces of (vertices, faces), or of an object that has them."""
    if hasattr(mesh, "vertices"):
        return mesh.vertices, mesh.faces
    vertices, faces = mesh
    return vertices, faces


def _in_32_bits(number: int, what: str) -> int:
    if not 0 <= number <= _abi.NONE:
        raise ValueError(f"{what}: {number} does not fit into 32 bits")
    return int(number)


def _fill_mesh(struct: _abi.Mesh, vertices: Any, faces: Any) -> list[np.ndarray]:
    """Fills an mlrt_mesh; returns the arrays that must live as long as it."""
    vertices = vectors(vertices, "vertices")
    if faces is None:
        vertices = vertices.reshape(-1, 3)
    if vertices.ndim != 2:
        raise ValueError(f"vertices: the shape must be (n, 3), not {vertices.shape}")
    struct.struct_size = ctypes.sizeof(struct)
    struct.vertex_count = len(vertices)
    vertices, struct.vertices, struct.vertex_stride = _apart(vertices)
    if faces is None:
        struct.triangle_count = len(vertices) // 3
        return [vertices]
    faces = face_array(faces)
    struct.triangle_count, struct.index_size = len(faces), faces.itemsize
    faces, struct.indices, struct.triangle_stride = _apart(faces)
    return [vertices, faces]


def _apart(array: np.ndarray) -> tuple[np.ndarray, int, int]:
    """As `elements`, for arrays whose elements may not overlap."""
    if array.strides[0] < 3 * array.itemsize:
        array = np.ascontiguousarray(array)
    return elements(array, 3)
