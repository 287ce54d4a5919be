# SPDX-License-Identifier: MIT
"""Shadows of a picture: against the rays that mlrt_shadow_ray tells, against a scene that one can see through, what is refused."""

import ctypes
import os
import unittest

import numpy as np
from support import assert_same, both_trees, box, integer_scene, isas

import mlrt
from mlrt import _abi
from mlrt._lights import light_structs

# The library as it is, since the package does not wrap mlrt_shadow_ray: bindings/coverage.py must not record calls of this test.
library = ctypes.CDLL(os.environ.get("MLRT_RECORDED") or _abi.library._name)


class Ray(_abi.Struct):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("flags", ctypes.c_uint32),
        ("origin", _abi.Float3),
        ("direction", _abi.Float3),
        ("t_min", ctypes.c_float),
        ("t_max", ctypes.c_float),
        ("skip", ctypes.c_uint32 * 2),
    ]


class Hit(_abi.Struct):
    _fields_ = [
        ("struct_size", ctypes.c_uint32),
        ("t", ctypes.c_float),
        ("u", ctypes.c_float),
        ("v", ctypes.c_float),
        ("mesh", ctypes.c_uint32),
        ("triangle", ctypes.c_uint32),
        ("facing", ctypes.c_int32),
        ("occluded", ctypes.c_uint32),
    ]


def composed(tree, camera, light, mask=0):
    """Which pixels have a shadow: a ray for each hit whose triangle the light faces, traced by Tree.occluded."""
    hits, struct = tree.render(camera, mask=mask), light_structs([light])
    shadow = np.zeros(hits.t.shape, np.bool_)
    pixels, rays = [], []
    origins, directions = camera.rays()
    for pixel in zip(*np.nonzero(hits.hit)):
        ray, told, faces = Ray(), Ray(), ctypes.c_int32()
        ray.origin, ray.direction = _abi.Float3(*origins[pixel]), _abi.Float3(*directions[pixel])
        hit = Hit(mesh=hits.mesh[pixel], triangle=hits.triangle[pixel])
        pointers = [ctypes.byref(argument) for argument in (ray, hit, struct, told, faces)]
        assert library.mlrt_shadow_ray(tree._handle, *pointers) == 0
        if faces:
            pixels.append(pixel)
            rays.append((list(told.origin), list(told.direction), told.t_min, told.t_max or np.inf, list(told.skip)))
        else:
            shadow[pixel] = True
    shadow[tuple(np.transpose(pixels))] = tree.occluded(*zip(*rays), mask=mask)
    return shadow


class Shadows(unittest.TestCase):
    cameras = (
        mlrt.Camera.look_at((3, 20, 4), (0, 0, 0), 40, 30),
        mlrt.Camera.orthographic((3, 20, 4), (0, 0, 0), 37, 21, extent=14),
    )
    lights = ((8, 9, 7), mlrt.DirectionalLight((1, 3, -1)), (0, 30, 0), mlrt.DirectionalLight((-3, 2, 2)))

    @classmethod
    def setUpClass(cls):
        vertices, faces, _, _ = integer_scene(50, triangle_count=90)
        meshes = [(vertices, faces[start : start + 30]) for start in (0, 30, 60)]
        cls.tree = mlrt.Tree.from_meshes(meshes, ids=[7, 3, 5], masks=[1, 2, 6])
        cls.kdtree = mlrt.Tree.kdtree_from_meshes(meshes, ids=[7, 3, 5], masks=[1, 2, 6])

    def test_the_rays_that_are_told(self):
        for camera in self.cameras:
            for mask in (0, 2):
                picture = self.tree.render(camera, lights=self.lights, mask=mask)
                self.assertEqual(picture.occluded.dtype, np.uint8)
                for k, light in enumerate(self.lights):
                    expected = composed(self.tree, camera, light, mask)
                    self.assertTrue(expected.any() and (picture.hit & ~expected).any())
                    self.assertTrue((picture.shadow(k) == expected).all())
                self.assertFalse(picture.occluded[~picture.hit].any())
                self.assertFalse((picture.occluded >> len(self.lights)).any())

    def test_the_same_from_all(self):
        for camera in self.cameras:
            expected = self.tree.render(camera, lights=self.lights)
            hits = self.tree.render(camera)
            assert_same(self, hits._replace(occluded=expected.occluded), expected)
            for isa in isas():
                for method, tree in both_trees(self.tree, self.kdtree):
                    with self.subTest(isa=isa, method=method):
                        assert_same(self, expected, tree.render(camera, lights=self.lights, method=method, isa=isa))
            with mlrt.Pool(3) as pool:
                assert_same(self, expected, self.tree.render(camera, lights=self.lights, pool=pool))

    def test_a_box_over_a_floor(self):
        vertices, faces = box()
        floor = np.array([[-9, -3, -9], [9, -3, -9], [9, -3, 9], [-9, -3, 9]], np.float32)
        tree = mlrt.Tree.from_meshes([(vertices, faces), (floor, [[0, 1, 2], [0, 2, 3]])])
        camera = mlrt.Camera.look_at((4, 5, 7), (0, -1, 0), 50, 50)
        picture = tree.render(camera, lights=[mlrt.DirectionalLight((0, 1, 0)), (0, 3, 0), (0, -2, 0)])
        origins, directions = (array.astype(np.float64) for array in camera.rays())
        on_floor, on_box = picture.mesh == 1, picture.mesh == 0
        points = (origins + np.where(picture.hit, picture.t, 0)[..., None] * directions)
        reach = np.maximum(np.abs(points[..., 0]), np.abs(points[..., 2]))
        top = points[..., 1] > 0.99999
        for k, width in ((0, 1), (1, 3)):  # as wide as the box, and what a light two above it sees of the floor
            shadow = picture.shadow(k)
            self.assertGreater((on_floor & (reach < width)).sum(), 20)
            self.assertTrue(shadow[on_floor & (reach < width - 1e-5)].all())
            self.assertFalse(shadow[on_floor & (reach > width + 1e-5)].any())
            self.assertFalse(shadow[on_box & top].any())
            self.assertTrue(shadow[on_box & ~top].all())
        self.assertFalse(picture.shadow(2)[on_floor].any())
        self.assertTrue(picture.shadow(2)[on_box].all())


