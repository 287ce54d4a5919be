# SPDX-License-Identifier: MIT
"""Bars: calls in pieces give what whole calls give, bars reach their end, and what is raised in them arrives."""

import subprocess
import sys
import types
import unittest
from unittest import mock

import numpy as np
from support import assert_same, integer_scene

import mlrt
from mlrt import _progress


class FakeBar:
    """Stands for tqdm.auto.tqdm."""

    made: list = []
    error = None

    def __init__(self, total, unit, unit_scale):
        self.total, self.steps, self.closed = total, [], False
        FakeBar.made.append(self)

    def update(self, count):
        if FakeBar.error is not None:
            raise FakeBar.error
        self.steps.append(count)

    def close(self):
        self.closed = True


class Progress(unittest.TestCase):
    def setUp(self):
        FakeBar.made, FakeBar.error = [], None
        module = types.ModuleType("tqdm.auto")
        module.tqdm = FakeBar
        patches = (
            mock.patch.dict(sys.modules, {"tqdm": types.ModuleType("tqdm"), "tqdm.auto": module}),
            mock.patch.object(_progress, "PIECE_RAYS", 100),
            mock.patch.object(_progress, "SHARED_PIECE_RAYS", 200),
        )
        for patch in patches:
            patch.start()
            self.addCleanup(patch.stop)
        vertices, faces, self.origins, self.directions = integer_scene(20)
        self.tree = mlrt.Tree.from_meshes([(vertices, faces[:30]), (vertices, faces[30:])], masks=[1, 2])

    def finished_bar(self, total):
        self.assertEqual(len(FakeBar.made), 1)
        bar = FakeBar.made.pop()
        self.assertEqual((bar.total, sum(bar.steps), bar.closed), (total, total, True))
        return bar

    def test_functions_are_not_progress(self):
        vertices, faces, origins, directions = integer_scene(21)
        calls = (
            lambda: mlrt.Tree(vertices, faces, progress=print),
            lambda: mlrt.Tree.kdtree(vertices, faces, progress=print),
            lambda: self.tree.trace(origins, directions, progress=print),
            lambda: self.tree.occluded(origins, directions, progress=print),
            lambda: self.tree.hits(origins, directions, k=1, progress=print),
            lambda: self.tree.render(mlrt.Camera(4, 4, (-1, -1, 5), (0.5, 0, 0), (0, 0.5, 0)), progress=print),
        )
        for call in calls:
            with self.assertRaisesRegex(TypeError, "progress: True or False, not builtin_function_or_method"):
                call()
        self.assertEqual(FakeBar.made, [])

    def test_pieces_equal_the_whole(self):
        wide = np.zeros((500, 7), np.float32)
        wide[:, 2:5] = self.origins
        expected = self.tree.trace(self.origins, self.directions)
        second = {"t_min": expected.t, "skip": np.stack((expected.mesh, expected.triangle), axis=-1)}
        masks = np.arange(500, dtype=np.uint32) % 3 + 1
        for arguments in ({}, {"t_max": np.full(500, 0.7)}, second, {"mask": 1}, {"mask": masks}):
            for origins in (self.origins, wide[:, 2:5], self.origins.astype(np.float64)):
                whole = self.tree.trace(origins, self.directions, **arguments)
                pieces = self.tree.trace(origins, self.directions, **arguments, progress=True)
                self.assertEqual(len(self.finished_bar(500).steps), 5)
                assert_same(self, whole, pieces)

    def test_into_arrays_with_strides(self):
        table = np.zeros((500, 4), np.float32)
        self.tree.trace(self.origins, self.directions, out=mlrt.Hits(t=table[:, 1]), progress=True)
        self.assertTrue((table[:, 1] == self.tree.trace(self.origins, self.directions).t).all())
        self.assertFalse(table[:, ::2].any())

    def test_occluded_and_hits(self):
        whole = self.tree.occluded(self.origins, self.directions)
        self.assertTrue((self.tree.occluded(self.origins, self.directions, progress=True) == whole).all())
        self.finished_bar(500)
        lists = self.tree.hits(self.origins, self.directions, 3)
        assert_same(self, lists, self.tree.hits(self.origins, self.directions, 3, progress=True))
        self.finished_bar(500)

    def test_rows_stay_together(self):
        origins, directions = self.origins[:480].reshape(120, 4, 3), self.directions[:480].reshape(120, 4, 3)
        whole = self.tree.trace(origins, directions)
        self.assertTrue((self.tree.trace(origins, directions, progress=True).t == whole.t).all())
        self.assertEqual(self.finished_bar(480).steps, [256, 224])

    def test_rays_of_one_origin_stay_together(self):
        origins, directions = self.origins[:7, None], self.directions[:490].reshape(7, 70, 3)
        first = self.tree.trace(origins, directions)
        skip = np.stack((first.mesh, first.triangle), axis=-1)[:, :1]
        for arguments in ({}, {"t_min": np.linspace(0, 1, 7)[:, None]}, {"skip": skip, "t_max": first.t}, {"t_min": 0.5}):
            whole = self.tree.trace(origins, directions, **arguments)
            assert_same(self, whole, self.tree.trace(origins, directions, **arguments, progress=True))
            self.assertEqual(self.finished_bar(490).steps, [140, 140, 140, 70])
        lists = self.tree.hits(origins, directions, 3)
        assert_same(self, lists, self.tree.hits(origins, directions, 3, progress=True))
        self.finished_bar(490)

    def test_one_origin_or_direction(self):
        for arguments in ((self.origins[0], self.directions), (self.origins, self.directions[0])):
            whole = self.tree.trace(*arguments)
            assert_same(self, whole, self.tree.trace(*arguments, progress=True))
            self.finished_bar(500)

    def test_pictures(self):
        camera = mlrt.Camera.look_at((3, 20, 4), (0, 0, 0), 150, 130)
        for pool in (None, mlrt.Pool(3)):
            picture = self.tree.render(camera, progress=True, pool=pool)
            self.assertGreater(len(self.finished_bar(150 * 130).steps), 1)
            self.assertTrue((picture.t == self.tree.render(camera).t).all())
            lights = [(3, 9, 4), mlrt.DirectionalLight((1, 2, 3))]
            picture = self.tree.render(camera, lights=lights, progress=True, pool=pool)
            assert_same(self, picture, self.tree.render(camera, lights=lights))
            self.finished_bar(150 * 130)

    def test_errors_arrive(self):
        camera = mlrt.Camera.look_at((3, 20, 4), (0, 0, 0), 150, 130)
        FakeBar.error = KeyboardInterrupt()
        for pool in (None, mlrt.Pool(3)):
            for call in (
                lambda: self.tree.render(camera, progress=True, pool=pool),
                lambda: self.tree.trace(self.origins, self.directions, progress=True, pool=pool),
            ):
                with self.assertRaises(KeyboardInterrupt):
                    call()
                self.assertTrue(FakeBar.made.pop().closed)

    def test_nothing_to_do(self):
        self.tree.trace(np.zeros((0, 3)), np.zeros((0, 3)), progress=True)
        self.finished_bar(0)

    def test_without_tqdm(self):
        with mock.patch.dict(sys.modules, {"tqdm": None, "tqdm.auto": None}):
            with self.assertRaisesRegex(ImportError, "pip install tqdm"):
                self.tree.trace(self.origins, self.directions, progress=True)


class Imports(unittest.TestCase):
    def test_what_is_not_asked_for_is_not_imported(self):
        code = "import sys, mlrt, mlrt.trimesh; assert not {'tqdm', 'trimesh'} & set(sys.modules)"
        subprocess.run([sys.executable, "-c", code], check=True)


if __name__ == "__main__":
    unittest.main()
