# SPDX-License-Identifier: MIT
"""mlrt.h in ctypes: its constants, structs and functions, under the names they have there.

Structs that every call needs are written with `_packer`, which takes the layout from the ctypes class: filling one ctypes
struct of twenty fields takes 3 us, packing it 0.15 us.
"""

import ctypes
import struct
from collections.abc import Callable
from ctypes import POINTER, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint32, c_uint64, c_void_p
from functools import partial
from typing import Any

from . import _library

NONE = 0xFFFFFFFF
STRIDE_ALL = c_size_t(-1).value

PRESETS = {"default": 0, "fast": 1, "best": 2}
KDTREE_PRESETS = {"paper": 0, "tuned": 1}
STRUCTURES = {1: "kdtree", 2: "bvh"}
RULES = {"empty_space": 1, "coplanar": 2, "minimum_cell": 4, "clipped_splits": 8, "retraction": 16}
METHODS = {None: 0, "ray": 1, "packet2": 2, "packet4": 3, "multilevel": 4, "tile": 5}
ISAS = {None: 0, "scalar": 1, "sse": 2, "avx2": 3, "avx512": 4, "neon": 5}
PROJECTIONS = {"pinhole": 0, "parallel": 1}
QUERY_CLOSEST, QUERY_ANY = 0, 1
LIGHT_POINT, LIGHT_DIRECTIONAL = 0, 1
LIGHT_LIMIT = 8
CAPABILITIES = {"sse": 1, "avx2": 2, "avx512": 4, "neon": 8}
LOAD_IN_PLACE = 1
LOG_ERROR, LOG_WARNING, LOG_INFO = 0, 1, 2

Float3 = c_float * 3


class Struct(ctypes.Structure):
    """A struct of the interface: sets its struct_size; fields are given by name, the rest is zero."""

    def __init__(self, **fields: Any) -> None:
        super().__init__(struct_size=ctypes.sizeof(self), **fields)


class Host(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("user", c_void_p),
        ("allocate", c_void_p),
        ("free", c_void_p),
        ("log", c_void_p),
        ("progress", c_void_p),
    ]


LogCallback = ctypes.CFUNCTYPE(None, c_void_p, c_int32, c_char_p)
ProgressCallback = ctypes.CFUNCTYPE(c_int32, c_void_p, c_double)


class Mesh(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("id", c_uint32),
        ("vertices", c_void_p),
        ("vertex_count", c_size_t),
        ("vertex_stride", c_size_t),
        ("indices", c_void_p),
        ("triangle_count", c_size_t),
        ("triangle_stride", c_size_t),
        ("index_size", c_uint32),
        ("mask", c_uint32),
    ]


class TreeOptions(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("preset", c_int32),
        ("traversal_cost", c_float),
        ("intersection_cost", c_float),
        ("message", c_void_p),
        ("message_size", c_size_t),
        ("host", c_void_p),
        ("memory_limit", c_uint64),
        ("pool", c_void_p),
    ]


class KdTreeOptions(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("preset", c_int32),
        ("traversal_cost", c_float),
        ("intersection_cost", c_float),
        ("message", c_void_p),
        ("message_size", c_size_t),
        ("host", c_void_p),
        ("memory_limit", c_uint64),
        ("max_references", c_uint64),
        ("max_depth", c_uint32),
        ("rules_off", c_uint32),
        ("pool", c_void_p),
    ]


class MemoryEstimate(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("memory_size", c_uint64),
        ("peak_memory_size", c_uint64),
    ]


class LoadOptions(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("flags", c_uint32),
        ("geometry_hash", c_uint64),
        ("memory_limit", c_uint64),
        ("message", c_void_p),
        ("message_size", c_size_t),
        ("host", c_void_p),
    ]


class TreeInfo(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("depth", c_uint32),
        ("triangle_count", c_uint64),
        ("non_finite_count", c_uint64),
        ("zero_area_count", c_uint64),
        ("node_count", c_uint64),
        ("leaf_count", c_uint64),
        ("empty_leaf_count", c_uint64),
        ("reference_count", c_uint64),
        ("retracted_count", c_uint64),
        ("memory_size", c_uint64),
        ("peak_memory_size", c_uint64),
        ("tree_hash", c_uint64),
        ("sah_cost", c_double),
        ("build_seconds", c_double),
        ("bounds_min", Float3),
        ("bounds_max", Float3),
        ("structure", c_uint32),
        ("reserved", c_uint32),
    ]


