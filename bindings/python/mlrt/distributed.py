# SPDX-License-Identifier: MIT
"""Pictures and batches of rays of any size over a cluster of Dask: pip install mlrt[distributed].

    from dask.distributed import Client
    from mlrt.distributed import Scene

    client = Client("scheduler:8786")                                  # or Client() for processes on this machine
    with Scene(tree, folder="/shared/folder") as scene:                # a folder that all workers see
        hits = scene.trace(origins, directions)                        # numpy or dask arrays, float32 (..., 3)
        hits.t                                                         # a dask array, whose pieces lie on the workers
        picture = mlrt.distributed.gather(scene.render(camera))        # mlrt.Hits of numpy arrays

The tree is saved once, and each worker process maps the file into memory: processes of one machine share it. Answers are those of one
machine, bit for bit, however rays are cut into pieces. A piece whose worker dies is traced again by another one, and so is a result
that only this worker had. Dask's dashboard shows the progress, under the names mlrt-trace, mlrt-occluded and mlrt-render.
"""

from __future__ import annotations

import os
import tempfile
import uuid
from dataclasses import replace
from functools import lru_cache
from types import TracebackType
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from ._camera import Camera
from ._errors import DataError
from ._results import DTYPES, HIT_FIELDS, Hits, check_names
from ._tree import Tree
from .typing import Lights, Masks, Numbers, Outputs, Path, Skips, Vectors

try:
    import dask
    import dask.array
    import dask.distributed
except ImportError as error:
    raise ImportError("mlrt.distributed needs Dask: pip install mlrt[distributed], or pip install dask distributed") from error

if TYPE_CHECKING:
    from dask.array import Array
    from dask.distributed import Client

_dask: Any = dask  # parts of Dask have no types
da: Any = _dask.array

__all__ = ["Scene", "gather"]

RAYS_PER_PIECE = 1 << 20
"""Rays of a piece, if nothing else is said: 0.03 to 0.3 seconds of work, where Dask needs about a millisecond for a piece."""

RETRIES = 2
"""How often a piece is tried again that raised an error. Pieces of workers that die do not count."""


