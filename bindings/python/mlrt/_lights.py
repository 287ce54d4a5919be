# SPDX-License-Identifier: MIT
"""Lights of a picture, whose shadows Tree.render finds."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ._abi import LIGHT_DIRECTIONAL, LIGHT_POINT, Float3, Light
from ._arrays import floats
from .typing import Light as AnyLight, Vector


@dataclass
class DirectionalLight:
    """A light that is so far away that its rays are parallel, as the sun's."""

    direction: Vector  #: towards the light, of any length


def light_structs(lights: Iterable[AnyLight]) -> Any:
    """Lights as an array of mlrt_light."""
    structs = [_light_struct(light) for light in lights]
    return (Light * len(structs))(*structs)


def _light_struct(light: AnyLight) -> Light:
    if isinstance(light, DirectionalLight):
        kind, numbers = LIGHT_DIRECTIONAL, light.direction
    else:
        kind, numbers = LIGHT_POINT, light
    position = floats(numbers)
    if position.shape != (3,):
        raise ValueError(f"lights: each must be three numbers or a DirectionalLight, not {light!r}")
    return Light(kind=kind, position=Float3(*position))
