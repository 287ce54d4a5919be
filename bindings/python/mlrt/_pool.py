# SPDX-License-Identifier: MIT
"""Threads that tracing calls share their work with."""

from __future__ import annotations

import ctypes
import os
from operator import index
from types import TracebackType
from typing import Any, Optional

from ._abi import PoolHandle, library
from ._errors import check
from .typing import Threads


class _Handle(PoolHandle):
    def __del__(self, destroy: Any = library.mlrt_destroy_pool, getpid: Any = os.getpid) -> None:
        if self.process == getpid():
            destroy(self)


class Pool:
    """A pool of `threads` threads at work, the calling one included; 0 = one per processor.

    Give it to tracing calls as `pool`. It serves one call at a time; calls that share one wait for each other. It works only
    in the process that made it: after a fork, make another. Usable in a `with` statement.
    """

    def __init__(self, threads: int = 0) -> None:
        self._handle: Optional[_Handle] = None
        if not 0 <= threads <= 1024:
            raise ValueError(f"threads: 0 to 1024, not {threads}")
        handle = _Handle()
        check(library.mlrt_create_pool(threads, ctypes.byref(handle)))
        handle.process = os.getpid()
        self._handle = handle
        self._threads: int = library.mlrt_pool_thread_count(handle)

    @property
    def threads(self) -> int:
        """How many threads are at work, the calling one included; also after `close`."""
        return self._threads

    def handle(self) -> _Handle:
        """The mlrt_pool, for a call that is about to use it."""
        if self._handle is None:
            raise ValueError("the pool is closed")
        if self._handle.process != os.getpid():
            raise RuntimeError("the pool belongs to another process: after a fork, make a new one")
        return self._handle

    def close(self) -> None:
        """Ends the threads, as soon as no call uses them."""
        self._handle = None

    def __copy__(self) -> Pool:
        """Another one with the same threads: closing one of them leaves the other."""
        copy = type(self).__new__(type(self))
        vars(copy).update(vars(self))
        return copy

    def __deepcopy__(self, memo: Any) -> Pool:
        return self.__copy__()

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise TypeError("a pool cannot be pickled, as its threads are those of one process: give a number of threads")

    def __repr__(self) -> str:
        """How many threads there are."""
        if self._handle is None:
            return "<Pool, closed>"
        return f"<Pool of {self._threads} threads>"

    def __enter__(self) -> Pool:
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()


_kept: dict[tuple[int, int], Pool] = {}


def pool_handle(threads: Threads) -> _Handle:
    """The mlrt_pool of a Pool, or of a number of threads, for which one pool is made in each process and kept.

    Calls that share a pool wait for each other, so more of them would not be faster.
    """
    if isinstance(threads, Pool):
        return threads.handle()
    try:
        number = index(threads)  # type: ignore[arg-type]
        if isinstance(threads, bool):
            raise TypeError
    except TypeError:
        raise TypeError(f"pool: a mlrt.Pool or a number of threads is needed, not {threads!r}") from None
    key = number, os.getpid()
    kept = _kept.get(key) or _kept.setdefault(key, Pool(number))  # of two made at the same time one goes
    return kept.handle()
