# SPDX-License-Identifier: MIT
"""Pinhole and parallel cameras: which ray belongs to which pixel."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _abi
from ._abi import library
from ._arrays import address, floats, named
from ._errors import CameraError, check
from ._single import limit
from .typing import Vector



def _unit(vector: NDArray[np.float64], what: str) -> NDArray[np.float64]:
    length = np.linalg.norm(vector)
    if not 0 < length < np.inf:
        raise ValueError(f"{what}: the vector is zero or not finite")
    return vector / length


def _view_axes(eye: Vector, target: Vector, up: Vector) -> tuple[NDArray[np.float64], ...]:
    """Unit vectors forward, right and upward."""
    forward = _unit(np.subtract(target, eye, dtype=np.float64), "target - eye")
    right = _unit(np.cross(forward, np.asarray(up, np.float64)), "up, seen along target - eye")
    return forward, right, np.cross(right, forward)


def _float3(vector: Vector, name: str) -> Any:
    numbers = floats(vector)
    if numbers.shape != (3,):
        raise CameraError(f"{name}: three numbers are needed, not an array of shape {numbers.shape}")
    return _abi.Float3(*numbers.tolist())


@dataclass(repr=False)
class Camera:
    """The rays of a picture: pixel (i, j) has p = d00 + (i + sample[0]) dx + (j + sample[1]) dy, and the ray

        pinhole:   origin eye, direction p               parallel:   origin p, direction `direction`

    in float32. Pixels count from the upper left with the cameras made by `look_at` and `orthographic`.
    """

    width: int
    height: int
    d00: Vector
    dx: Vector  #: from one pixel to the next in a row
    dy: Vector  #: from one row to the next
    eye: Vector = (0.0, 0.0, 0.0)  #: pinhole: where the rays start
    direction: Vector = (0.0, 0.0, 0.0)  #: parallel: where the rays go
    projection: str = "pinhole"  #: or "parallel"
    crop: Optional[tuple[int, int, int, int]] = None  #: x, y, width, height: only these pixels
    sample: tuple[float, float] = (0.5, 0.5)  #: where in the pixel
    t_min: float = 0.0
    t_max: Optional[float] = None  #: None = no limit

    @classmethod
    def look_at(
        cls,
        eye: Vector,
        target: Vector,
        width: int,
        height: int,
        fov: float = 45.0,
        up: Vector = (0.0, 1.0, 0.0),
    ) -> Camera:
        """A pinhole camera at `eye` with `target` in the middle; `fov` is the height of the picture in degrees."""
        if not 0 < fov < 180:
            raise ValueError(f"fov: between 0 and 180 degrees, not {fov}")
        forward, right, upward = _view_axes(eye, target, up)
        pixel = 2 * np.tan(np.radians(fov) / 2) / height
        corner = forward + pixel * (upward * height - right * width) / 2
        return cls(width, height, corner, right * pixel, -upward * pixel, eye=eye)

    @classmethod
    def orthographic(
        cls,
        eye: Vector,
        target: Vector,
        width: int,
        height: int,
        extent: float,
        up: Vector = (0.0, 1.0, 0.0),
    ) -> Camera:
        """A parallel camera whose rays start in the plane through `eye`; the picture is `extent` units high.

        Directions have length 1, so that t is the distance.
        """
        forward, right, upward = _view_axes(eye, target, up)
        pixel = extent / height
        corner = np.asarray(eye, np.float64) + pixel * (upward * height - right * width) / 2
        return cls(width, height, corner, right * pixel, -upward * pixel, direction=forward, projection="parallel")

    def __repr__(self) -> str:
        """The size, and what differs from the defaults."""
        fields = "direction" if self.projection == "parallel" else "eye", "d00", "dx", "dy"
        parts = [f"{name}=({', '.join(f'{number:.6g}' for number in np.ravel(getattr(self, name)) + 0.0)})" for name in fields]
        parts += [f"{name}={getattr(self, name)!r}" for name in ("crop", "t_max") if getattr(self, name) is not None]
        parts += [f"sample={self.sample}"] * (self.sample != (0.5, 0.5)) + [f"t_min={self.t_min}"] * (self.t_min != 0)
        return f"<Camera of {self.width} x {self.height} pixels, {self.projection}: {', '.join(parts)}>"

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the picture, or of its crop."""
        if self.crop is None:
            return self.height, self.width
        x, y, width, height = self.crop
        return height or self.height - y, width or self.width - x

    def rays(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """The very rays that Tree.render traces: origins and directions, float32 of shape (height, width, 3)."""
        camera = self.to_struct()
        shape = shape_of(camera) + (3,)
        origins, directions = np.empty(shape, np.float32), np.empty(shape, np.float32)
        arrays = [_abi.Array(address(array)) for array in (origins, directions)]
        check(library.mlrt_camera_rays(ctypes.byref(camera), *map(ctypes.byref, arrays)))
        return origins, directions

    def check_shape(self) -> tuple[int, int]:
        """The shape, or the library's error if the picture has none."""
        return shape_of(self.to_struct())

    def to_struct(self) -> _abi.Camera:
        """This as an mlrt_camera."""
        crop = (0, 0, 0, 0) if self.crop is None else tuple(self.crop)
        if len(crop) != 4:
            raise CameraError(f"crop: four numbers are needed, not {len(crop)}")
        names = "width", "height", "crop[0]", "crop[1]", "crop[2]", "crop[3]"
        for name, value in zip(names, (self.width, self.height, *crop)):
            if not 0 <= value <= _abi.NONE:
                raise CameraError(f"{name}: {value} does not fit into 32 bits")
        vectors = {name: _float3(getattr(self, name), name) for name in ("eye", "direction", "d00", "dx", "dy")}
        return _abi.Camera(
            projection=named(self.projection, _abi.PROJECTIONS, "projection"),
            width=self.width,
            height=self.height,
            crop_x=crop[0],
            crop_y=crop[1],
            crop_width=crop[2],
            crop_height=crop[3],
            **vectors,
            sample_x=self.sample[0],
            sample_y=self.sample[1],
            t_min=self.t_min,
            t_max=limit(self.t_max),
        )


def shape_of(camera: _abi.Camera) -> tuple[int, int]:
    """Rows and columns of what the library writes for an mlrt_camera, whatever others do to the Camera meanwhile."""
    rows = camera.crop_height or camera.height - camera.crop_y
    columns = camera.crop_width or camera.width - camera.crop_x
    if rows <= 0 or columns <= 0:
        raise CameraError(f"the picture has {columns} x {rows} pixels: both must be positive")
    return rows, columns
