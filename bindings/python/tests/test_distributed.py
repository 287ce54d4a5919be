# SPDX-License-Identifier: MIT
"""Rays and pictures over a cluster of Dask with real processes: the bits of one machine, also if a worker is killed meanwhile."""

import importlib
import os
import signal
import sys
import tempfile
import time
import unittest
from importlib.util import find_spec
from unittest import mock

import numpy as np
from support import integer_scene

import mlrt

HAVE_DASK = all(find_spec(name) for name in ("dask", "distributed"))


def process_id():
    return os.getpid()


class Missing(unittest.TestCase):
    def test_a_sentence_if_there_is_no_dask(self):
        with mock.patch.dict(sys.modules, {"dask": None}):
            sys.modules.pop("mlrt.distributed", None)
            with self.assertRaisesRegex(ImportError, r"^mlrt.distributed needs Dask: pip install mlrt\[distributed\]"):
                importlib.import_module("mlrt.distributed")


@unittest.skipUnless(HAVE_DASK, "dask and distributed are not installed (make deps-python): mlrt.distributed is not tested")
class OverTwoProcesses(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        import dask.array
        from dask.distributed import Client, LocalCluster

        from mlrt import distributed

        cls.distributed, cls.da = distributed, dask.array
        cls.cluster = LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50)
        cls.client = Client(cls.cluster)
        cls.addClassCleanup(cls.cluster.close)
        cls.addClassCleanup(cls.client.close)
        cls.vertices, cls.faces, cls.origins, cls.directions = integer_scene(2, triangle_count=400, ray_count=4000)
        half = len(cls.faces) // 2
        meshes = {5: (cls.vertices, cls.faces[:half]), 6: (cls.vertices, cls.faces[half:])}
        cls.tree = mlrt.Tree.from_meshes(meshes, masks=[1, 2])
        cls.scene = distributed.Scene(cls.tree)
        cls.addClassCleanup(cls.scene.close)
        cls.hits = cls.tree.trace(cls.origins, cls.directions)

    def same(self, found, expected):
        for name, one, other in zip(expected._fields, found, expected):
            self.assertEqual(one is None, other is None, name)
            if other is not None:
                self.assertEqual((one.dtype, one.shape, one.tobytes()), (other.dtype, other.shape, other.tobytes()), name)

    def test_batches(self):
        self.assertEqual(len(set(self.client.run(process_id).values()) - {os.getpid()}), 2)
        t_max, t_min = np.where(self.hits.hit, self.hits.t, 3).astype(np.float32), np.float32(0.25)
        skip = np.stack((self.hits.mesh, self.hits.triangle), axis=-1)
        mask = np.arange(len(self.origins)) % 3
        chunked = self.da.from_array(self.directions, chunks=(700, 3))
        wide = self.directions.reshape(1000, 4, 3)
        for rays, options in (
            ((self.origins, self.directions), {}),
            ((self.origins, self.directions), {"t_min": t_min, "t_max": t_max, "skip": skip, "mask": mask}),
            ((self.origins[0], self.directions), {"mask": 2}),
            ((self.origins, self.directions[0]), {"outputs": ("triangle", "t")}),
            ((self.origins[:1000, None], wide), {"t_max": 2}),
            ((self.origins[:1], self.directions[0]), {}),
            ((self.origins[0], self.directions[0]), {}),
            ((self.origins[:0], self.directions[:0]), {}),
        ):
            found = self.scene.trace(*rays, rays_per_piece=600, **options)
            self.assertTrue(all(array is None or isinstance(array, self.da.Array) for array in found))
            self.same(self.distributed.gather(found), self.tree.trace(*rays, **options))
            options.pop("outputs", None)
            anything = self.scene.occluded(*rays, rays_per_piece=600, **options).compute()
            self.assertEqual(anything.tobytes(), self.tree.occluded(*rays, **options).tobytes())
        found = self.scene.trace(self.da.from_array(self.origins, chunks=(900, 3)), chunked, t_max=t_max, start=False)
        self.assertEqual(found.t.chunks, ((900, 900, 900, 900, 400),))
        self.same(self.distributed.gather(found), self.tree.trace(self.origins, self.directions, t_max=t_max))
        self.assertEqual(int(found.hit.sum().compute()), int(self.tree.trace(self.origins, self.directions, t_max=t_max).hit.sum()))

    def test_pictures(self):
        camera = mlrt.Camera.look_at((0, 0, 30), (0, 0, 0), 300, 200)
        for crop, lights in ((None, None), ((30, 20, 200, 0), [(0, 40, 9), mlrt.DirectionalLight((1, 2, 3))])):
            camera.crop = crop
            found = self.scene.render(camera, lights=lights, mask=1, rays_per_piece=5000)
            self.assertEqual(found.t.chunks[1][0], 64)
            self.same(self.distributed.gather(found), self.tree.render(camera, lights=lights, mask=1))

    def test_a_killed_worker_loses_nothing(self):
        for repeats in (30, 120, 480):
            rays = [np.tile(array, (repeats, 1)) for array in (self.origins, self.directions)]
            found = self.scene.trace(*rays, rays_per_piece=1000)
            futures = self.client.futures_of(found.t)
            workers = self.client.run(process_id)
            victim = next(iter(workers))
            while len(self.client.has_what()[victim]) < 5:
                time.sleep(0.005)
            lost = {str(key) for key in self.client.has_what()[victim]} - {
                str(key) for name, keys in self.client.has_what().items() if name != victim for key in keys
            }
            unfinished = sum(not future.done() for future in futures)
            if not unfinished:  # this machine was too fast
                continue
            os.kill(workers[victim], signal.SIGKILL)
            result = self.distributed.gather(found)
            break
        self.assertGreater(unfinished, 0)
        self.assertGreater(len(lost), 0)
        self.assertNotIn(workers[victim], self.client.run(process_id).values())
        self.same(result, mlrt.Hits(*(None if array is None else np.tile(array, repeats) for array in self.hits)))

    def test_files(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.distributed.Scene(self.tree, folder=folder) as scene:
                self.assertEqual(os.listdir(folder), [os.path.basename(scene.path)])
                self.assertRegex(repr(scene), "2 workers")
                maps = self.client.run(_maps, (scene.path, scene._hash), scene.path)
                self.assertEqual(set(maps.values()), {True})  # mapped, not read
            self.assertEqual(os.listdir(folder), [])
            other = os.path.join(folder, "other.mlrt")
            self.tree.save(other)
            with self.distributed.Scene(other) as scene:
                self.same(self.distributed.gather(scene.trace(self.origins, self.directions)), self.hits)
            self.assertTrue(os.path.exists(other))
            scene = self.distributed.Scene(other)
            mlrt.Tree(self.vertices, self.faces[:3]).save(other)
            self.client.run(_forget)
            with self.assertRaisesRegex(mlrt.DataError, "on this worker, the file is of another tree"):
                self.distributed.gather(scene.trace(self.origins, self.directions))
            os.unlink(other)
            with self.assertRaisesRegex(FileNotFoundError, "this worker does not see the file"):
                self.distributed.gather(scene.trace(self.origins, self.directions))

    def test_refused(self):
        with self.assertRaisesRegex(ValueError, "rays: these counts do not fit each other: .*'t_max': \\(3,\\)"):
            self.scene.trace(self.origins, self.directions, t_max=[1, 2, 3])
        with self.assertRaisesRegex(ValueError, "outputs: 'x' is none of"):
            self.scene.trace(self.origins, self.directions, outputs="x")
        with self.assertRaisesRegex(ValueError, "outputs: at least one"):
            self.scene.trace(self.origins, self.directions, outputs=())
        with self.assertRaisesRegex(ValueError, "rays_per_piece"):
            self.scene.trace(self.origins, self.directions, rays_per_piece=0)
        with self.assertRaisesRegex(ValueError, "origins: the shape"):
            self.scene.trace(self.origins[:, :2], self.directions)


def _forget():
    from mlrt import distributed

    distributed._tree.cache_clear()


def _maps(source, path):
    """Does this process have the file mapped, once the tree is used?"""
    from mlrt import distributed

    distributed._tree(*source)
    with open("/proc/self/maps") as file:
        return path in file.read()


if __name__ == "__main__":
    unittest.main()
