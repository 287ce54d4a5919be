# SPDX-License-Identifier: MIT
"""Which triangles rays begin on: all of those, and no others, that integers say."""

import unittest
from fractions import Fraction
from unittest import mock

import numpy as np
from support import box, integer_scene

import mlrt
from mlrt import _origins


def expected(vertices, faces, origins, directions):
    """The first triangle that contains the origin and that the ray leaves, or -1: as the rule of mlrt.h with N = 0, in integers."""
    a, b, c = (vertices.astype(np.int64)[faces[:, corner]][None] for corner in range(3))
    o, d = (array.astype(np.int64)[:, None] for array in (origins, directions))

    def edge(first, second):
        return np.sum(d * np.cross(first - o, second - o), axis=-1)

    edges = edge(a, b), edge(b, c), edge(c, a)
    sign = np.sign(sum(edges))
    on = (sign != 0) & (np.sum((a - o) * np.cross(b - a, c - a), axis=-1) == 0)
    for value in edges:
        on &= sign * value >= 0
    return np.where(on.any(axis=1), on.argmax(axis=1), -1)


def found(vertices, faces, origins, directions, pool=None):
    tree = mlrt.Tree(vertices, faces)
    begins = _origins.begins(tree, vertices, faces, origins, directions, pool)
    triangles = np.full(len(origins), -1)
    triangles[begins.ray] = begins.triangle
    return begins, triangles


class Integers(unittest.TestCase):
    def test_rays_from_vertices_edges_and_faces(self):
        on = at_corners = 0
        for seed in range(3):
            vertices, faces, origins, directions = integer_scene(seed, triangle_count=200, ray_count=1500)
            origins = np.trunc(origins / 3)
            origins[::3] = vertices[np.arange(len(origins[::3])) % len(vertices)]
            corners = vertices[faces[np.arange(len(directions[1::5])) % len(faces)]]
            directions[1::5] = corners[:, 1] - corners[:, 0]
            origins[1::5] = corners[:, 0]
            begins, triangles = found(vertices, faces, origins, directions)
            exact = expected(vertices, faces, origins, directions)
            with mock.patch.object(_origins, "_FEW_POINTS", 0):  # the first of the mesh
                self.assertEqual(found(vertices, faces, origins, directions)[1].tolist(), exact.tolist())
            self.assertEqual((triangles >= 0).tolist(), (exact >= 0).tolist())
            for ray in np.flatnonzero(triangles != exact):  # the first with this corner
                at_corner = (vertices[faces] == origins[ray]).all(axis=2).any(axis=1)
                corner_faces = np.where(at_corner[:, None], faces, faces[:1] * 0)
                self.assertEqual(triangles[ray], expected(vertices, corner_faces, origins[ray : ray + 1], directions[ray : ray + 1])[0])
                at_corners += 1
            on += (exact >= 0).sum()
            weights = np.stack((1 - begins.u - begins.v, begins.u, begins.v), axis=-1)
            points = (weights[..., None] * vertices[faces[begins.triangle]]).sum(axis=1)
            self.assertTrue(np.allclose(points, origins[begins.ray], atol=1e-4))
        self.assertGreater(on, 1000)
        self.assertGreater(at_corners, 10)

    def test_pieces_and_one_origin(self):
        vertices, faces, origins, directions = integer_scene(3, triangle_count=300, ray_count=2000)
        origins = np.trunc(origins / 3)
        exact = expected(vertices, faces, origins, directions).tolist()
        with mock.patch.object(_origins, "_FEW_POINTS", 0):
            self.assertEqual(found(vertices, faces, origins, directions, 2)[1].tolist(), exact)
            with mock.patch.object(_origins, "_LIST_NUMBERS", 40):
                self.assertEqual(found(vertices, faces, origins, directions)[1].tolist(), exact)
        for point in (vertices[faces[7, 1]], [0, 0, 0], [40, 0, 0]):
            same = np.tile(np.float32(point), (len(origins), 1))
            exact = expected(vertices, faces, same, directions)
            self.assertEqual(found(vertices, faces, same, directions)[1].tolist(), exact.tolist())
            self.assertEqual((exact >= 0).any(), point[0] != 40)

    def test_a_corner_within_another_face(self):
        """A wall, or a triangle without area, stands on the middle of the floor; a ray goes down from its corner."""
        vertices = np.array([[-4, -4, 0], [4, -4, 0], [0, 8, 0], [0, 0, 0], [0, 1, 3], [0, 2, 6], [0, 5, 3]], np.float32)
        for other in ([3, 4, 6], [3, 4, 5], [3, 4, 3]):
            for faces in ([other, [0, 1, 2]], [[0, 1, 2], other]):
                faces, origins = np.array(faces), np.zeros((2, 3), np.float32)
                directions = np.array([[0, 0, -1], [3, 0, -1]], np.float32)
                origins[1] = vertices[0]
                exact = expected(vertices, faces, origins, directions)
                self.assertEqual(exact[0], faces.tolist().index([0, 1, 2]))
                self.assertEqual(found(vertices, faces, origins, directions)[1].tolist(), exact.tolist())

    def test_in_the_plane(self):
        """In integers where float64 leaves it open."""
        vertices = np.array([[0, 0, 0], [1, 1e-30, 3], [2, 5, 1]], np.float32)
        faces, origins = np.array([[0, 1, 2]]), np.zeros((3, 3), np.float32)
        edge = vertices[1] - vertices[0]
        nearly = edge * 1
        nearly[1] = np.nextafter(edge[1], np.float32(1))
        directions = np.array([edge, nearly, [np.nan, 0, 1]], np.float32)
        for row in range(2):
            a, b, c, d = ([Fraction(float(x)) for x in array] for array in (*vertices, directions[row]))
            first, second = ([y - x for x, y in zip(a, end)] for end in (b, c))
            volume = sum(
                d[i] * (first[i - 2] * second[i - 1] - first[i - 1] * second[i - 2]) for i in range(3)
            )
            self.assertEqual(volume != 0, row == 1)
        self.assertEqual(found(vertices, faces, origins, directions)[1].tolist(), [-1, 0, -1])


