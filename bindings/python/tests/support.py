# SPDX-License-Identifier: MIT
"""Meshes, rays, and an oracle: all rays against all triangles in integers."""

import numpy as np

import mlrt

# What every x86-64 has, and what this one may have.
ISAS = ("scalar", "sse", "avx2", "avx512", "neon")
BOX_METHODS = (None, "ray", "tile")
KDTREE_METHODS = (None, "ray", "packet2", "packet4", "multilevel")


def both_trees(boxes, kdtree):
    """Each method with the tree that has it."""
    yield from ((method, boxes) for method in BOX_METHODS)
    yield from ((method, kdtree) for method in KDTREE_METHODS)


def box(lower=-1.0, upper=1.0):
    """A closed box of twelve triangles, normals outward."""
    corners = np.array([[x, y, z] for x in (lower, upper) for y in (lower, upper) for z in (lower, upper)], np.float32)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    return corners, np.array(faces, np.uint32)


def integer_scene(seed, triangle_count=60, ray_count=500):
    """Triangles and rays with small integers as coordinates: full of ties, shared planes, edges and corners hit."""
    random = np.random.default_rng(seed)
    vertices = random.integers(-6, 7, (triangle_count // 2 + 3, 3)).astype(np.float32)
    faces = random.integers(0, len(vertices), (triangle_count, 3)).astype(np.uint32)
    origins = random.integers(-12, 13, (ray_count, 3)).astype(np.float32)
    directions = random.integers(-5, 6, (ray_count, 3)).astype(np.float32) - origins
    return vertices, faces, origins, directions


def distances(vertices, faces, origins, directions):
    """N / D for each ray and triangle, inf for a miss, and u, v and the sign of D: the rule of mlrt.h, exactly.

    Coordinates are small integers. Different quotients of numbers below 2^25 differ in float64, equal ones are equal.
    """
    a, b, c = (vertices.astype(np.int64)[faces[:, corner]][None] for corner in range(3))
    o, d = (array.astype(np.int64)[:, None] for array in (origins, directions))

    def edge(first, second):
        return np.sum(d * np.cross(first - o, second - o), axis=-1)

    ab, bc, ca = edge(a, b), edge(b, c), edge(c, a)
    determinant = ab + bc + ca
    normal = np.cross(b - a, c - a)
    numerator = np.sum((a - o) * normal, axis=-1)
    sign = np.sign(determinant)
    hit = (sign != 0) & (sign * numerator > 0)
    for value in (ab, bc, ca):
        hit &= sign * value >= 0
    with np.errstate(all="ignore"):
        t, u, v = numerator / determinant, ca / determinant, ab / determinant
    return np.where(hit, t, np.inf), np.where(hit, u, 0), np.where(hit, v, 0), np.where(hit, sign, 0)


def assert_same(case, first, second, which=slice(None)):
    """The same bits in all arrays of two results, and the same arrays in both."""
    for name, a, b in zip(first._fields, first, second):
        case.assertEqual(a is None, b is None, name)
        if a is not None:
            case.assertEqual(a[which].tobytes(), b[which].tobytes(), name)


def isas():
    """The instruction sets of this machine and build."""
    tree = mlrt.Tree(*box())
    found = []
    for isa in ISAS:
        try:
            tree.trace([0, 0, 0], [0, 0, 1], isa=isa)
            found.append(isa)
        except mlrt.UnsupportedError:
            pass
    return found
