# SPDX-License-Identifier: MIT
"""Finds and loads libmlrt: beside this package, then in build/ of the checkout around it, then wherever the system looks."""

import ctypes
from pathlib import Path

NAME = "libmlrt.so.0"


def candidates() -> list[str]:
    """Where to look, in order; a name without a folder is left to the system's loader."""
    package = Path(__file__).resolve().parent
    places = [package / NAME]
    if len(package.parents) > 2 and (package.parents[2] / "include" / "mlrt.h").exists():
        places.append(package.parents[2] / "build" / NAME)
    return [str(place) for place in places if place.exists()] + [NAME]


def load() -> ctypes.CDLL:
    """The library. Calls through a CDLL release the GIL."""
    path = candidates()[0]
    try:
        return ctypes.CDLL(path)
    except OSError as error:
        raise ImportError(
            f"mlrt cannot load {path} ({error}). Run `make` in the checkout, install the wheel, or `make install` and ldconfig."
        ) from error