class Neighbours(unittest.TestCase):
    def test_a_float_beside_the_face_is_not_on_it(self):
        for scale in (1e-38, 1e-3, 1, 3e37):
            vertices, faces = box(-scale, scale)
            z = vertices.max()
            heights = np.array([np.nextafter(z, np.float32(0)), z, np.nextafter(z, np.float32(np.inf))], np.float32)
            origins = np.zeros((3, 3), np.float32)
            origins[:, 2] = heights
            for side in (-1, 1):
                triangles = found(vertices, faces, origins, np.float32([[0.1, 0.2, side]] * 3))[1]
                self.assertEqual((triangles >= 0).tolist(), [False, True, False], (scale, side))

    def test_far_less_than_a_float_beside_the_face(self):
        """On z = x - y, points with y = 2^-60 that lie 2^-60 above or below, or on it."""
        vertices = np.array([[-4, -4, 0], [4, -4, 8], [0, 4, -4]], np.float32)
        y = np.float32(2.0**-60)
        origins = np.array([[1, y, 1], [1, -y, 1], [1, 0, 1], [1, 0.5, 0.5], [0, y, -y], [0, y, y]], np.float32)
        triangles = found(vertices, np.array([[0, 1, 2]]), origins, np.float32([[1, 2, 5]] * 6))[1]
        self.assertEqual(triangles.tolist(), [-1, -1, 0, 0, 0, -1])

    def test_zero_and_slanted_faces(self):
        tiny = np.float32(1e-45)
        vertices = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0], [-1, -1, -1], [1, -1, 1], [0, 3, 0]], np.float32)
        for faces in ([[0, 1, 2]], [[3, 4, 5]]):
            origins = np.array([[0, 0, 0], [0, 0, tiny], [0, 0, -tiny], [tiny, 0, 0]], np.float32)
            triangles = found(vertices, np.array(faces), origins, np.float32([[1, 2, 5]] * 4))[1]
            self.assertEqual(triangles.tolist(), [0, -1, -1, 0 if faces[0][0] == 0 else -1])

    def test_a_tip_of_many_triangles(self):
        count = 700
        angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
        rim = np.stack((np.cos(angles), np.sin(angles), np.zeros(count)), axis=1)
        vertices = np.concatenate((rim, [[0, 0, 1]])).astype(np.float32)
        faces = np.stack((np.arange(count), np.roll(np.arange(count), -1), np.full(count, count)), axis=1)
        origins = np.repeat(vertices[-1:], 50, axis=0)
        origins[::2, 2] = 0.5  # not all the same
        triangles = found(vertices, faces, origins, np.float32([[0, 0, -1]] * 50))[1]
        self.assertEqual(triangles.tolist(), [-1, 0] * 25)

    def test_nothing(self):
        vertices, faces = box()
        for origins in (np.zeros((0, 3), np.float32), np.full((4, 3), np.nan, np.float32), np.full((4, 3), np.inf, np.float32)):
            begins, triangles = found(vertices, faces, origins, np.ones_like(origins))
            self.assertEqual((len(begins.ray), (triangles >= 0).any()), (0, False))
        self.assertEqual(len(found(vertices[:0], faces[:0], np.zeros((2, 3), np.float32), np.ones((2, 3), np.float32))[0].ray), 0)


if __name__ == "__main__":
    unittest.main()
