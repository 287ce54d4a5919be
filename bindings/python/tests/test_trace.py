# SPDX-License-Identifier: MIT
"""Answers: against integers, from every method and instruction set, all hits, inside and outside, pictures."""

import unittest

import numpy as np
from support import assert_same, both_trees, box, distances, integer_scene, isas

import mlrt
from mlrt._abi import library


class AgainstIntegers(unittest.TestCase):
    def test_closest_hit(self):
        for seed in range(5):
            vertices, faces, origins, directions = integer_scene(seed)
            t, u, v, sign = distances(vertices, faces, origins, directions)
            hits = mlrt.Tree(vertices, faces).trace(origins, directions)
            rays, first = np.arange(len(origins)), t.argmin(axis=1)
            hit = np.isfinite(t[rays, first])
            with self.subTest(seed=seed):
                self.assertGreater(hit.sum(), 100)
                self.assertTrue((hits.triangle == np.where(hit, first, mlrt.NONE)).all())
                self.assertTrue((hits.mesh == np.where(hit, 0, mlrt.NONE)).all())
                for got, expected in ((hits.t, t), (hits.u, u), (hits.v, v), (hits.facing, sign)):
                    self.assertTrue((got == expected[rays, first].astype(got.dtype)).all())
                self.assertTrue((hits.hit == hit).all())

    def test_any_hit(self):
        vertices, faces, origins, directions = integer_scene(6)
        expected = np.isfinite(distances(vertices, faces, origins, directions)[0]).any(axis=1)
        self.assertTrue((mlrt.Tree(vertices, faces).occluded(origins, directions) == expected).all())

    def test_all_hits(self):
        vertices, faces, origins, directions = integer_scene(7)
        t = distances(vertices, faces, origins, directions)[0]
        order = np.argsort(t, axis=1, kind="stable")
        lists = mlrt.Tree(vertices, faces).hits(origins, directions, 10)
        self.assertTrue((lists.total == np.isfinite(t).sum(axis=1)).all())
        self.assertTrue((lists.t == np.take_along_axis(t, order, axis=1)[:, :10].astype(np.float32)).all())
        listed = np.arange(10) < lists.total[:, None]
        self.assertTrue((lists.triangle == np.where(listed, order[:, :10], mlrt.NONE)).all())

    def test_interval_and_skip(self):
        vertices, faces, origins, directions = integer_scene(8)
        tree = mlrt.Tree(vertices, faces)
        t = distances(vertices, faces, origins, directions)[0]
        first = tree.trace(origins, directions)
        skip = np.column_stack((first.mesh, first.triangle))
        behind = tree.trace(origins, directions, t_min=1, t_max=3, skip=skip)
        t[first.hit, first.triangle[first.hit]] = np.inf
        t[(t <= 1) | (t > 3)] = np.inf
        expected = np.where(np.isfinite(t).any(axis=1), t.argmin(axis=1), mlrt.NONE)
        self.assertTrue((behind.triangle == expected).all())