class Arguments(unittest.TestCase):
    def setUp(self):
        self.tree, self.camera = mlrt.Tree(*box()), mlrt.Camera.look_at((3, 2, 4), (0, 0, 0), 16, 12)
        self.lights = [(2, 0.5, 0), (0, 0.5, 9)]
        self.expected = self.tree.render(self.camera, lights=self.lights)

    def test_what_says_where_a_light_is(self):
        self.assertEqual(len(np.unique(self.expected.occluded)), 4)
        points = np.array(self.lights, np.float32)
        for lights in (points, points.astype(np.float64)[::-1][::-1], points.tolist(), tuple(points), iter(points)):
            assert_same(self, self.expected, self.tree.render(self.camera, lights=lights))
        suns = [[mlrt.DirectionalLight(point * scale) for point in points] for scale in (1, 4)]
        first, second = (self.tree.render(self.camera, lights=lights, outputs="occluded") for lights in suns)
        assert_same(self, first, second)
        self.assertFalse((first.occluded == self.expected.occluded).all())

    def test_only_what_is_asked_for(self):
        for outputs in (["occluded"], ("t", "occluded"), "t", ["triangle", "occluded", "u"]):
            picture = self.tree.render(self.camera, lights=self.lights, outputs=outputs)
            for name, array in picture._asdict().items():
                if name in outputs:
                    self.assertEqual(array.tobytes(), getattr(self.expected, name).tobytes())
                else:
                    self.assertIsNone(array)
        with self.assertRaises(ValueError):
            self.tree.render(self.camera, lights=self.lights, outputs="t").shadow(0)

    def test_no_lights(self):
        for outputs in (None, "occluded", ("t", "occluded")):
            self.assertFalse(self.tree.render(self.camera, lights=[], outputs=outputs).occluded.any())
        out = mlrt.Hits(t=np.zeros((12, 16), np.float32), occluded=np.full((12, 16), 7, np.uint8))
        self.tree.render(self.camera, lights=(), out=out)
        self.assertFalse(out.occluded.any())
        self.assertTrue((out.t == self.expected.t).all())
        hits = self.tree.render(self.camera)
        self.assertIsNone(hits.occluded)
        assert_same(self, hits, self.tree.render(self.camera, lights=None))

    def test_into_a_larger_picture(self):
        canvas = np.full((30, 40), 0xAA, np.uint8)
        out = mlrt.Hits(occluded=canvas[5:17, 7:39:2])
        self.assertIs(self.tree.render(self.camera, lights=self.lights, out=out), out)
        self.assertTrue((out.occluded == self.expected.occluded).all())
        canvas[5:17, 7:39:2] = 0xAA
        self.assertTrue((canvas == 0xAA).all())

    def test_eight_lights(self):
        picture = self.tree.render(self.camera, lights=self.lights * 4)
        for k in range(8):
            self.assertTrue((picture.shadow(k) == self.expected.shadow(k % 2)).all())
        for k in (-1, 8):
            with self.assertRaises(IndexError):
                picture.shadow(k)

    def test_no_triangles(self):
        empty = mlrt.Tree.from_meshes([])
        self.assertFalse(empty.render(self.camera, lights=self.lights).occluded.any())

    def test_refused(self):
        for lights in (self.lights * 4 + [(0, 0, 1)], [(np.nan, 0, 0)], [mlrt.DirectionalLight((0, np.inf, 0))]):
            with self.assertRaises(mlrt.ArgumentError):
                self.tree.render(self.camera, lights=lights)
        sun = mlrt.DirectionalLight((0, 1, 0))
        for lights in (3, sun, (0, 5, 0), [(0, 5)], [[(0, 5, 0)]], [0], ["sun"], [mlrt.DirectionalLight((1, 2))]):
            with self.assertRaises((ValueError, TypeError), msg=str(lights)):
                self.tree.render(self.camera, lights=lights)
        with self.assertRaises(ValueError):
            self.tree.render(self.camera, outputs="occluded")
        with self.assertRaises(ValueError):
            self.tree.trace([0, 0, 0], [0, 0, 1], outputs="occluded")
        bits = np.zeros((12, 16), np.uint8)
        with self.assertRaises(ValueError):
            self.tree.render(self.camera, out=mlrt.Hits(occluded=bits))
        with self.assertRaises(ValueError):
            self.tree.trace(*self.camera.rays(), out=mlrt.Hits(occluded=bits))
        for array in (bits[1:], bits.astype(np.uint32), bits.astype(np.bool_), bits[:, ::-1]):
            with self.assertRaises(ValueError):
                self.tree.render(self.camera, lights=self.lights, out=mlrt.Hits(occluded=array))


if __name__ == "__main__":
    unittest.main()