class Counters(Struct):
    """What traversal did; calls given it in `counters` add to its fields, which mlrt.h explains."""

    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32)] + [
        (name, c_uint64)
        for name in (
            "ray_count",
            "packet_count",
            "beam_count",
            "cell_count",
            "entry_point_cell_count",
            "triangle_test_count",
            "judged_lane_count",
            "entry_point_count",
            "entry_point_depth_sum",
            "missed_beam_count",
            "covered_beam_count",
            "undecided_cull_count",
            "undecided_checked_count",
            "lane_test_count",
            "undecided_test_count",
            "tie_lane_count",
            "exact_edge_count",
            "exact_range_count",
            "exact_order_count",
        )
    ]

    def __repr__(self) -> str:
        """The counters that are not 0."""
        counts = ((field[0], getattr(self, field[0])) for field in self._fields_[2:])
        return f"<Counters: {', '.join(f'{name}={count}' for name, count in counts if count) or 'all 0'}>"


class Light(Struct):
    _fields_ = [("struct_size", c_uint32), ("kind", c_int32), ("position", Float3)]


class TraceOptions(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("query", c_int32),
        ("method", c_int32),
        ("isa", c_int32),
        ("culling", c_int32),
        ("culling_check", c_uint32),
        ("initial_tile_size", c_uint32),
        ("minimum_tile_size", c_uint32),
        ("split_factor", c_uint32),
        ("outputs", c_uint32),
        ("shortcuts_off", c_uint32),
        ("mask", c_uint32),
        ("pool", c_void_p),
        ("counters", POINTER(Counters)),
        ("host", c_void_p),
        ("lights", POINTER(Light)),
        ("light_count", c_uint32),
        ("reserved", c_uint32),
    ]


class Array(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("stride", c_size_t), ("row_stride", c_size_t)]


class ConstArray(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("stride", c_size_t)]


class Hits(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("t", Array),
        ("u", Array),
        ("v", Array),
        ("mesh", Array),
        ("triangle", Array),
        ("facing", Array),
        ("occluded", Array),
    ]


class Rays(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("row_length", c_uint32),
        ("count", c_size_t),
        ("origins", ConstArray),
        ("directions", ConstArray),
        ("t_min", ConstArray),
        ("t_max", ConstArray),
        ("skip", ConstArray),
        ("mask", ConstArray),
        ("rays_per_origin", c_uint32),
        ("reserved", c_uint32),
    ]


class HitLists(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("capacity", c_uint32),
        ("t", Array),
        ("u", Array),
        ("v", Array),
        ("mesh", Array),
        ("triangle", Array),
        ("facing", Array),
        ("crossing", Array),
        ("total", Array),
        ("crossing_total", Array),
    ]


