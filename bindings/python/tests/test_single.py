# SPDX-License-Identifier: MIT
"""One ray a call: the bits of calls with arrays, and what is refused."""

import threading
import unittest

import numpy as np
from support import assert_same, box, integer_scene

import mlrt
from mlrt import _single

NUMBERS = ("t", "u", "v", "mesh", "triangle", "facing")


class SameBits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        vertices, faces, cls.origins, cls.directions = integer_scene(5, triangle_count=200, ray_count=400)
        half = len(faces) // 2
        cls.tree = mlrt.Tree.from_meshes([(vertices, faces[:half]), (vertices, faces[half:])], ids=[3, 9], masks=[1, 2])
        cls.all = cls.tree.trace(cls.origins, cls.directions)

    def check(self, found, expected, ray):
        for name in NUMBERS:
            array = getattr(expected, name)
            self.assertEqual(array.dtype.type(getattr(found, name)).tobytes(), array[ray].tobytes(), (name, ray))

    def test_in_numbers(self):
        t_max = np.where(self.all.hit, self.all.t, 1).astype(np.float32) * np.float32(1.5)
        skip = np.stack((self.all.mesh, self.all.triangle), axis=-1)
        hit = 0
        for arguments in ({}, {"t_min": self.all.t}, {"t_max": t_max}, {"skip": skip}, {"t_max": t_max, "skip": skip}):
            arguments = {name: np.where(np.isfinite(array), array, 0) if name == "t_min" else array for name, array in arguments.items()}
            for mask in (0, 2):
                closest = self.tree.trace(self.origins, self.directions, mask=mask, **arguments)
                anything = self.tree.occluded(self.origins, self.directions, mask=mask, **arguments)
                for ray in range(len(self.origins)):
                    own = {name: tuple(map(int, array[ray])) if name == "skip" else float(array[ray]) for name, array in arguments.items()}
                    rays = self.origins[ray], self.directions[ray].tolist()
                    found = self.tree.trace_ray(*rays, mask=mask, **own)
                    self.check(found, closest, ray)
                    self.assertEqual((bool(found), self.tree.occluded_ray(*rays, mask=mask, **own)), (anything[ray],) * 2)
                    hit += bool(found)
        self.assertGreater(hit, 500)

    def test_in_arrays_with_limits(self):
        """With a method, `trace` goes the long way."""
        calls = 0
        for ray in range(0, len(self.origins), 2):
            shape = ((), (1,), (1, 1))[ray % 3]
            arrays = [array[ray].reshape(shape + (3,)) for array in (self.origins, self.directions)]
            end, skip = float(self.all.t[ray]), (self.all.mesh[ray], self.all.triangle[ray])
            numbers = (0, -1, end, end / 2, end * 1.0000001, float("inf"), float("nan"), 1e-46, 1e300, True, np.float32(end), np.float64(end), np.full(shape, end, np.float32))
            every = [{name: number} for name in ("t_min", "t_max") for number in numbers]
            every += [{"skip": np.array(skip, dtype).reshape(shape + (2,))} for dtype in (np.uint32, np.int64)]
            every += [{"skip": np.full(shape + (2,), -1), "t_max": end}, {"t_min": 0, "t_max": 2 * end, "mask": 2}, {"mask": -2}]
            for arguments in every:
                with np.errstate(over="ignore"):
                    long_way = self.tree.trace(*arrays, method="tile", **arguments), self.tree.occluded(*arrays, method="tile", **arguments)
                    short = self.tree.trace(*arrays, **arguments), self.tree.occluded(*arrays, **arguments)
                for one, other in zip(short[0][:6] + short[1:], long_way[0][:6] + long_way[1:]):
                    self.assertEqual((one.shape, one.dtype, one.tobytes()), (other.shape, other.dtype, other.tobytes()), arguments)
                calls += 1
        self.assertGreater(calls, 5000)

    def test_refused_in_arrays(self):
        """As by the long way."""
        ray = np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32)
        for arguments in ({"skip": np.array([[0, 1 << 32]])}, {"skip": np.array([[0.0, 1.0]])}, {"mask": 1 << 32}):
            for ask in (self.tree.trace, self.tree.occluded):
                with self.assertRaises((ValueError, TypeError)):
                    ask(*ray, **arguments)
                with self.assertRaises(ValueError):
                    ask(*ray, t_max=1.0, row_length=-1)

    def test_in_arrays(self):
        """With a method, `trace` goes the long way."""
        shapes = (3,), (1, 3), (1, 1, 3)
        for ray in range(len(self.origins)):
            arrays = [array[ray].reshape(shapes[ray % 3]) for array in (self.origins, self.directions)]
            for outputs in (None, "triangle", ("t", "facing"), iter(("u", "mesh"))):
                outputs = outputs if outputs is None or isinstance(outputs, str) else tuple(outputs)
                long_way = self.tree.trace(*arrays, method="tile", outputs=outputs)
                short = self.tree.trace(*arrays, outputs=outputs)
                for name, one, other in zip(short._fields, short, long_way):
                    self.assertEqual(one is None, other is None, name)
                    if one is not None:
                        self.assertEqual((one.shape, one.dtype, one.tobytes()), (other.shape, other.dtype, other.tobytes()), name)
                        one[...] = 0  # an array of its own
            short, long_way = self.tree.occluded(*arrays), self.tree.occluded(*arrays, method="tile")
            self.assertEqual((short.shape, short.dtype, short.tobytes()), (long_way.shape, long_way.dtype, long_way.tobytes()))

    def test_results_stay(self):
        first = self.tree.trace(self.origins[:1], self.directions[:1])
        kept = [None if array is None else array.copy() for array in first]
        for ray in range(1, 50):
            self.tree.trace(self.origins[ray : ray + 1], self.directions[ray : ray + 1])
            self.tree.trace_ray(self.origins[ray], self.directions[ray])
        assert_same(self, first, mlrt.Hits._make(kept))

    def test_threads_do_not_share_rays(self):
        wrong = []

        def trace(start):
            for _ in range(5):
                for ray in range(start, len(self.origins), 4):
                    if self.tree.trace_ray(self.origins[ray], self.directions[ray]).triangle != self.all.triangle[ray]:
                        wrong.append(ray)

        threads = [threading.Thread(target=trace, args=(start,)) for start in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])


