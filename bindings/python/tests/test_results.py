# SPDX-License-Identifier: MIT
"""What hits tell besides their arrays: points, normals, weights; what objects print; counts that do not fit; numbers of threads."""

import copy
import inspect
import pickle
import unittest

import numpy as np
from support import assert_same, box, integer_scene

import mlrt


class Points(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.vertices, cls.faces, cls.origins, cls.directions = integer_scene(11)
        cls.tree = mlrt.Tree(cls.vertices, cls.faces)
        cls.hits = cls.tree.trace(cls.origins, cls.directions)

    def test_points_are_those_of_the_weights(self):
        hit = self.hits.hit
        corners = self.vertices[self.faces[self.hits.triangle[hit]]]
        expected = (self.hits.barycentrics[hit][..., None] * corners).sum(axis=1)
        self.assertTrue(np.allclose(self.hits.points[hit], expected, atol=1e-4))
        self.assertGreater(hit.sum(), 50)
        for array in (self.hits.points, self.hits.barycentrics, self.hits.normals((self.vertices, self.faces))):
            self.assertEqual((array.dtype, array.shape), (np.float32, self.origins.shape))
            self.assertTrue(np.isnan(array[~hit]).all() and np.isfinite(array[hit]).all())

    def test_points_of_all_calls(self):
        camera = mlrt.Camera.look_at((3, 2, 14), (0, 0, 0), 12, 8)
        picture, rays = self.tree.render(camera), camera.rays()
        camera.eye = (9, 9, 9)  # no other rays than those that were traced
        self.assertEqual(picture.points.tobytes(), self.tree.trace(*rays).points.tobytes())
        self.assertTrue(picture.hit.any())
        one = self.tree.trace(self.origins[:1], self.directions[:1], outputs="t")
        self.assertEqual(one.points.tobytes(), self.hits.points[:1].tobytes())
        out = self.tree.trace(self.origins[:96].reshape(8, 12, 3), self.directions[:96].reshape(8, 12, 3))
        self.tree.render(camera, out=out)  # arrays that are used again are of other rays now
        self.assertEqual(out.points.tobytes(), self.tree.render(camera).points.tobytes())
        self.tree.trace(*rays, out=out)
        self.assertEqual(out.points.tobytes(), picture.points.tobytes())
        given = mlrt.Hits(t=np.empty(len(self.origins), np.float32))
        self.assertEqual(self.tree.trace(self.origins, self.directions, out=given).points.tobytes(), self.hits.points.tobytes())
        with self.assertRaisesRegex(TypeError, "out: a mlrt.Hits is needed"):
            self.tree.trace(self.origins, self.directions, out=tuple(given))
        shared = mlrt.Tree(*box()).trace([0, 0, 0], np.eye(3, dtype=np.float32)[None])
        self.assertEqual(shared.points.tolist(), np.eye(3)[None].tolist())

    def test_normals(self):
        hit = self.hits.hit
        normals = self.hits.normals((self.vertices, self.faces))
        self.assertTrue(np.allclose(np.linalg.norm(normals[hit], axis=1), 1, atol=1e-6))
        along = np.sign((normals * self.directions).sum(axis=1))
        self.assertEqual(along[hit].tolist(), self.hits.facing[hit].tolist())
        mesh = type("Mesh", (), {"vertices": self.vertices, "faces": self.faces})()
        self.assertEqual(self.hits.normals(mesh).tobytes(), normals.tobytes())
        soup = self.vertices[self.faces].reshape(-1, 3)
        self.assertEqual(mlrt.Tree(soup).trace(self.origins, self.directions).normals((soup, None)).tobytes(), normals.tobytes())

    def test_normals_of_several_meshes(self):
        meshes = {7: (self.vertices, self.faces[:20]), 2: (self.vertices, self.faces[20:])}
        hits = mlrt.Tree.from_meshes(meshes).trace(self.origins, self.directions)
        self.assertEqual(set(hits.mesh[hits.hit].tolist()), {7, 2})
        normals = self.hits.normals((self.vertices, self.faces))
        self.assertEqual(hits.normals(meshes).tobytes(), normals.tobytes())
        listed = mlrt.Tree.from_meshes(list(meshes.values())).trace(self.origins, self.directions)
        self.assertEqual(listed.normals(list(meshes.values())).tobytes(), normals.tobytes())
        with self.assertRaisesRegex(ValueError, "mesh: there is none with id 2"):
            hits.normals({7: meshes[7]})
        with self.assertRaisesRegex(ValueError, "mesh: number 1 has 3 triangles"):
            listed.normals([meshes[7], (self.vertices, self.faces[:3])])
        with self.assertRaisesRegex(ValueError, "ids: the dictionary"):
            mlrt.Tree.from_meshes(meshes, ids=[1, 2])

    def test_what_is_missing_is_named(self):
        only_t = self.tree.trace(self.origins, self.directions, outputs="t")
        with self.assertRaisesRegex(ValueError, "u was not asked for"):
            only_t.barycentrics
        with self.assertRaisesRegex(ValueError, "triangle was not asked for"):
            only_t.normals((self.vertices, self.faces))
        with self.assertRaisesRegex(ValueError, "t was not asked for"):
            self.tree.trace(self.origins, self.directions, outputs="u").points
        for hits in (mlrt.Hits._make(self.hits), pickle.loads(pickle.dumps(self.hits)), copy.copy(self.hits)):
            assert_same(self, hits, self.hits)
            with self.assertRaisesRegex(ValueError, "know no rays"):
                hits.points


class Texts(unittest.TestCase):
    def test_reprs_have_numbers_in_them(self):
        tree = mlrt.Tree(*box(-1, 2))
        self.assertRegex(repr(tree), r"^<Tree of 12 triangles: boxes with \d+ nodes, \d+ bytes, from \(-1, -1, -1\) to \(2, 2, 2\)>$")
        self.assertIn("a kd-tree", repr(mlrt.Tree.kdtree(*box())))
        hits = tree.trace(np.zeros((4, 5, 3)), [[0, 0, 1]] * 4 + [[0, 0, 0]])
        self.assertEqual(repr(hits), "<Hits of 20 rays (4, 5): 16 hit, t from 2 to 2; t, u, v, mesh, triangle, facing>")
        self.assertEqual(repr(tree.trace([0, 0, 0], [0, 0, 1], outputs="u")), "<Hits of 1 rays (): u>")
        self.assertEqual(repr(mlrt.Hits()), "Hits()")
        lists = tree.hits(np.zeros((3, 3)), [0, 0, 1], 2, outputs=("t", "total"))
        self.assertEqual(repr(lists), "<HitLists of 3 rays, k = 2: 6 hits, at most 2 of a ray; t, total>")
        camera = repr(mlrt.Camera.look_at((0, 0, 5), (0, 0, 0), 40, 30))
        self.assertRegex(camera, r"^<Camera of 40 x 30 pixels, pinhole: eye=\(0, 0, 5\), d00=\(-0.55")
        with mlrt.Pool(3) as pool:
            self.assertEqual(repr(pool), "<Pool of 3 threads>")
        self.assertEqual(repr(pool), "<Pool, closed>")
        counters = mlrt.Counters()
        tree.trace(np.zeros((4, 3)), [0, 0, 1], counters=counters)
        self.assertRegex(repr(counters), r"^<Counters: ray_count=4, ")
        tree.close()
        self.assertEqual(repr(tree), "<Tree, closed>")

    def test_signatures_are_names(self):
        for function in (mlrt.Tree, mlrt.Tree.trace, mlrt.Tree.hits, mlrt.Tree.from_meshes, mlrt.Tree.kdtree, mlrt.Tree.render):
            text = str(inspect.signature(function))
            for part in ("Union", "_SupportsArray", "numpy._typing", "Unpack", "**"):
                self.assertNotIn(part, text)
        self.assertIn("'Vectors'", str(inspect.signature(mlrt.Tree.trace)))
        self.assertIn("preset: 'Preset' = 'default'", str(inspect.signature(mlrt.Tree)))


class Misfits(unittest.TestCase):
    def test_counts_that_differ_are_named(self):
        tree, rays = mlrt.Tree(*box()), np.zeros((2, 3))
        for arguments, text in (
            ({"directions": np.zeros((4, 3))}, r"^directions: 4 are given, but 2 origins; the shapes are origins \(2, 3\), directions \(4, 3\)"),
            ({"t_max": np.zeros(5)}, r"^t_max: 5 are given, but 2 origins"),
            ({"mask": np.zeros(5, int)}, r"^mask: 5 are given, but 2 origins"),
            ({"skip": np.zeros((7, 2), int)}, r"^skip: 7 are given, but 2 origins"),
            ({"directions": np.zeros((4, 3, 3))}, r"^directions: 3 are given, but 2 origins along the axis of rays number -1"),
        ):
            with self.assertRaisesRegex(ValueError, text):
                tree.trace(rays, **{"directions": rays, **arguments})
        with self.assertRaisesRegex(ValueError, "^masks: 1 are given for 2 meshes"):
            mlrt.Tree.from_meshes([box(), box()], masks=[1])


class Threads(unittest.TestCase):
    def test_numbers_of_threads(self):
        vertices, faces, origins, directions = integer_scene(3)
        tree = mlrt.Tree(vertices, faces, pool=2)
        expected = tree.trace(origins, directions)
        for threads in (0, 1, 2, np.int64(2)):
            assert_same(self, tree.trace(origins, directions, pool=threads), expected)
        camera = mlrt.Camera.look_at((0, 0, 20), (0, 0, 0), 32, 32)
        assert_same(self, tree.render(camera, pool=2), tree.render(camera))
        self.assertEqual(tree.occluded(origins, directions, pool=2).tolist(), expected.hit.tolist())

    def test_a_pool_knows_its_threads(self):
        with mlrt.Pool(0) as pool:
            self.assertGreaterEqual(pool.threads, 1)
            self.assertEqual(repr(pool), f"<Pool of {pool.threads} threads>")
        with mlrt.Pool(2) as pool:
            self.assertEqual(pool.threads, 2)
        self.assertEqual(pool.threads, 2)

    def test_one_pool_for_a_number(self):
        from mlrt._pool import pool_handle

        self.assertIs(pool_handle(2), pool_handle(2))
        self.assertIsNot(pool_handle(2), pool_handle(1))

    def test_refused(self):
        tree = mlrt.Tree(*box())
        for pool, error in ((-1, ValueError), (5000, ValueError), (True, TypeError), ("4", TypeError), (1.5, TypeError)):
            with self.assertRaises(error):
                tree.trace([[0, 0, 0]], [[0, 0, 1]], pool=pool)


if __name__ == "__main__":
    unittest.main()
