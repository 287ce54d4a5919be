# SPDX-License-Identifier: MIT
"""One exception class per error code of mlrt.h, with the library's own message: mlrt_last_message, which names what is wrong."""

from ._abi import library


class Error(Exception):
    """What the library says went wrong. `status` is the code MLRT_ERROR_*."""

    status: int = 0


class ArgumentError(Error, ValueError):
    """A value is out of its range."""

    status = 1


class StructSizeError(Error):
    """The library does not know the structs of this package: their versions do not fit."""

    status = 2


class IndexRangeError(Error, IndexError):
    """A face names a vertex that does not exist."""

    status = 3


class OutOfMemoryError(Error, MemoryError):
    """An allocation failed, or a memory_limit was reached; nothing was kept."""

    status = 4


class TooLargeError(Error, OverflowError):
    """More triangles, rays or pixels than 32-bit counts allow."""

    status = 5


class CameraError(Error, ValueError):
    """A camera of size zero, a crop outside of it, numbers that are not finite, dx and dy parallel."""

    status = 6


class UnsupportedError(Error, NotImplementedError):
    """An instruction set that this machine or build does not have, or a method of the other structure."""

    status = 7


class ThreadError(Error, RuntimeError):
    """The system would not start a thread."""

    status = 8


class CancelledError(Error):
    """A callback asked to stop."""

    status = 9


class DataError(Error, ValueError):
    """Not a saved tree, or one that is damaged, of another version, or of other triangles."""

    status = 10


_CLASSES = {kind.status: kind for kind in Error.__subclasses__()}


def check(status: int, details: str = "") -> None:
    """Raises the exception of a status that is not MLRT_OK, which a call of this thread returned just now.

    details: why, if that is known already; else mlrt_last_message says it.
    """
    if status == 0:
        return
    phrase = library.mlrt_status_string(status).decode()
    reason = details or library.mlrt_last_message().decode(errors="replace")
    error = _CLASSES.get(status, Error)(f"{phrase}: {reason}" if reason and reason != phrase else phrase)
    error.status = status
    raise error
