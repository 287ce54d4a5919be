# SPDX-License-Identifier: MIT
"""Trees saved, loaded, pickled and copied; hashes of geometry."""

import copy
import gc
import mmap
import os
import pickle
import subprocess
import sys
import tempfile
import unittest
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path
from unittest import mock

import numpy as np
from support import assert_same, box, integer_scene

import mlrt
from mlrt import _saved

MAPS = Path("/proc/self/maps")


class Saved(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder, self.path = Path(folder.name), Path(folder.name) / "scene.mlrt"
        vertices, faces, self.origins, self.directions = integer_scene(40, triangle_count=400)
        self.meshes = [(vertices, faces[:150]), (vertices, faces[150:])]
        self.tree = mlrt.Tree.from_meshes(self.meshes, ids=[7, 3], masks=[1, 6])

    def check_same(self, tree, expected=None):
        expected = expected or self.tree
        for options in ({}, {"mask": 1}, {"mask": 2}):
            pair = [one.trace(self.origins, self.directions, **options) for one in (expected, tree)]
            assert_same(self, *pair)
        self.assertEqual(tree.info.tree_hash, expected.info.tree_hash)
        self.assertEqual(tree.info.triangle_count, expected.info.triangle_count)

    def is_mapped(self):
        return str(self.path) in MAPS.read_text()

    @unittest.skipUnless(MAPS.exists(), "needs /proc")
    def test_a_file_is_mapped_as_long_as_the_tree_lives(self):
        self.tree.save(self.path)
        for end in ("close", "del"):
            tree = mlrt.Tree.load(self.path)
            self.assertTrue(self.is_mapped())
            self.check_same(tree)
            if end == "close":
                tree.close()
            del tree
            self.assertFalse(self.is_mapped(), end)
        with mlrt.Tree.load(str(self.path), in_place=False) as tree:
            self.assertFalse(self.is_mapped())
            self.check_same(tree)

    def test_memory(self):
        self.tree.save(os.fsencode(self.path))
        size = self.path.stat().st_size
        self.assertLess(mlrt.Tree.load(self.path).info.memory_size, size / 10)
        self.assertGreater(mlrt.Tree.load(self.path, in_place=False).info.memory_size, size / 2)
        self.assertGreater(mlrt.Tree.load(self.path, memory_limit=size // 10).info.triangle_count, 0)
        with self.assertRaises(mlrt.OutOfMemoryError):
            mlrt.Tree.load(self.path, in_place=False, memory_limit=size // 10)

    def test_all_kinds_of_trees(self):
        for make, presets, structure in (
            (mlrt.Tree.from_meshes, ("default", "fast", "best"), "bvh"),
            (mlrt.Tree.kdtree_from_meshes, ("paper", "tuned"), "kdtree"),
        ):
            for preset in presets:
                tree = make(self.meshes, preset=preset)
                tree.save(self.path)
                loaded = mlrt.Tree.load(self.path)
                self.assertEqual(loaded.info.structure, structure)
                self.check_same(loaded, tree)
        empty = mlrt.Tree.from_meshes([])
        self.assertFalse(mlrt.Tree.load(empty.to_bytes()).occluded([0, 0, 0], [0, 0, 1]))

    def test_a_file_is_replaced_under_a_tree_that_lies_in_it(self):
        self.tree.save(self.path)
        tree = mlrt.Tree.load(self.path)
        other = mlrt.Tree(*box())
        other.save(self.path)
        self.check_same(tree)
        tree.save(self.path)
        self.path.unlink()
        self.check_same(tree)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_failed_save_leaves_the_old_file(self):
        self.tree.save(self.path)
        with mock.patch.object(_saved.os, "replace", side_effect=OSError("full")):
            with self.assertRaises(OSError):
                mlrt.Tree(*box()).save(self.path)
        self.assertEqual(list(self.folder.iterdir()), [self.path])
        self.check_same(mlrt.Tree.load(self.path))
        with self.assertRaises(FileNotFoundError):
            self.tree.save(self.folder / "no" / "folder")

    def test_links_and_devices_stay(self):
        link = self.folder / "link"
        link.symlink_to(self.path)
        self.tree.save(link)
        self.assertTrue(link.is_symlink() and self.path.is_file())
        pipe = self.folder / "pipe"
        os.mkfifo(pipe)
        loader = "import sys, mlrt; print(mlrt.Tree.load(sys.argv[1]).info.triangle_count)"
        with subprocess.Popen([sys.executable, "-c", loader, str(pipe)], stdout=subprocess.PIPE) as process:
            self.tree.save(pipe)
            self.assertEqual(process.communicate()[0].strip(), b"400")
        self.assertTrue(pipe.is_fifo())

    def test_any_buffer(self):
        content = self.tree.to_bytes()
        self.assertIs(type(content), bytes)
        self.tree.save(self.path)
        self.assertEqual(self.path.read_bytes(), content)
        words = np.frombuffer(content, np.uint32)
        with open(self.path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
            for buffer in (content, bytearray(content), memoryview(content), words, words.reshape(2, -1), mapped):
                for in_place in (True, False):
                    tree = mlrt.Tree.load(buffer, in_place=in_place)
                    self.check_same(tree)
                    tree.close()
        for wrong in (5, None, memoryview(content)[::2]):
            with self.assertRaises((TypeError, ValueError, BufferError)):
                mlrt.Tree.load(wrong)

    def test_what_is_used_in_place(self):
        content = self.tree.to_bytes()
        memory = np.zeros(len(content) + 128, np.uint8)
        start = -memory.ctypes.data % 64
        aligned, unaligned = memory[start : start + len(content)], memory[start + 4 : start + 4 + len(content)]
        for array, writable, in_place in ((aligned, False, True), (aligned, True, False), (unaligned, False, False)):
            array[:] = np.frombuffer(content, np.uint8)
            source = memoryview(array) if writable else memoryview(array).toreadonly()
            tree = mlrt.Tree.load(source)
            self.assertEqual(tree.info.memory_size < len(content) / 10, in_place)
            if not in_place:
                array[:] = 0  # must not matter
            self.check_same(tree)

    def test_shared_memory(self):
        content = self.tree.to_bytes()
        shared = SharedMemory(create=True, size=len(content))
        self.addCleanup(shared.unlink)
        shared.buf[: len(content)] = content
        with mlrt.Tree.load(shared.buf[: len(content)].toreadonly()) as tree:
            self.assertLess(tree.info.memory_size, len(content) / 10)
            self.check_same(tree)
        shared.close()

    def test_a_buffer_is_kept(self):
        mapped = mmap.mmap(-1, len(self.tree.to_bytes()))
        mapped[:] = self.tree.to_bytes()
        tree = mlrt.Tree.load(memoryview(mapped).toreadonly())
        with self.assertRaises(BufferError):
            mapped.close()
        self.check_same(tree)
        tree.close()
        mapped.close()

    def test_damage(self):
        content = bytearray(self.tree.to_bytes())
        content[len(content) // 2] ^= 1
        for wrong, text in ((content, "damaged"), (b"", "not a saved tree"), (bytes(1000), "not a saved tree")):
            self.path.write_bytes(wrong)
            for source in (wrong, self.path):
                with self.assertRaisesRegex(mlrt.DataError, text) as caught:
                    mlrt.Tree.load(source)
                self.assertEqual(caught.exception.status, 10)
        with self.assertRaises(FileNotFoundError):
            mlrt.Tree.load(self.folder / "none")

    def test_geometry_hash(self):
        self.tree.save(self.path)
        number = mlrt.geometry_hash_of_meshes(self.meshes, ids=[7, 3], masks=[1, 6])
        self.check_same(mlrt.Tree.load(self.path, geometry_hash=number))
        others = [
            mlrt.geometry_hash_of_meshes(self.meshes),
            mlrt.geometry_hash_of_meshes(self.meshes, ids=[7, 3]),
            mlrt.geometry_hash_of_meshes(self.meshes, ids=[7, 4], masks=[1, 6]),
            mlrt.geometry_hash_of_meshes(self.meshes[:1], ids=[7], masks=[1]),
        ]
        self.assertEqual(len({number, *others}), 5)
        for other in others:
            with self.assertRaisesRegex(mlrt.DataError, "other triangles"):
                mlrt.Tree.load(self.path, geometry_hash=other)
        for wrong in (-1, 1 << 64):
            with self.assertRaises(ValueError):
                mlrt.Tree.load(self.path, geometry_hash=wrong)

    def test_geometry_hash_of_one_mesh(self):
        vertices, faces = box()
        number = mlrt.geometry_hash(vertices, faces)
        self.assertEqual(number, mlrt.geometry_hash(vertices.astype(np.float64), faces.astype(np.uint16)))
        self.assertEqual(number, mlrt.geometry_hash(vertices[faces].reshape(-1, 3)))
        self.assertEqual(number, mlrt.geometry_hash_of_meshes([(vertices, faces)]))
        self.assertNotEqual(number, mlrt.geometry_hash(vertices, faces, mask=1))
        self.assertNotEqual(number, mlrt.geometry_hash(vertices, faces[::-1]))
        mlrt.Tree.load(mlrt.Tree(vertices, faces, mask=5).to_bytes(), geometry_hash=mlrt.geometry_hash(vertices, faces, mask=5))
        with self.assertRaises(mlrt.IndexRangeError):
            mlrt.geometry_hash(vertices, faces + 8)

    def test_closed(self):
        self.tree.close()
        for call in (mlrt.Tree.to_bytes, lambda tree: tree.save(self.path), pickle.dumps, copy.copy, copy.deepcopy):
            with self.assertRaisesRegex(ValueError, "closed"):
                call(self.tree)
        self.assertFalse(self.path.exists())


class Named(mlrt.Tree):
    name = ""


class Pickles(unittest.TestCase):
    def setUp(self):
        vertices, faces, *self.rays = integer_scene(41)
        self.tree = mlrt.Tree(vertices, faces)
        self.expected = self.tree.trace(*self.rays).triangle.tobytes()

    def check(self, tree):
        self.assertEqual(tree.trace(*self.rays).triangle.tobytes(), self.expected)

    def test_all_protocols(self):
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            self.check(pickle.loads(pickle.dumps(self.tree, protocol)))

    def test_buffers_beside_the_pickle(self):
        buffers = []
        pickled = pickle.dumps(self.tree, 5, buffer_callback=buffers.append)
        self.assertLess(len(pickled), 1000)
        self.assertEqual(len(buffers), 1)
        self.check(pickle.loads(pickled, buffers=buffers))
        self.check(pickle.loads(pickled, buffers=[bytes(buffers[0])]))

    def test_subclasses(self):
        tree = Named.from_meshes([])
        tree.name = "nothing"
        for other in (pickle.loads(pickle.dumps(tree)), copy.copy(tree), copy.deepcopy(tree)):
            self.assertEqual((type(other), other.name), (Named, "nothing"))

    def test_copies(self):
        for make in (copy.copy, copy.deepcopy):
            tree = mlrt.Tree.load(self.tree.to_bytes())
            other = make(tree)
            self.assertIsNot(other, tree)
            tree.close()
            del tree
            gc.collect()
            self.check(other)


if __name__ == "__main__":
    unittest.main()
