# SPDX-License-Identifier: MIT
"""Who lives how long: trees, pools, arrays; and threads of Python's own."""

import copy
import gc
import os
import pickle
import threading
import unittest
import weakref

import numpy as np
from support import box, integer_scene

import mlrt


class Lifetime(unittest.TestCase):
    def test_with_and_close(self):
        with mlrt.Tree(*box()) as tree:
            self.assertTrue(tree.occluded([0, 0, 0], [0, 0, 1]))
        with self.assertRaises(ValueError):
            tree.trace([0, 0, 0], [0, 0, 1])
        with self.assertRaises(ValueError):
            tree.info
        tree.close()
        pool = mlrt.Pool(2)
        pool.close()
        with self.assertRaises(ValueError):
            mlrt.Tree(*box()).occluded([0, 0, 0], [0, 0, 1], pool=pool)

    def test_trees_are_freed_and_results_stay(self):
        tree = mlrt.Tree(*box())
        handle, hits = weakref.ref(tree._handle), tree.trace([0, 0, 0], [0, 0, 1])
        del tree
        gc.collect()
        self.assertIsNone(handle())
        self.assertEqual(float(hits.t), 1)

    def test_meshes_may_go(self):
        vertices, faces, origins, directions = integer_scene(9)
        tree = mlrt.Tree(vertices, faces)
        expected = tree.trace(origins, directions).triangle.copy()
        vertices[:] = faces[:] = 0
        self.assertTrue((tree.trace(origins, directions).triangle == expected).all())

    def test_failed_objects_are_collected_quietly(self):
        with self.assertRaises(ValueError):
            mlrt.Tree(np.zeros((1, 2)), None)
        gc.collect()

    def test_temporary_arrays_live_through_the_call(self):
        tree = mlrt.Tree(*box())
        for _ in range(50):
            hits = tree.trace(np.zeros((1000, 3)), np.ones((1000, 6))[:, ::2], t_max=np.full(1000, 9.0))
            self.assertTrue((hits.t == 1).all())


class Threads(unittest.TestCase):
    def test_one_tree_and_one_pool_in_many_threads(self):
        vertices, faces, origins, directions = integer_scene(10)
        tree, pool = mlrt.Tree(vertices, faces), mlrt.Pool(2)
        expected = tree.trace(origins, directions).triangle
        failures = []

        def work(pool):
            for _ in range(20):
                if (tree.trace(origins, directions, pool=pool).triangle != expected).any():
                    failures.append(pool)

        threads = [threading.Thread(target=work, args=(pool if i % 2 else None,)) for i in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failures, [])

    def test_closing_does_not_disturb_calls(self):
        vertices, faces, origins, directions = integer_scene(11)
        origins, directions = np.tile(origins, (40, 1)), np.tile(directions, (40, 1))
        expected = mlrt.Tree(vertices, faces).trace(origins, directions).triangle
        for _ in range(5):
            tree, pool, results = mlrt.Tree(vertices, faces), mlrt.Pool(2), []

            def work():
                while True:
                    try:
                        results.append(tree.trace(origins, directions, pool=pool).triangle)
                    except ValueError:
                        return

            thread = threading.Thread(target=work)
            thread.start()
            while not results:
                pass
            tree.close()
            pool.close()
            thread.join()
            self.assertTrue(all((result == expected).all() for result in results))

    def test_copies_of_pools(self):
        tree, pool = mlrt.Tree(*box()), mlrt.Pool(2)
        for copied in (copy.copy(pool), copy.deepcopy(pool)):
            self.assertIs(copied.handle(), pool.handle())
            copied.close()
            self.assertTrue(tree.occluded([0, 0, 0], [0, 0, 1], pool=pool))
        for owner in (pool, pool.handle(), tree._handle):
            for duplicate in (pickle.dumps, copy.copy, copy.deepcopy):
                if duplicate is pickle.dumps or owner is not pool:
                    with self.assertRaises(TypeError):
                        duplicate(owner)

    @unittest.skipUnless(hasattr(os, "fork"), "needs fork")
    def test_a_pool_stays_in_its_process(self):
        tree, pool = mlrt.Tree(*box()), mlrt.Pool(2)
        child = os.fork()
        if child == 0:
            code = 1
            try:
                tree.occluded([0, 0, 0], [0, 0, 1], pool=pool)
            except RuntimeError:
                code = 0 if tree.occluded([0, 0, 0], [0, 0, 1]) else 2
            pool.close()
            os._exit(code)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)


if __name__ == "__main__":
    unittest.main()