class Scene:
    """A tree that the workers of a cluster have. Usable in a `with` statement, which removes the file."""

    def __init__(
        self, tree: Union[Tree, Path], *, folder: Optional[Path] = None, client: Optional[Client] = None
    ) -> None:
        """tree: a Tree, or the file of one, as `save` writes it, under a name that all workers know it by.

        folder: where a Tree is saved: a folder that all workers see; None = that for temporary files, if they are on this machine.
        client: a Client of Dask; None = the one made last.
        """
        self._client: Any = _dask.distributed.default_client() if client is None else client
        self._own_file = isinstance(tree, Tree)
        if isinstance(tree, Tree):
            folder = tempfile.gettempdir() if folder is None else folder
            self.path = os.path.join(os.path.abspath(folder), f"mlrt-{uuid.uuid4().hex}.mlrt")
            tree.save(self.path)
            self._hash = tree.info.tree_hash
        else:
            self.path = os.path.abspath(tree)
            self._hash = Tree.load(self.path).info.tree_hash

    def __repr__(self) -> str:
        """Where the file is, and who works."""
        return f"<mlrt.distributed.Scene of {self.path}: {len(self._client.scheduler_info()['workers'])} workers>"

    def close(self) -> None:
        """Removes the file that this made. Workers that have it mapped keep it; pieces still to come fail on others."""
        if self._own_file and os.path.exists(self.path):
            os.unlink(self.path)

    def __enter__(self) -> Scene:
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

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
        rays_per_piece: int = RAYS_PER_PIECE,
        start: bool = True,
    ) -> Hits:
        """The closest hit of each ray: Tree.trace, whose arguments may be dask arrays, too. Hits of dask arrays.

        Rays that do not fit into the memory of one machine come in dask arrays, whose chunks are kept where they fit together; numpy
        arrays travel through the scheduler.

        start: trace now, and keep the results in the memory of the workers; False = when the arrays are computed or stored, piece by
        piece, all outputs again for each call of `compute` (dask.compute(*hits) is one).
        """
        names = check_names(outputs, HIT_FIELDS)
        rays = origins, directions, t_min, t_max, skip, mask
        records = self._pieces(_trace, "mlrt-trace", _record(names), names, rays, rays_per_piece, start)
        return _hits(records, names)

    def occluded(
        self,
        origins: Vectors,
        directions: Vectors,
        t_min: Optional[Numbers] = None,
        t_max: Optional[Numbers] = None,
        skip: Skips = None,
        *,
        mask: Masks = None,
        rays_per_piece: int = RAYS_PER_PIECE,
        start: bool = True,
    ) -> Array:
        """Whether each ray hits anything: a dask array of bool. Arguments as for `trace`."""
        rays = origins, directions, t_min, t_max, skip, mask
        return self._pieces(_occluded, "mlrt-occluded", np.dtype(np.bool_), (), rays, rays_per_piece, start)

    def _pieces(
        self, function: Any, name: str, dtype: Any, names: tuple[str, ...], rays: Any, rays_per_piece: int, start: bool
    ) -> Array:
        """`function` of each piece of rays."""
        given = zip(_WIDTHS.items(), rays)
        arrays = {key: (_array(value), width) for (key, width), value in given if value is not None}
        shapes = {key: array.shape[: array.ndim - (width > 1)] for key, (array, width) in arrays.items()}
        for key, (array, width) in arrays.items():
            if width > 1 and array.shape[-1:] != (width,):
                raise ValueError(f"{key}: the shape must be (..., {width}), not {array.shape}")
        try:
            shape = np.broadcast_shapes(*shapes.values())
        except ValueError:
            raise ValueError(f"rays: these counts do not fit each other: {shapes}") from None
        chunks = _chunks(shape, arrays, rays_per_piece)
        axes = tuple(range(len(shape)))
        blocks: list[Any] = []
        arguments: dict[str, Any] = {}
        for key, (array, width) in arrays.items():
            whole = shape + (width,) * (width > 1)
            if array.ndim == (width > 1) or array.size == width:  # one for all rays
                arguments[key] = np.asarray(array).reshape(whole[len(shape) :])
                continue
            spread = da.broadcast_to(da.asarray(array), whole).rechunk((*chunks, *((width,),) * (width > 1)))
            blocks += [spread, axes + (len(shape) + len(blocks),) * (width > 1)]
            arguments[key] = len(blocks) // 2 - 1
        work = {"source": (self.path, self._hash), "names": names, "arguments": arguments}
        unique_name = f"{name}-{uuid.uuid4().hex}"
        if blocks:
            meta = np.empty((0,) * len(shape), dtype)
            result = da.blockwise(
                function, axes, *blocks, dtype=dtype, meta=meta, name=unique_name, concatenate=True, align_arrays=False, **work
            )
        else:  # one ray
            arguments.update({key: array.reshape(shape + array.shape) for key, array in arguments.items() if key == "origins"})
            result = da.from_delayed(_dask.delayed(function)(**work), shape, dtype, name=unique_name)
        return self._started(result, start)

    def render(
        self,
        camera: Camera,
        *,
        lights: Lights = None,
        mask: int = 0,
        outputs: Outputs = None,
        rays_per_piece: int = RAYS_PER_PIECE,
        start: bool = True,
    ) -> Hits:
        """The closest hit of each pixel's ray: Tree.render. Hits of dask arrays of shape (height, width). start: as for `trace`."""
        lights = None if lights is None else list(lights)
        names = check_names(outputs, HIT_FIELDS if lights is None else Hits._fields)
        record = _record(names)
        rows, columns = camera.check_shape()
        side = max(int(rays_per_piece**0.5) // _PIXELS * _PIXELS, _PIXELS)  # tiles of pixels stay whole
        chunks = da.core.normalize_chunks((side, side), (rows, columns))
        records = da.map_blocks(
            _render, camera=replace(camera), lights=lights, mask=mask, names=names, source=(self.path, self._hash),
            chunks=chunks, dtype=record, meta=np.empty((0, 0), record), name=f"mlrt-render-{uuid.uuid4().hex}",
        )  # fmt: skip
        records = self._started(records, start)
        return _hits(records, names)

    def _started(self, array: Array, start: bool) -> Array:
        return self._client.persist(array, retries=RETRIES) if start else array


def gather(hits: Union[Hits, Array], client: Optional[Client] = None) -> Any:
    """mlrt.Hits of numpy arrays, or one array, from what a Scene returned. All of it comes to this process."""
    used: Any = _dask.distributed.default_client() if client is None else client
    if not isinstance(hits, Hits):
        return used.compute(hits, retries=RETRIES).result()
    names = [name for name, array in zip(hits._fields, hits) if array is not None]
    futures = used.compute([getattr(hits, name) for name in names], retries=RETRIES)
    return Hits(**dict(zip(names, used.gather(futures))))


_PIXELS = 64  # a multiple of the sides of all tiles
_WIDTHS = {"origins": 3, "directions": 3, "t_min": 1, "t_max": 1, "skip": 2, "mask": 1}  # numbers of an element


def _record(names: tuple[str, ...]) -> np.dtype[Any]:
    return np.dtype([(name, DTYPES[name]) for name in names])


def _hits(records: Any, names: tuple[str, ...]) -> Hits:
    """Hits of dask arrays, from one of records."""
    return Hits(**{name: records[name] for name in names})


def _array(values: Any) -> Any:
    return values if isinstance(values, da.Array) else np.asarray(values)


def _chunks(shape: tuple[int, ...], arrays: dict[str, tuple[Any, int]], rays_per_piece: int) -> Any:
    """How rays are cut: like the largest dask array among them, else along the first axes."""
    cut = [(array, width) for array, width in arrays.values() if isinstance(array, da.Array)]
    for array, width in sorted(cut, key=lambda pair: -pair[0].size):
        if array.shape[: array.ndim - (width > 1)] == shape:
            return array.chunks[: len(shape)]
    if rays_per_piece < 1:
        raise ValueError(f"rays_per_piece: at least 1, not {rays_per_piece}")
    sizes, left = [], rays_per_piece
    for count in reversed(shape):  # whole rows along the last axes
        sizes.append(max(min(count, left), 1))
        left = max(left // max(count, 1), 1)
    return da.core.normalize_chunks(tuple(reversed(sizes)), shape)


# ---- what workers do ---------------------------------------------------------------------------------------------------


@lru_cache(maxsize=4)
def _tree(path: str, tree_hash: int) -> Tree:
    """The tree of a file, mapped once by each process."""
    try:
        tree = Tree.load(path)
    except FileNotFoundError as error:
        raise FileNotFoundError(f"{path}: this worker does not see the file of the tree; give Scene a folder that all workers see") from error
    if tree.info.tree_hash != tree_hash:
        raise DataError(f"{path}: on this worker, the file is of another tree")
    return tree


def _of(blocks: tuple[Any, ...], arguments: dict[str, Any]) -> dict[str, Any]:
    """Arguments by name: those that are an int are blocks."""
    return {name: blocks[value] if isinstance(value, int) else value for name, value in arguments.items()}


def _records(hits: Hits, names: tuple[str, ...]) -> np.ndarray:
    records = np.empty(getattr(hits, names[0]).shape, _record(names))
    for name in names:
        records[name] = getattr(hits, name)
    return records


def _trace(*blocks: Any, source: tuple[str, int], names: tuple[str, ...], arguments: dict[str, Any]) -> np.ndarray:
    return _records(_tree(*source).trace(outputs=names, **_of(blocks, arguments)), names)


def _occluded(*blocks: Any, source: tuple[str, int], names: tuple[str, ...], arguments: dict[str, Any]) -> np.ndarray:
    return _tree(*source).occluded(**_of(blocks, arguments))


def _render(
    camera: Camera, lights: Any, mask: int, names: tuple[str, ...], source: tuple[str, int], block_info: Any = None
) -> np.ndarray:
    (top, bottom), (left, right) = block_info[None]["array-location"]
    x, y = camera.crop[:2] if camera.crop is not None else (0, 0)
    piece = replace(camera, crop=(x + left, y + top, right - left, bottom - top))
    return _records(_tree(*source).render(piece, lights=lights, mask=mask, outputs=names), names)
