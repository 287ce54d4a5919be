# SPDX-License-Identifier: MIT
"""The RayMeshIntersector, on an object that has what it needs of a trimesh.Trimesh."""

import copy
import importlib.util
import pickle
import unittest

import numpy as np
from support import box

import mlrt
import mlrt.trimesh
from mlrt.trimesh import RayMeshIntersector


class Mesh:
    """Vertices, faces, and a hash of both."""

    is_watertight = True

    def __init__(self, vertices, faces):
        self.vertices, self.faces = np.asarray(vertices, np.float64), np.asarray(faces, np.int64)

    def __hash__(self):
        return hash((self.vertices.tobytes(), self.faces.tobytes()))


def stack(count):
    """Squares at z = 0, 1, 2, ... made of two triangles each."""
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    vertices = np.concatenate([square + (0, 0, z) for z in range(count)])
    return Mesh(vertices, np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * z for z in range(count)]))


class Queries(unittest.TestCase):
    def test_first_any_and_location(self):
        ray = RayMeshIntersector(Mesh(*box()))
        origins, directions = [[0.25, 0.5, 5], [9, 9, 9]], [[0, 0, -2], [0, 0, -2]]
        first = ray.intersects_first(origins, directions)
        self.assertEqual((first.dtype, first[1]), (np.int64, -1))
        self.assertEqual(ray.intersects_any(origins, directions).tolist(), [True, False])
        locations, index_ray, index_tri = ray.intersects_location(origins, directions)
        self.assertEqual(locations.tolist(), [[0.25, 0.5, 1], [0.25, 0.5, -1]])
        self.assertEqual((index_ray.tolist(), index_tri[0]), ([0, 0], first[0]))
        locations, index_ray, index_tri = ray.intersects_location(origins, directions, multiple_hits=False)
        self.assertEqual((locations.tolist(), index_tri.tolist()), ([[0.25, 0.5, 1]], [first[0]]))

    def test_another_thread_builds_the_same_tree(self):
        class Forgetting(RayMeshIntersector):
            """Another thread's first query is always about to end its build."""

            _planes = property(lambda self: None, lambda self, value: None)

        locations = Forgetting(Mesh(*box())).intersects_location([[0.25, 0.5, 5]], [[0, 0, -2]])[0]
        self.assertEqual(locations.tolist(), [[0.25, 0.5, 1], [0.25, 0.5, -1]])

    def test_one_hit_per_place_on_an_edge(self):
        ray = RayMeshIntersector(stack(2))
        index_tri, index_ray = ray.intersects_id([[0, 0, 5]], [[0, 0, -1]])
        self.assertEqual((index_tri.tolist(), index_ray.tolist()), ([2, 0], [0, 0]))

    def test_more_hits_than_the_first_lists_hold(self):
        ray = RayMeshIntersector(stack(100))
        origins = [[0.5, 0, 200], [0.5, 0, 3.5], [5, 0, 200]]
        index_tri, index_ray, locations = ray.intersects_id(origins, [[0, 0, -1]] * 3, return_locations=True)
        self.assertEqual(np.bincount(index_ray, minlength=3).tolist(), [100, 4, 0])
        self.assertEqual(locations[index_ray == 0, 2].tolist(), list(range(99, -1, -1)))
        index_tri, index_ray = ray.intersects_id(origins, [[0, 0, -1]] * 3, max_hits=3)
        self.assertEqual(index_ray.tolist(), [0, 1, 0, 1, 0, 1])

    def test_contains(self):
        ray = RayMeshIntersector(Mesh(*box()))
        self.assertEqual(ray.contains_points([[0, 0, 0], [0, 0, 2], [0.9, -0.9, 0.9]]).tolist(), [True, False, True])

    def test_open_meshes_contain_nothing_above_them(self):
        mesh = stack(1)
        mesh.is_watertight = False
        self.assertFalse(RayMeshIntersector(mesh).contains_points([[0.5, 0, 1], [0.5, 0, -1]]).any())

    def test_far_from_zero(self):
        vertices, faces = box(-0.001, 0.001)
        far = np.array([5e5, -2e6, 0])
        ray = RayMeshIntersector(Mesh(vertices + far, faces))
        locations, _, _ = ray.intersects_location([far + (0.0005, 0.0003, 5)], [[0, 0, -1]])
        self.assertTrue(np.allclose(locations - far, [[0.0005, 0.0003, 0.001], [0.0005, 0.0003, -0.001]], atol=1e-8))

    def test_the_face_that_a_ray_begins_on(self):
        for count, hits_at_origin in ((2, True), (2, None), (1, False)):
            ray = RayMeshIntersector(Mesh(*box()), hits_at_origin=hits_at_origin)
            arrays = [[0.25, 0.5, 1]], [[0, 0, -1]]
            index_tri, index_ray, locations = ray.intersects_id(*arrays, return_locations=True)
            self.assertEqual(locations.tolist(), [[0.25, 0.5, 1], [0.25, 0.5, -1]][-count:])
            self.assertEqual(ray.intersects_first(*arrays).tolist(), index_tri[:1].tolist())
            self.assertEqual(ray.intersects_id(*arrays, multiple_hits=False)[0].tolist(), index_tri[:1].tolist())
            self.assertEqual(len(ray.intersects_id(*arrays, max_hits=1)[0]), 1)
            self.assertEqual(ray.intersects_any([[0.25, 0.5, 1]], [[0, 0, 1]]).tolist(), [count == 2])
            self.assertFalse(ray.intersects_any([[0.25, 0.5, 1 + 1e-7]], [[0, 0, 1]])[0])
            for other in (copy.copy(ray), pickle.loads(pickle.dumps(ray))):
                self.assertEqual(len(other.intersects_id(*arrays)[0]), count)

    def test_nothing(self):
        ray = RayMeshIntersector(Mesh(*box()))
        nothing = np.zeros((0, 3))
        for arrays in ((nothing, nothing), ([[9, 9, 9]], [[0, 0, 1]])):
            index_tri, index_ray, locations = ray.intersects_id(*arrays, return_locations=True)
            self.assertEqual((index_tri.shape, index_ray.shape, locations.shape), ((0,), (0,), (0, 3)))
        self.assertEqual(RayMeshIntersector(Mesh(nothing, nothing)).intersects_first([[0, 0, 0]], [[0, 0, 1]]).tolist(), [-1])

    def test_wrong_shapes(self):
        ray = RayMeshIntersector(Mesh(*box()))
        with self.assertRaises(ValueError):
            ray.intersects_any([[0, 0, 0]], [[0, 0, 1]] * 2)
        with self.assertRaises(ValueError):
            ray.contains_points([0, 0, 0])