class SameAnswers(unittest.TestCase):
    def test_methods_and_instruction_sets(self):
        vertices, faces, origins, directions = integer_scene(1)
        boxes, kdtree = mlrt.Tree(vertices, faces), mlrt.Tree.kdtree(vertices, faces)
        expected = boxes.trace(origins, directions)
        occluded = boxes.occluded(origins, directions)
        for isa in isas():
            for method, tree in both_trees(boxes, kdtree):
                with self.subTest(isa=isa, method=method, structure=tree.info.structure):
                    assert_same(self, expected, tree.trace(origins, directions, method=method, isa=isa))
                    got = tree.occluded(origins, directions, method=method, isa=isa)
                    self.assertTrue((got == occluded).all())

    def test_row_length_and_pool(self):
        vertices, faces, origins, directions = integer_scene(2)
        tree = mlrt.Tree(vertices, faces)
        expected = tree.trace(origins, directions)
        with mlrt.Pool(3) as pool:
            assert_same(self, expected, tree.trace(origins, directions, row_length=20, pool=pool))
            lists = tree.hits(origins, directions, 4)
            assert_same(self, lists, tree.hits(origins, directions, 4, pool=pool))

    def test_presets(self):
        vertices, faces, origins, directions = integer_scene(4)
        expected = mlrt.Tree(vertices, faces).trace(origins, directions)
        for preset in ("default", "fast", "best"):
            with self.subTest(preset=preset):
                tree = mlrt.Tree(vertices, faces, preset=preset)
                self.assertEqual(tree.info.structure, "bvh")
                assert_same(self, expected, tree.trace(origins, directions))

    def test_threads_build_the_same_tree(self):
        vertices, faces, _, _ = integer_scene(5, triangle_count=2000)
        alone = mlrt.Tree(vertices, faces).info
        with mlrt.Pool(3) as pool:
            self.assertEqual(mlrt.Tree(vertices, faces, pool=pool).info.tree_hash, alone.tree_hash)

    def test_a_method_of_the_other_structure_is_unsupported(self):
        for make, wrong, right in ((mlrt.Tree, "multilevel", "tile"), (mlrt.Tree.kdtree, "tile", "multilevel")):
            tree = make(*box())
            tree.trace([0, 0, 0], [0, 0, 1], method=right)
            with self.assertRaises(mlrt.UnsupportedError):
                tree.trace([0, 0, 0], [0, 0, 1], method=wrong)

    def test_kdtrees(self):
        vertices, faces, origins, directions = integer_scene(3)
        rules = ("empty_space", "coplanar", "minimum_cell", "clipped_splits", "retraction")
        expected = mlrt.Tree(vertices, faces).trace(origins, directions)
        pool = mlrt.Pool(2)
        for options in ({}, {"preset": "tuned"}, {"rules_off": rules}, {"max_depth": 3}, {"max_references": 100}, {"pool": pool}):
            for tree in (
                mlrt.Tree.kdtree(vertices, faces, **options),
                mlrt.Tree.kdtree_from_meshes([(vertices, faces)], **options),
            ):
                self.assertEqual(tree.info.structure, "kdtree")
                assert_same(self, expected, tree.trace(origins, directions))

    def test_a_kdtree_is_traced_by_beams_unless_told_otherwise(self):
        camera = mlrt.Camera.look_at((3, 2, 4), (0, 0, 0), 64, 64)
        for make, has_beams in ((mlrt.Tree, False), (mlrt.Tree.kdtree, True)):
            counters = mlrt.Counters()
            make(*box()).render(camera, counters=counters)
            self.assertEqual(counters.beam_count > 0, has_beams)

    def test_errors_say_why(self):
        camera = mlrt.Camera.look_at((0, 0, 5), (0, 0, 0), 8, 8)
        camera.crop = (4, 4, 8, 8)
        with self.assertRaises(mlrt.CameraError) as raised:
            mlrt.Tree(*box()).render(camera)
        self.assertTrue(str(raised.exception).endswith(library.mlrt_last_message().decode()))
        self.assertEqual(raised.exception.status, 6)

    def test_options_of_the_other_structure_are_refused_by_name(self):
        vertices, faces = box()
        for name, value in {"max_depth": 3, "max_references": 100, "rules_off": ()}.items():
            with self.assertRaisesRegex(TypeError, f"'{name}'"):
                mlrt.Tree(vertices, faces, **{name: value})
            with self.assertRaisesRegex(TypeError, f"'{name}'"):
                mlrt.estimate_tree(12, **{name: value})
        for make, wrong in ((mlrt.Tree, "paper"), (mlrt.Tree, "tuned"), (mlrt.Tree.kdtree, "fast")):
            with self.assertRaisesRegex(ValueError, wrong):
                make(vertices, faces, preset=wrong)
        with self.assertRaisesRegex(mlrt.ArgumentError, "max_depth"):
            mlrt.Tree.kdtree(vertices, faces, max_depth=61)


class InsideAndOutside(unittest.TestCase):
    def test_box(self):
        tree = mlrt.Tree(*box())
        axis = np.array([-1.5, -0.5, 0, 0.25, 0.5, 1.5], np.float32)
        points = np.stack(np.meshgrid(axis, axis, axis), axis=-1)
        inside = (np.abs(points) < 1).all(axis=-1)
        for direction in ((0, 0, 1), (1, 1, 1), (1, 0, -1), (0.3, 0.5, -0.7)):
            self.assertTrue((tree.contains(points, direction) == inside).all(), direction)

    def test_a_diagonal_hits_two_triangles_and_crosses_once(self):
        lists = mlrt.Tree(*box()).hits([0, 0, 0], [0, 0, 1], 4)
        self.assertEqual((int(lists.total), int(lists.crossing_total)), (2, 1))
        self.assertEqual(lists.crossing.sum(), 1)

    def test_totals_only(self):
        lists = mlrt.Tree(*box()).hits([[0.1, 0.2, 5], [9, 9, 9]], [0, 0, -1], 0)
        self.assertIsNone(lists.t)
        self.assertEqual(lists.total.tolist(), [2, 0])


