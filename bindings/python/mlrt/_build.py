# SPDX-License-Identifier: MIT
"""Building trees, and foreseeing the memory that this takes."""

import ctypes
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Optional, TypedDict, Union

from . import _abi
from ._abi import TreeHandle, library
from ._arrays import mask_word
from ._errors import check
from ._host import Host
from ._meshes import Meshes, in_32_bits, in_64_bits
from ._pool import Pool
from ._progress import Bar

if TYPE_CHECKING:  # in typing since Python 3.11
    from typing_extensions import Unpack

Preset = Literal["default", "paper", "fast", "best"]
Structure = Literal["kdtree", "bvh"]

MESSAGE_SIZE = 256


class BuildSettings(TypedDict, total=False):
    """What Tree, Tree.from_meshes and estimate_memory take by name."""

    preset: Preset
    rules_off: Iterable[str]
    max_depth: int
    max_references: int
    traversal_cost: float
    intersection_cost: float
    structures: Union[None, Structure, Iterable[Structure]]
    pool: Optional[Pool]
    memory_limit: int


class TreeSettings(BuildSettings, total=False):
    """What Tree and Tree.from_meshes take by name."""

    progress: bool


class MemoryEstimate(NamedTuple):
    """How much memory a tree takes, foreseen."""

    memory_size: int  #: bytes held by the tree
    peak_memory_size: int  #: bytes held at most at one time while building


def named(value: Any, names: dict[Any, int], what: str) -> int:
    try:
        return names[value]
    except (KeyError, TypeError):
        raise ValueError(f"{what}: {value!r} is none of {', '.join(map(repr, names))}") from None


def _structures(given: Union[None, Structure, Iterable[Structure]]) -> int:
    words = (given,) if isinstance(given, str) else given or ()
    return sum({named(word, _abi.STRUCTURES, "structures") for word in words})


def _options(
    *,
    preset: Preset = "default",
    rules_off: Iterable[str] = (),
    max_depth: int = 0,
    max_references: int = 0,
    traversal_cost: float = 0.0,
    intersection_cost: float = 0.0,
    structures: Union[None, Structure, Iterable[Structure]] = None,
    pool: Optional[Pool] = None,
    memory_limit: int = 0,
) -> Any:
    """An mlrt_build_options, which keeps alive what it points to."""
    message = ctypes.create_string_buffer(MESSAGE_SIZE)
    options: Any = _abi.BuildOptions(
        preset=named(preset, _abi.PRESETS, "preset"),
        rules_off=sum({named(rule, _abi.RULES, "rules_off") for rule in rules_off}),
        max_depth=in_32_bits(max_depth, "max_depth"),
        max_references=in_64_bits(max_references, "max_references"),
        traversal_cost=traversal_cost,
        intersection_cost=intersection_cost,
        message=ctypes.addressof(message),
        message_size=MESSAGE_SIZE,
        structures=_structures(structures),
        memory_limit=in_64_bits(memory_limit, "memory_limit"),
    )
    options.text = message
    if pool is not None:
        options.handle = pool.handle()
        options.pool = options.handle.value
    return options


def build(meshes: Meshes, progress: bool = False, **settings: "Unpack[BuildSettings]") -> TreeHandle:
    """mlrt_build_kdtree."""
    options = _options(**settings)
    handle = TreeHandle()
    with ExitStack() as stack:
        total = meshes.triangle_count
        bar = stack.enter_context(Bar(total, "triangles")) if progress else None
        options.host = stack.enter_context(Host(bar, total)).pointer
        count, pointers = len(meshes.structs), map(ctypes.byref, (options, handle))
        status = library.mlrt_build_kdtree(meshes.structs, count, *pointers)
    check(status, options.text.value.decode())
    return handle


def estimate_memory(
    triangle_counts: Union[int, Iterable[int]],
    masks: Optional[Sequence[int]] = None,
    **options: "Unpack[BuildSettings]",
) -> MemoryEstimate:
    """Foresees the memory of a Tree with these numbers of triangles: that of its mesh, or those of several.

    masks, options: as for Tree.from_meshes. Of a hierarchy of boxes, scenes of more than a few thousand triangles take 80 to 110 %
    of what is said; of a kd-tree it is a guess, and can be off by two. What holds is `memory_limit`.
    """
    counts = list(triangle_counts) if isinstance(triangle_counts, Iterable) else [triangle_counts]
    if masks is not None and len(masks) != len(counts):
        raise ValueError(f"masks: {len(counts)} are needed, not {len(masks)}")
    structs = (_abi.Mesh * len(counts))()
    for struct, count, mask in zip(structs, counts, [0] * len(counts) if masks is None else masks):
        struct.struct_size = ctypes.sizeof(struct)
        struct.triangle_count = in_64_bits(count, "triangle_counts")
        struct.mask = mask_word(mask, "masks")
    estimate = _abi.MemoryEstimate()
    pointers = map(ctypes.byref, (_options(**options), estimate))
    check(library.mlrt_estimate_memory(structs, len(counts), *pointers))
    return MemoryEstimate(estimate.memory_size, estimate.peak_memory_size)
