# SPDX-License-Identifier: MIT
"""Masks: rays see the meshes that have a bit in common with them, and no others."""

import unittest

import numpy as np
from support import assert_same, box, integer_scene

import mlrt

MASKS = (1, 2, 6)


class Masks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        vertices, faces, cls.origins, cls.directions = integer_scene(30, triangle_count=90)
        cls.meshes = [(vertices, faces[start : start + 30]) for start in (0, 30, 60)]
        cls.tree = mlrt.Tree.from_meshes(cls.meshes, masks=MASKS)

    def seen(self, mask):
        """The tree of the meshes that a ray sees."""
        ids = [i for i, word in enumerate(MASKS) if word & mask]
        return mlrt.Tree.from_meshes([self.meshes[i] for i in ids], ids=ids)

    def test_one_for_all(self):
        results = set()
        for mask in (1, 2, 3, 4, 5, 8, -1, ~4, np.uint32(6), np.int64(1)):
            seen = self.seen(int(mask))
            with self.subTest(mask=mask), mlrt.Pool(2) as pool:
                hits = self.tree.trace(self.origins, self.directions, mask=mask)
                results.add(hits.triangle.tobytes())
                assert_same(self, hits, seen.trace(self.origins, self.directions))
                assert_same(self, hits, self.tree.trace(self.origins, self.directions, mask=mask, pool=pool))
                occluded = self.tree.occluded(self.origins, self.directions, mask=mask)
                self.assertTrue((occluded == seen.occluded(self.origins, self.directions)).all())
                lists = self.tree.hits(self.origins, self.directions, 4, mask=mask)
                assert_same(self, lists, seen.hits(self.origins, self.directions, 4))
        self.assertGreater(len(results), 5)

    def test_all_bits(self):
        expected = self.tree.trace(self.origins, self.directions)
        for mask in (None, 0, -1, 2**32 - 1, np.zeros(500, np.uint32), np.full(500, -1)):
            assert_same(self, expected, self.tree.trace(self.origins, self.directions, mask=mask))
        assert_same(self, expected, mlrt.Tree.from_meshes(self.meshes).trace(self.origins, self.directions, mask=8))

    def test_one_for_each_ray(self):
        masks = np.random.default_rng(1).integers(1, 8, 500)
        wide = np.zeros((500, 3), np.uint32)
        wide[:, 1] = masks
        for given in (masks.astype(np.uint32), masks, masks.tolist(), masks.astype(np.uint8), wide[:, 1], masks[::-1].copy()[::-1]):
            hits = self.tree.trace(self.origins, self.directions, mask=given)
            occluded = self.tree.occluded(self.origins, self.directions, mask=given)
            lists = self.tree.hits(self.origins, self.directions, 3, mask=given)
            for mask in range(1, 8):
                which = np.flatnonzero(masks == mask)
                expected = self.tree.trace(self.origins, self.directions, mask=mask)
                assert_same(self, hits, expected, which)
                self.assertTrue((occluded[which] == expected.hit[which]).all())
                assert_same(self, lists, self.tree.hits(self.origins, self.directions, 3, mask=mask), which)

    def test_broadcast(self):
        grid = self.tree.trace(self.origins[:8], self.directions[:8], mask=np.array([[1], [2], [4]], np.uint32))
        self.assertEqual(grid.t.shape, (3, 8))
        for row, mask in enumerate((1, 2, 4)):
            expected = self.tree.trace(self.origins[:8], self.directions[:8], mask=mask)
            self.assertEqual(grid.triangle[row].tobytes(), expected.triangle.tobytes())

    def test_pictures(self):
        camera = mlrt.Camera.look_at((3, 20, 4), (0, 0, 0), 50, 40)
        rays = camera.rays()
        for mask in MASKS:
            picture = self.tree.render(camera, mask=mask)
            self.assertTrue(picture.hit.any())
            assert_same(self, picture, self.tree.trace(*rays, mask=mask))

    def test_inside(self):
        tree = mlrt.Tree.from_meshes([box(-1, 1), box(2, 3)], masks=[1, 2])
        points = [[0, 0, 0], [2.5, 2.5, 2.5]]
        self.assertEqual(tree.contains(points, (0, 0, 1), mask=1).tolist(), [True, False])
        self.assertEqual(tree.contains(points, (0, 0, 1), mask=[2, 2]).tolist(), [False, True])

    def test_one_mesh(self):
        tree = mlrt.Tree(*box(), mask=4)
        self.assertEqual(tree.occluded([0, 0, 0], [0, 0, 1], mask=[3, 4, 7]).tolist(), [False, True, True])

    def test_refused(self):
        for mask in (0.5, 1 << 32, -(1 << 31) - 1, "all", [1, 1 << 32], [0.5], np.zeros(7, np.uint32)):
            with self.assertRaises((ValueError, TypeError), msg=str(mask)):
                self.tree.trace(self.origins, self.directions, mask=mask)
        with self.assertRaises((ValueError, TypeError)):
            self.tree.render(mlrt.Camera.look_at((3, 20, 4), (0, 0, 0), 5, 4), mask=[1])
        for masks in ([1], [1, 2, 1 << 32], [1, 2, 0.5]):
            with self.assertRaises((ValueError, TypeError)):
                mlrt.Tree.from_meshes(self.meshes, masks=masks)


if __name__ == "__main__":
    unittest.main()
