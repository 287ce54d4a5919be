# SPDX-License-Identifier: MIT
"""Building trees, and foreseeing the memory that this takes."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from typing import Any, NamedTuple, Optional, Union

from . import _abi
from ._abi import TreeHandle, library
from ._arrays import mask_word, named
from ._errors import check
from ._host import Host
from ._meshes import Meshes, in_32_bits, in_64_bits
from ._pool import pool_handle
from ._progress import Bar, wants_bar
from .typing import KdTreePreset, Preset, Threads

MESSAGE_SIZE = 256


class MemoryEstimate(NamedTuple):
    """How much memory a tree takes, foreseen."""

    memory_size: int  #: bytes held by the tree
    peak_memory_size: int  #: bytes held at most at one time while building


def _complete(options: Any, pool: Threads, memory_limit: int) -> Any:
    """Options of either builder, which keep alive what they point to."""
    if pool is not None:
        options.handle = pool_handle(pool)
        options.pool = options.handle.value
    options.text = ctypes.create_string_buffer(MESSAGE_SIZE)
    options.message = ctypes.addressof(options.text)
    options.message_size = MESSAGE_SIZE
    options.memory_limit = in_64_bits(memory_limit, "memory_limit")
    return options


def tree_options(
    preset: Preset, pool: Threads, memory_limit: int, traversal_cost: float, intersection_cost: float
) -> Any:
    """An mlrt_tree_options."""
    options: Any = _abi.TreeOptions(
        preset=named(preset, _abi.PRESETS, "preset"),
        traversal_cost=traversal_cost,
        intersection_cost=intersection_cost,
    )
    return _complete(options, pool, memory_limit)


def kdtree_options(
    preset: KdTreePreset,
    rules_off: Iterable[str],
    max_depth: int,
    max_references: int,
    pool: Threads,
    memory_limit: int,
    traversal_cost: float,
    intersection_cost: float,
) -> Any:
    """An mlrt_kdtree_options."""
    options: Any = _abi.KdTreeOptions(
        preset=named(preset, _abi.KDTREE_PRESETS, "preset"),
        rules_off=sum({named(rule, _abi.RULES, "rules_off") for rule in rules_off}),
        max_depth=in_32_bits(max_depth, "max_depth"),
        max_references=in_64_bits(max_references, "max_references"),
        traversal_cost=traversal_cost,
        intersection_cost=intersection_cost,
    )
    return _complete(options, pool, memory_limit)


def _build(builder: Any, meshes: Meshes, options: Any, progress: bool) -> TreeHandle:
    handle = TreeHandle()
    with ExitStack() as stack:
        total = meshes.triangle_count
        bar = stack.enter_context(Bar(total, "triangles")) if wants_bar(progress) else None
        options.host = stack.enter_context(Host(bar, total)).pointer
        count, pointers = len(meshes.structs), map(ctypes.byref, (options, handle))
        status = builder(meshes.structs, count, *pointers)
    check(status, options.text.value.decode())
    return handle


def build_tree(meshes: Meshes, options: Any, progress: bool) -> TreeHandle:
    """mlrt_build_tree, with tree_options."""
    return _build(library.mlrt_build_tree, meshes, options, progress)


def build_kdtree(meshes: Meshes, options: Any, progress: bool) -> TreeHandle:
    """mlrt_build_kdtree, with kdtree_options."""
    return _build(library.mlrt_build_kdtree, meshes, options, progress)


Counts = Union[int, Iterable[int]]


def _estimate(estimator: Any, triangle_counts: Counts, masks: Optional[Sequence[int]], options: Any) -> MemoryEstimate:
    counts = list(triangle_counts) if isinstance(triangle_counts, Iterable) else [triangle_counts]
    if masks is not None and len(masks) != len(counts):
        raise ValueError(f"masks: {len(masks)} are given for {len(counts)} meshes")
    structs = (_abi.Mesh * len(counts))()
    for struct, count, mask in zip(structs, counts, [0] * len(counts) if masks is None else masks):
        struct.struct_size = ctypes.sizeof(struct)
        struct.triangle_count = in_64_bits(count, "triangle_counts")
        struct.mask = mask_word(mask, "masks")
    estimate = _abi.MemoryEstimate()
    check(estimator(structs, len(counts), ctypes.byref(options), ctypes.byref(estimate)), options.text.value.decode())
    return MemoryEstimate(estimate.memory_size, estimate.peak_memory_size)


def estimate_tree(
    triangle_counts: Counts,
    masks: Optional[Sequence[int]] = None,
    *,
    preset: Preset = "default",
    pool: Threads = None,
    memory_limit: int = 0,
    traversal_cost: float = 0.0,
    intersection_cost: float = 0.0,
) -> MemoryEstimate:
    """Foresees the memory of a Tree with these numbers of triangles: that of its mesh, or those of several.

    masks, options: as for Tree.from_meshes. Scenes of more than a few thousand triangles take 80 to 110 % of what is said. What
    holds is `memory_limit`.
    """
    options = tree_options(preset, pool, memory_limit, traversal_cost, intersection_cost)
    return _estimate(library.mlrt_estimate_tree, triangle_counts, masks, options)


def estimate_kdtree(
    triangle_counts: Counts,
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
) -> MemoryEstimate:
    """Foresees the memory of a Tree.kdtree, likewise: a guess, which can be off by two."""
    options = kdtree_options(
        preset, rules_off, max_depth, max_references, pool, memory_limit, traversal_cost, intersection_cost
    )
    return _estimate(library.mlrt_estimate_kdtree, triangle_counts, masks, options)
