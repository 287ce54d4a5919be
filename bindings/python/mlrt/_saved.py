# SPDX-License-Identifier: MIT
"""Saved trees: written to files and memory, and used where they lie, in files mapped into memory for example."""

from __future__ import annotations

import ctypes
import mmap
import os
import threading
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _abi
from ._abi import TreeHandle, library
from ._arrays import address
from ._build import MESSAGE_SIZE
from ._errors import check
from ._host import Host
from ._meshes import in_64_bits
from .typing import Path, Source

Bytes = NDArray[np.uint8]


def saved_bytes(tree: TreeHandle) -> Bytes:
    """What mlrt_save_tree writes."""
    size = ctypes.c_size_t()
    check(library.mlrt_save_tree(tree, None, 0, ctypes.byref(size)))
    array = np.empty(size.value, np.uint8)
    check(library.mlrt_save_tree(tree, address(array), array.size, ctypes.byref(size)))
    return array


def write(path: Path, array: Bytes) -> None:
    """Writes a file that takes the place of another one only when it is whole.

    Never into that other one: trees may lie in it.
    """
    target = os.path.realpath(os.fsdecode(path))
    if os.path.exists(target) and not os.path.isfile(target):  # a pipe, a device
        with open(target, "wb") as file:
            file.write(array.data)
        return
    part = f"{target}.{os.getpid()}.{threading.get_ident()}.part"
    try:
        with open(part, "xb") as file:
            file.write(array.data)
        os.replace(part, target)
    except BaseException:
        if os.path.exists(part):
            os.unlink(part)
        raise


def _mapped(path: Path) -> Union[bytes, mmap.mmap]:
    with open(path, "rb") as file:
        if os.fstat(file.fileno()).st_size == 0:  # a pipe, or a file that cannot be mapped since it is empty
            return file.read()
        return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)


def load(source: Source, in_place: bool, geometry_hash: Optional[int], memory_limit: int) -> TreeHandle:
    """mlrt_load_tree. The handle keeps the data it lies in."""
    content: Any = _mapped(source) if isinstance(source, (str, os.PathLike)) else source
    array = np.frombuffer(content, np.uint8)
    message = ctypes.create_string_buffer(MESSAGE_SIZE)
    options = _abi.LoadOptions(
        flags=_abi.LOAD_IN_PLACE if in_place and not array.flags.writeable else 0,
        geometry_hash=0 if geometry_hash is None else in_64_bits(geometry_hash, "geometry_hash"),
        memory_limit=in_64_bits(memory_limit, "memory_limit"),
        message=ctypes.addressof(message),
        message_size=MESSAGE_SIZE,
    )
    handle = TreeHandle()
    with Host() as host:
        options.host = host.pointer
        status = library.mlrt_load_tree(address(array), array.size, ctypes.byref(options), ctypes.byref(handle))
    check(status, message.value.decode())
    if options.flags:
        handle.data = array
    return handle