class Limits(unittest.TestCase):
    def setUp(self):
        self.tree = mlrt.Tree(*box())

    def test_a_t_max_of_zero_is_not_no_limit(self):
        ray = (0, 0, 5), (0, 0, -1)
        for t_max in (0, 0.0, -0.0, 1e-46, 2.0**-150, -3):
            self.assertFalse(self.tree.trace_ray(*ray, t_max=t_max), t_max)
            self.assertFalse(self.tree.occluded_ray(*ray, t_max=t_max), t_max)
        for t_max in (None, 4, float("inf")):
            self.assertTrue(self.tree.trace_ray(*ray, t_max=t_max), t_max)
        camera = mlrt.Camera.look_at((0, 0, 5), (0, 0, 0), 8, 8)
        for t_max, hits in ((0, False), (1e-46, False), (None, True), (9, True)):
            camera.t_max = t_max
            self.assertEqual(self.tree.render(camera).hit.any(), hits, t_max)

    def test_a_nan_hits_nothing(self):
        for ray in (((0, 0, 5), (0, 0, float("nan"))), ((float("inf"), 0, 5), (0, 0, -1)), ((0, 0, 5), (0, 0, 0))):
            self.assertEqual(self.tree.trace_ray(*ray), (float("inf"), 0, 0, mlrt.NONE, mlrt.NONE, 0))
        self.assertFalse(self.tree.trace_ray((0, 0, 5), (0, 0, -1), t_max=float("nan")))

    def test_refused(self):
        for arguments in (
            ((0, 0), (0, 0, 1)),
            ((0, 0, 0, 0), (0, 0, 1)),
            ((0, 0, 0), None),
            ((0, 0, 1e300), (0, 0, 1)),
            (("0", 0, 0), (0, 0, 1)),
            ((0, 0, 0), (0, 0, 1), 0, None, 7),
            (np.zeros((2, 3)), (0, 0, 1)),
        ):
            with self.assertRaisesRegex(ValueError, "one ray"):
                self.tree.trace_ray(*arguments)
            with self.assertRaisesRegex(ValueError, "one ray"):
                self.tree.occluded_ray(*arguments)
        with self.assertRaisesRegex(ValueError, "mask"):
            self.tree.trace_ray((0, 0, 0), (0, 0, 1), mask=1 << 32)
        self.tree.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            self.tree.trace_ray((0, 0, 0), (0, 0, 1))

    def test_errors_keep_no_structs(self):
        ray = (0, 0, 5), (0, 0, -1)
        self.tree.trace_ray(*ray)
        count = len(_single._free)
        for _ in range(20):
            self.tree.trace_ray(*ray)
            with self.assertRaises(ValueError):
                self.tree.trace_ray((0, 0), (0, 0, 1))
        self.assertLessEqual(len(_single._free), max(count, 1))


if __name__ == "__main__":
    unittest.main()