class Camera(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("projection", c_int32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("crop_x", c_uint32),
        ("crop_y", c_uint32),
        ("crop_width", c_uint32),
        ("crop_height", c_uint32),
        ("eye", Float3),
        ("direction", Float3),
        ("d00", Float3),
        ("dx", Float3),
        ("dy", Float3),
        ("sample_x", c_float),
        ("sample_y", c_float),
        ("t_min", c_float),
        ("t_max", c_float),
    ]


class Tile(Struct):
    _fields_ = [
        ("struct_size", c_uint32),
        ("worker", c_uint32),
        ("x", c_uint32),
        ("y", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("t", c_void_p),
        ("u", c_void_p),
        ("v", c_void_p),
        ("mesh", c_void_p),
        ("triangle", c_void_p),
        ("facing", c_void_p),
        ("occluded", c_void_p),
    ]


TileCallback = ctypes.CFUNCTYPE(c_int32, c_void_p, POINTER(Tile))

# Bytes of the elements of arrays: what stride 0 stands for.
ELEMENT_SIZES = {
    "origins": 12,
    "directions": 12,
    "t_min": 4,
    "t_max": 4,
    "skip": 8,
    "mask": 4,
    "t": 4,
    "u": 4,
    "v": 4,
    "mesh": 4,
    "triangle": 4,
    "facing": 4,
    "occluded": 1,
    "crossing": 1,
    "total": 4,
    "crossing_total": 4,
}


_LETTERS: dict[Any, str] = {c_uint32: "I", c_int32: "i", c_size_t: "N", c_void_p: "P"}


def _letters(structure: Any, plain: bool) -> str:
    if plain and structure is Array:
        return f"P{ctypes.sizeof(Array) - ctypes.sizeof(c_void_p)}x"
    return "".join(_LETTERS.get(kind) or _letters(kind, plain) for _, kind in structure._fields_)


def _packer(structure: type[Struct], plain: bool = False) -> Callable[..., bytes]:
    """Writes a Struct as bytes, from the values of its leaves in order, the struct_size left out.

    plain: strides of arrays of results are left out, too, and 0.
    """
    layout = struct.Struct("@" + _letters(structure, plain))
    assert layout.size == ctypes.sizeof(structure), structure
    return partial(layout.pack, layout.size)


pack_rays = _packer(Rays)
pack_hits = _packer(Hits)
pack_plain_hits = _packer(Hits, plain=True)
pack_hit_lists = _packer(HitLists)

# Where mlrt_struct_sizes has the sizes of the structs here: MLRT_STRUCT_*.
STRUCT_NUMBERS: dict[Any, int] = {
    Host: 0,
    Mesh: 1,
    TreeOptions: 2,
    TreeInfo: 3,
    MemoryEstimate: 4,
    LoadOptions: 5,
    Counters: 7,
    TraceOptions: 8,
    Array: 9,
    Hits: 10,
    ConstArray: 11,
    Rays: 12,
    HitLists: 15,
    Camera: 16,
    Tile: 17,
    Light: 18,
    KdTreeOptions: 20,
}

# Structs go in as pointers (or as bytes), handles as addresses.
_FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {
    "mlrt_version": (c_uint32, []),
    "mlrt_capabilities": (c_uint64, []),
    "mlrt_struct_sizes": (None, [c_void_p, c_uint32]),
    "mlrt_status_string": (c_char_p, [c_int32]),
    "mlrt_last_message": (c_char_p, []),
    "mlrt_build_tree": (c_int32, [c_void_p, c_size_t, c_void_p, c_void_p]),
    "mlrt_build_kdtree": (c_int32, [c_void_p, c_size_t, c_void_p, c_void_p]),
    "mlrt_estimate_tree": (c_int32, [c_void_p, c_size_t, c_void_p, c_void_p]),
    "mlrt_estimate_kdtree": (c_int32, [c_void_p, c_size_t, c_void_p, c_void_p]),
    "mlrt_hash_geometry": (c_int32, [c_void_p, c_size_t, c_void_p]),
    "mlrt_save_tree": (c_int32, [c_void_p, c_void_p, c_size_t, c_void_p]),
    "mlrt_load_tree": (c_int32, [c_void_p, c_size_t, c_void_p, c_void_p]),
    "mlrt_destroy_tree": (None, [c_void_p]),
    "mlrt_get_tree_info": (c_int32, [c_void_p, c_void_p]),
    "mlrt_create_pool": (c_int32, [c_uint32, c_void_p]),
    "mlrt_pool_thread_count": (c_uint32, [c_void_p]),
    "mlrt_destroy_pool": (None, [c_void_p]),
    "mlrt_trace_packet": (c_int32, [c_void_p, c_void_p, c_void_p, c_void_p]),
    "mlrt_trace_all_hits": (c_int32, [c_void_p, c_void_p, c_void_p, c_void_p]),
    "mlrt_render_tiles": (c_int32, [c_void_p, c_void_p, c_void_p, c_void_p, c_void_p, c_void_p]),
    "mlrt_camera_rays": (c_int32, [c_void_p, c_void_p, c_void_p]),
}


def _declare(library: ctypes.CDLL) -> ctypes.CDLL:
    for name, (result, arguments) in _FUNCTIONS.items():
        try:
            function = getattr(library, name)
        except AttributeError as error:
            raise ImportError(f"{library._name} is too old for this package: it has no {name}") from error
        function.restype, function.argtypes = result, arguments
    for structure, size in struct_sizes(library).items():
        if size < ctypes.sizeof(structure):
            raise ImportError(f"{library._name} is too old for this package: its mlrt_{structure.__name__} is too small")
    return library


def struct_sizes(library: ctypes.CDLL) -> dict[Any, int]:
    """How large the structs here are to the library. It may be newer, and know larger ones: they only ever grow."""
    sizes = (c_uint32 * (max(STRUCT_NUMBERS.values()) + 1))()
    library.mlrt_struct_sizes(sizes, len(sizes))
    return {structure: sizes[number] for structure, number in STRUCT_NUMBERS.items()}


library = _declare(_library.load())


class Handle(c_void_p):
    """What the library made, and one object alone destroys: ctypes would copy and pickle the address."""

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise TypeError(f"{type(self).__name__}: it can neither be copied nor pickled")


class TreeHandle(Handle):
    """An mlrt_tree; destroyed with the last reference to it, so never while a call that holds one runs."""

    # What it was loaded from and lies in, if it does: goes when the tree is destroyed, not before.
    data: Any = None

    def __del__(self, destroy: Any = library.mlrt_destroy_tree) -> None:
        destroy(self)


class PoolHandle(Handle):
    """An mlrt_pool; destroyed with the last reference to it."""

    # The process whose threads these are: a fork has the handle, but not the threads.
    process: int = 0