class Pictures(unittest.TestCase):
    cameras = (
        mlrt.Camera.look_at((3, 2, 4), (0, 0, 0), 37, 21),
        mlrt.Camera.orthographic((3, 2, 4), (0, 0, 0), 20, 30, extent=3, up=(0, 0, 1)),
    )

    def test_render_equals_trace_of_the_rays(self):
        tree = mlrt.Tree(*box())
        for camera in self.cameras:
            picture = tree.render(camera)
            self.assertEqual(picture.t.shape, (camera.height, camera.width))
            self.assertTrue(picture.hit.any() and not picture.hit.all())
            assert_same(self, picture, tree.trace(*camera.rays()))
            with mlrt.Pool(2) as pool:
                assert_same(self, picture, tree.render(camera, pool=pool, method="ray"))

    def test_look_at(self):
        camera = mlrt.Camera.look_at((0, 0, 5), (0, 0, 0), 101, 101, fov=90)
        origins, directions = camera.rays()
        self.assertTrue((origins == (0, 0, 5)).all())
        self.assertTrue(np.allclose(directions[50, 50], (0, 0, -1), atol=1e-6))
        self.assertGreater(directions[50, 100, 0], 0)  # right
        self.assertGreater(directions[0, 50, 1], 0)  # up comes first
        self.assertTrue(np.allclose(directions[0, 50, 1], 100 / 101, atol=1e-6))

    def test_crop_is_a_part_of_the_picture(self):
        tree, camera = mlrt.Tree(*box()), mlrt.Camera.look_at((3, 2, 4), (0, 0, 0), 40, 30)
        whole = tree.render(camera)
        camera.crop = (5, 6, 17, 13)
        part = tree.render(camera)
        self.assertEqual(part.t.tobytes(), whole.t[6:19, 5:22].tobytes())

    def test_a_camera_that_others_change_meanwhile(self):
        class Changing(mlrt.Camera):
            looks = 0

            @property
            def crop(self):
                self.looks += 1
                return None if self.looks % 2 else (0, 0, 2, 2)

            @crop.setter
            def crop(self, value):
                pass

        camera = Changing(16, 12, (-8, -6, 9), (1, 0, 0), (0, 1, 0))
        for call in (lambda: mlrt.Tree(*box()).render(camera).t, lambda: camera.rays()[0]):
            camera.looks = 0
            self.assertEqual(call().shape[:2], (12, 16))

    def test_crops(self):
        camera = mlrt.Camera(16, 12, (-8, -6, 9), (1, 0, 0), (0, 1, 0), crop=np.array([3, 2, 5, 0]))
        self.assertEqual(mlrt.Tree(*box()).render(camera).t.shape, (10, 5))
        for camera.crop in ((), (1, 2, 3), (1, 2, 3, 4, 5)):
            with self.assertRaisesRegex(mlrt.CameraError, "crop: four numbers"):
                camera.rays()

    def test_interval(self):
        tree, camera = mlrt.Tree(*box()), mlrt.Camera.look_at((0, 0, 5), (0, 0, 0), 8, 8, fov=5)
        self.assertTrue(tree.render(camera).hit.all())
        for camera.t_max in (0.0, 3.0):
            self.assertFalse(tree.render(camera).hit.any())

    def test_impossible_cameras(self):
        tree = mlrt.Tree(*box())
        for change in ({"crop": (35, 0, 10, 10)}, {"width": 0}, {"width": -1}, {"eye": (np.nan, 0, 0)}):
            camera = mlrt.Camera.look_at((3, 2, 4), (0, 0, 0), 40, 30)
            vars(camera).update(change)
            with self.assertRaises(mlrt.CameraError, msg=str(change)):
                tree.render(camera)
        with self.assertRaises(ValueError):
            mlrt.Camera.look_at((0, 0, 1), (0, 0, 0), 4, 4, up=(0, 0, 1))


if __name__ == "__main__":
    unittest.main()