class Threads(unittest.TestCase):
    def test_a_number_of_threads_survives_copies(self):
        ray = RayMeshIntersector(Mesh(*box()), pool=2)
        self.assertRegex(repr(ray), "12 faces, no tree yet")
        self.assertTrue(ray.intersects_any([[0, 0, 5]], [[0, 0, -1]]).all())
        self.assertRegex(repr(ray), r"12 faces, a tree of \d+ bytes")
        for other in (copy.copy(ray), pickle.loads(pickle.dumps(ray))):
            self.assertEqual(other._pool, 2)
        with mlrt.Pool(1) as pool:
            self.assertIsNone(pickle.loads(pickle.dumps(RayMeshIntersector(Mesh(*box()), pool=pool)))._pool)


@unittest.skipUnless(importlib.util.find_spec("trimesh"), "trimesh is not installed (make deps-python): install is not tested")
class Installed(unittest.TestCase):
    def setUp(self):
        self.trimesh = importlib.import_module("trimesh")
        self.addCleanup(mlrt.trimesh.uninstall)

    def test_all_meshes_have_it(self):
        own = type(self.trimesh.creation.box().ray)
        self.assertIsNot(own, RayMeshIntersector)
        mlrt.trimesh.install(pool=2)
        mlrt.trimesh.install(pool=2)
        mesh = self.trimesh.creation.icosphere()
        for one in (mesh, mesh.copy(), self.trimesh.Trimesh(mesh.vertices, mesh.faces, use_embree=False)):
            self.assertIs(type(one.ray), RayMeshIntersector)
            self.assertEqual((one.ray._pool, one.ray.hits_at_origin), (2, True))
        self.assertTrue(mesh.contains([[0, 0, 0]]).all())
        mlrt.trimesh.install(hits_at_origin=False)
        self.assertFalse(self.trimesh.creation.box().ray.hits_at_origin)
        mlrt.trimesh.uninstall()
        self.assertIs(type(self.trimesh.creation.box().ray), own)
        self.assertTrue(RayMeshIntersector(mesh).hits_at_origin)

    @unittest.skipUnless(importlib.util.find_spec("embreex"), "embreex is not installed (make deps-python): orders are not compared")
    def test_hits_are_in_the_order_of_embreex(self):
        mesh = self.trimesh.creation.icosphere(subdivisions=2)
        parts = [mesh.copy().apply_translation((3 * i, 0, 0)) for i in range(3)]
        mesh = self.trimesh.util.concatenate(parts)
        random = np.random.default_rng(4)
        origins = random.normal(size=(2000, 3)) * (4, 2, 2)
        directions = random.normal(size=(2000, 3)) * (3, 1, 1)
        embree = importlib.import_module("trimesh.ray.ray_pyembree").RayMeshIntersector(mesh)
        for multiple_hits in (True, False):
            expected = embree.intersects_id(origins, directions, multiple_hits=multiple_hits)
            found = RayMeshIntersector(mesh).intersects_id(origins, directions, multiple_hits=multiple_hits)
            self.assertEqual(found[0].tolist(), expected[0].tolist())
            self.assertEqual(found[1].tolist(), expected[1].tolist())
            self.assertGreater(len(found[0]), 200)


class Changes(unittest.TestCase):
    def test_a_changed_mesh_gets_a_new_tree(self):
        mesh = Mesh(*box())
        ray = RayMeshIntersector(mesh)
        self.assertTrue(ray.intersects_any([[0, 0, 5]], [[0, 0, -1]]).all())
        mesh.vertices = mesh.vertices + (7, 0, 0)
        self.assertFalse(ray.intersects_any([[0, 0, 5]], [[0, 0, -1]]).any())

    def test_copies(self):
        ray = RayMeshIntersector(Mesh(*box()))
        ray.intersects_any([[0, 0, 5]], [[0, 0, -1]])
        for other in (copy.copy(ray), copy.deepcopy(ray), pickle.loads(pickle.dumps(ray))):
            self.assertTrue(other.intersects_any([[0, 0, 5]], [[0, 0, -1]]).all())


if __name__ == "__main__":
    unittest.main()
