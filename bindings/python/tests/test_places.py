# SPDX-License-Identifier: MIT
"""All places of rays: pass after pass gives what lists of hits give."""

import unittest
from unittest import mock

import numpy as np
from support import integer_scene

import mlrt
from mlrt import _places
from mlrt._origins import begins


def scenes():
    """Rays through edges and corners of coplanar triangles, which hit several at the same t; and general ones."""
    for seed in range(3):
        yield integer_scene(seed, triangle_count=200, ray_count=1000)
        random = np.random.default_rng(seed)
        vertices = random.normal(size=(300, 3)).astype(np.float32)
        faces = random.integers(0, 300, (400, 3)).astype(np.uint32)
        # Nearly coincident triangles: different hits at the same rounded t.
        vertices[150:] = vertices[:150] + np.float32(1e-7) * random.normal(size=(150, 3)).astype(np.float32)
        faces[200:] = faces[:200] % 150 + 150
        faces[:200] %= 150
        origins, directions = random.normal(size=(2, 1000, 3)).astype(np.float32)
        yield vertices, faces, 3 * origins, directions


class Places(unittest.TestCase):
    def test_passes_equal_lists(self):
        several = 0
        for vertices, faces, origins, directions in scenes():
            tree = mlrt.Tree(vertices, faces)
            found = begins(tree, vertices, faces, origins, directions, None)
            for limit in (None, 0, 1, 3):
                for weights in (True, False):
                    arguments = tree, origins, directions, found, limit, weights, None
                    with mock.patch.object(_places, "_FEW", 1 << 30):
                        lists = _places.all_places(*arguments)
                    with mock.patch.object(_places, "_FEW", 0):
                        passes = _places.all_places(*arguments)
                    for name, one, other in zip(lists._fields, lists, passes):
                        self.assertEqual(one.tobytes(), other.tobytes(), name)
            several += len(lists.ray) - len(np.unique(lists.ray))
        self.assertGreater(several, 500)

    def test_places_are_by_rank_and_ray(self):
        """The order of trimesh with embreex, which traces all rays, then all that hit from where they hit, and so on."""
        vertices, faces, origins, directions = integer_scene(8, triangle_count=200)
        tree = mlrt.Tree(vertices, faces)
        found = begins(tree, vertices, faces, origins, directions, None)
        self.assertGreater(len(found.ray), 3)
        for few in (0, 100, 1 << 30):
            with mock.patch.object(_places, "_FEW", few):
                places = _places.all_places(tree, origins, directions, found, None, True, None)
            seen, last = {}, (0, -1)
            for ray, t in zip(places.ray.tolist(), places.t.tolist()):
                rank, before = seen.get(ray, (-1, -1.0))
                self.assertGreater(t, before)
                self.assertLess(last, (rank + 1, ray))
                seen[ray], last = (rank + 1, t), (rank + 1, ray)
            self.assertGreater(last[0], 3)

    def test_first_places(self):
        vertices, faces, origins, directions = integer_scene(9)
        tree = mlrt.Tree(vertices, faces)
        for found in (None, begins(tree, vertices, faces, origins, directions, None)):
            first = _places.first_places(tree, origins, directions, found, True, None)
            all_of_one = _places.all_places(tree, origins, directions, found, 1, True, None)
            for name, one, other in zip(first._fields, first, all_of_one):
                self.assertEqual(one.tobytes(), other.tobytes(), name)


if __name__ == "__main__":
    unittest.main()
