# SPDX-License-Identifier: MIT
"""What trimesh's tests import as `generic`, for its source distribution, which has the tests, but neither this module nor models.

Models whose shape is told by their name and by what the tests ask are made here; a test that wants another one is skipped.
"""

import collections
import logging
import time  # noqa: F401
import timeit  # noqa: F401
import unittest  # noqa: F401
from collections import deque  # noqa: F401

import numpy as np
import pytest
import trimesh

try:
    from shapely.geometry import Point, Polygon  # noqa: F401
except ImportError:
    pass

Trimesh = trimesh.Trimesh
tol = trimesh.constants.tol
log = logging.getLogger("trimesh")
has_binvox = trimesh.exchange.binvox.binvox_encoder is not None
transforms = np.array([trimesh.transformations.euler_matrix(np.pi / 4, angle, 0) for angle in np.linspace(0, 2 * np.pi, 100)])


def _open_sphere():
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=8)
    return sphere.vertices, sphere.faces[len(sphere.faces) // 20 :]


def _part_with_a_hole():
    part = trimesh.creation.annulus(r_min=0.5, r_max=1.5, height=1)
    return part.vertices, part.faces


def _of(mesh):
    return mesh.vertices, mesh.faces


_MODELS = {
    "unit_cube.STL": lambda: _of(trimesh.creation.box()),
    "unit_sphere.STL": lambda: _of(trimesh.creation.icosphere(subdivisions=2, radius=0.5)),
    "20mm-xyz-cube.stl": lambda: _of(trimesh.creation.box(extents=(20, 20, 20))),
    "teapot.stl": _open_sphere,
    "featuretype.STL": _part_with_a_hole,
}


class _Data(dict):
    def __missing__(self, name):
        pytest.skip(f"{name}.json is not in trimesh's source distribution")


data = _Data()


def random(*shape):
    return np.random.RandomState(seed=1).random_sample(*shape)


def get_mesh(name, *, use_embree=True, **_):
    if name not in _MODELS:
        pytest.skip(f"{name} is not in trimesh's source distribution")
    return trimesh.Trimesh(*_MODELS[name](), use_embree=use_embree)


def get_meshes(count=len(_MODELS)):
    return [get_mesh(name) for name in list(_MODELS)[:count]]


def get_2D(count=None):
    return collections.deque()
