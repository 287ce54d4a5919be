# SPDX-License-Identifier: MIT
"""What the library tells Python while a call runs: messages go to the logger "mlrt", progress to a bar."""

import ctypes
import logging
import signal
from types import TracebackType
from typing import Any, Optional

from . import _abi
from ._progress import Bar

LOGGER = logging.getLogger("mlrt")
LOGGER.addHandler(logging.NullHandler())  # without handlers of its own, a program is not to print warnings

# Errors are exceptions, with the same words: logged as well, they would be reported twice.
_LEVELS = {_abi.LOG_ERROR: logging.DEBUG, _abi.LOG_WARNING: logging.WARNING, _abi.LOG_INFO: logging.INFO}


class Callbacks:
    """Keeps what is raised in callbacks from C, where nobody can catch it, and raises it at the end of the `with`.

    So with signals: Python runs their handlers when a callback begins (since 3.11 before its first line, so not within a `try`
    of it), and what they raise, KeyboardInterrupt for one, would be printed and lost. Here they run inside of others that
    catch it.
    """

    def __init__(self) -> None:
        self.error: Optional[BaseException] = None
        self._handlers: dict[int, Any] = {}

    def __enter__(self) -> Any:
        try:
            for number in _SIGNALS:
                handler = signal.getsignal(number)
                if callable(handler):
                    self._handlers[number] = handler  # first: the signal may come at once
                    try:
                        signal.signal(number, self._handle)
                    except ValueError:  # not the main thread, so no handler runs in it
                        del self._handlers[number]
                        break
        except BaseException:  # by a handler that is not replaced yet
            self._restore()
            raise
        return self

    def _handle(self, number: int, frame: Any) -> None:
        try:
            self._handlers[number](number, frame)
        except BaseException as error:
            self.error = error

    def _restore(self) -> None:
        """Sets all handlers, though one that is set again already may raise meanwhile. That counts as raised in a callback."""
        while self._handlers:
            try:
                number, handler = next(iter(self._handlers.items()))
                signal.signal(number, handler)
                del self._handlers[number]
            except BaseException as error:
                self.error = error

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self._restore()
        error, self.error = self.error, None
        if error is not None:
            raise error


# Those that programs let raise exceptions. Looking at all 64 would take longer than to build a small tree.
_NAMES = ("SIGINT", "SIGTERM", "SIGALRM", "SIGHUP", "SIGUSR1", "SIGUSR2")
_SIGNALS = [getattr(signal, name) for name in _NAMES if hasattr(signal, name)]


class Host(Callbacks):
    """An mlrt_host for one call, in a `with` statement: `pointer` is for its options, None if nobody listens.

    What is raised in the bar or in a handler of a signal ends the call; so does what is raised in a handler of the log, but
    only at the call's end.
    """

    def __init__(self, bar: Optional[Bar] = None, total: int = 0) -> None:
        """total: what the bar counts up to."""
        super().__init__()
        self._bar, self._total, self._done = bar, total, 0
        self._kept: list[Any] = []
        self.pointer: Optional[int] = None

    def __enter__(self) -> "Host":
        logged = LOGGER.isEnabledFor(logging.WARNING)  # if not for warnings, then for nothing
        if not logged and self._bar is None:
            return self
        struct = _abi.Host()
        self._kept.append(struct)
        if logged:
            struct.log = self._function(_abi.LogCallback(self._log))
        if self._bar is not None:
            struct.progress = self._function(_abi.ProgressCallback(self._progress))
        self.pointer = ctypes.addressof(struct)
        super().__enter__()
        return self

    def _function(self, callback: Any) -> Optional[int]:
        self._kept.append(callback)
        return ctypes.cast(callback, ctypes.c_void_p).value

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self._kept.clear()  # they refer to this
        super().__exit__(kind, error, trace)

    def _log(self, user: Any, level: int, message: bytes) -> None:
        try:
            LOGGER.log(_LEVELS.get(level, logging.INFO), "%s", message.decode(errors="replace"))
        except BaseException as error:
            self.error = error

    def _progress(self, user: Any, fraction: float) -> int:
        try:
            done = round(fraction * self._total)
            if self._bar is not None and self.error is None:
                self._bar.add(done - self._done)
            self._done = done
        except BaseException as error:
            self.error = error
        return self.error is not None


class TileCounter(Callbacks):
    """A callback for mlrt_render_tiles that moves a bar, in a `with` statement. What is raised in it ends the render."""

    def __init__(self, bar: Bar) -> None:
        super().__init__()
        self._bar = bar

    def __enter__(self) -> "TileCounter":
        self.callback: Any = _abi.TileCallback(self._count)
        super().__enter__()
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.callback = None  # it refers to this
        super().__exit__(kind, error, trace)

    def _count(self, user: Any, tile: Any) -> int:
        try:
            if self.error is None:
                self._bar.add(tile.contents.width * tile.contents.height)
        except BaseException as error:
            self.error = error
        return self.error is not None
