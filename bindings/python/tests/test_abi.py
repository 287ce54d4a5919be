# SPDX-License-Identifier: MIT
"""The structs here are those of the library: it knows their sizes and no others, and finds fields where they are."""

import ctypes
import unittest

import numpy as np
from support import box

import mlrt
from mlrt import _abi
from mlrt._abi import library

STRUCT_SIZE = 2


class Sizes(unittest.TestCase):
    """Structs are as large as the library's. Calls with their struct_size succeed, with sizes of no version they fail."""

    def setUp(self):
        self.tree = mlrt.Tree(*box())
        self.alive = np.zeros(16, np.float32)
        data = self.alive.ctypes.data
        self.rays = _abi.Rays(
            count=1, origins=_abi.ConstArray(data), directions=_abi.ConstArray(data)
        )
        self.hits = _abi.Hits(t=_abi.Array(data))
        self.camera = mlrt.Camera.look_at((0, 0, 5), (0, 0, 0), 2, 2).to_struct()

    def check(self, struct, call):
        right = ctypes.sizeof(struct)
        self.assertEqual(struct.struct_size, right)
        self.assertEqual(call(), 0)
        self.assertEqual(right, _abi.struct_sizes(library)[type(struct)])
        for wrong in (0, 4, right - 2, right + 1):
            struct.struct_size = wrong
            self.assertEqual(call(), STRUCT_SIZE, wrong)

    def trace(self, options=None):
        rays, hits = ctypes.byref(self.rays), ctypes.byref(self.hits)
        return library.mlrt_trace_packet(self.tree._handle, rays, options, hits)

    def test_all(self):
        for structure, size in _abi.struct_sizes(library).items():
            self.assertEqual(ctypes.sizeof(structure), size, structure)

    def test_mesh(self):
        mesh = _abi.Mesh()
        handle = _abi.TreeHandle()
        self.check(mesh, lambda: library.mlrt_build_tree(ctypes.byref(mesh), 1, None, ctypes.byref(handle)))

    def test_tree_options(self):
        options, handle = _abi.TreeOptions(), _abi.TreeHandle()
        self.check(options, lambda: library.mlrt_build_tree(None, 0, ctypes.byref(options), ctypes.byref(handle)))

    def test_kdtree_options(self):
        options, handle = _abi.KdTreeOptions(), _abi.TreeHandle()
        self.check(options, lambda: library.mlrt_build_kdtree(None, 0, ctypes.byref(options), ctypes.byref(handle)))

    def test_host(self):
        host, handle = _abi.Host(), _abi.TreeHandle()
        options = _abi.TreeOptions(host=ctypes.addressof(host))
        self.check(host, lambda: library.mlrt_build_tree(None, 0, ctypes.byref(options), ctypes.byref(handle)))

    def test_memory_estimate(self):
        for estimator in (library.mlrt_estimate_tree, library.mlrt_estimate_kdtree):
            estimate = _abi.MemoryEstimate()
            self.check(estimate, lambda: estimator(None, 0, None, ctypes.byref(estimate)))

    def test_load_options(self):
        options, handle, content = _abi.LoadOptions(), _abi.TreeHandle(), self.tree.to_bytes()
        pointers = ctypes.byref(options), ctypes.byref(handle)
        self.check(options, lambda: library.mlrt_load_tree(content, len(content), *pointers))

    def test_tree_info(self):
        info = _abi.TreeInfo()
        self.check(info, lambda: library.mlrt_get_tree_info(self.tree._handle, ctypes.byref(info)))

    def test_rays(self):
        self.check(self.rays, self.trace)

    def test_hits(self):
        self.check(self.hits, self.trace)

    def test_trace_options(self):
        options = _abi.TraceOptions()
        self.check(options, lambda: self.trace(ctypes.byref(options)))

    def test_counters(self):
        counters = mlrt.Counters()
        options = _abi.TraceOptions(counters=ctypes.pointer(counters))
        self.check(counters, lambda: self.trace(ctypes.byref(options)))

    def test_hit_lists(self):
        lists = _abi.HitLists(total=_abi.Array(self.alive.ctypes.data))
        rays = ctypes.byref(self.rays)
        self.check(lists, lambda: library.mlrt_trace_all_hits(self.tree._handle, rays, None, ctypes.byref(lists)))

    def test_light(self):
        light, occluded = _abi.Light(position=_abi.Float3(1, 2, 3)), np.zeros(4, np.uint8)
        hits = _abi.Hits(occluded=_abi.Array(occluded.ctypes.data))
        options = _abi.TraceOptions(lights=ctypes.pointer(light), light_count=1)
        pointers = [ctypes.byref(struct) for struct in (self.camera, options, hits)]
        self.check(light, lambda: library.mlrt_render_tiles(self.tree._handle, *pointers, None, None))

    def test_camera(self):
        self.check(self.camera, lambda: library.mlrt_camera_rays(ctypes.byref(self.camera), None, None))


class Layouts(unittest.TestCase):
    def test_packed_structs_equal_ctypes_structs(self):
        for pack, structure in (
            (_abi.pack_rays, _abi.Rays),
            (_abi.pack_hits, _abi.Hits),
            (_abi.pack_hit_lists, _abi.HitLists),
        ):
            letters = pack.func.__self__.format.lstrip("@")
            words = range(1, len(letters))  # but for the struct_size
            packed = structure.from_buffer_copy(pack(*words))
            self.assertEqual(packed.struct_size, ctypes.sizeof(structure))
            values = []
            for name, kind in structure._fields_[1:]:
                value = getattr(packed, name)
                values += [getattr(value, part) for part, _ in kind._fields_] if hasattr(kind, "_fields_") else [value]
            self.assertEqual(values, list(words), structure)

    def test_plain_hits_are_those_without_strides(self):
        addresses = range(1, 8)
        with_strides = [number for address in addresses for number in (address, 0, 0)]
        self.assertEqual(_abi.pack_plain_hits(9, *addresses), _abi.pack_hits(9, *with_strides))

    def test_every_array_has_an_element_size(self):
        for structure in (_abi.Rays, _abi.Hits, _abi.HitLists):
            for name, kind in structure._fields_:
                if kind in (_abi.Array, _abi.ConstArray):
                    self.assertGreater(_abi.ELEMENT_SIZES[name], 0)

    def test_tiles(self):
        sizes = []

        @_abi.TileCallback
        def callback(user, tile):
            tile = tile.contents
            sizes.append((tile.struct_size, tile.width * tile.height, bool(tile.triangle), bool(tile.t)))
            return 0

        camera = mlrt.Camera.look_at((0, 0, 5), (0, 0, 0), 8, 8).to_struct()
        options = _abi.TraceOptions(outputs=16)
        tree, pointers = mlrt.Tree(*box()), map(ctypes.byref, (camera, options))
        self.assertEqual(library.mlrt_render_tiles(tree._handle, *pointers, None, callback, None), 0)
        self.assertEqual(sizes, [(ctypes.sizeof(_abi.Tile), 64, True, False)])

    def test_tree_info_is_read_at_the_right_places(self):
        info = mlrt.Tree(*box(-1, 2)).info
        self.assertEqual((info.triangle_count, info.non_finite_count, info.zero_area_count), (12, 0, 0))
        self.assertEqual(info.bounds.tolist(), [[-1, -1, -1], [2, 2, 2]])
        self.assertGreater(info.sah_cost, 0)
        self.assertGreater(info.build_seconds, 0)
        self.assertLess(info.build_seconds, 60)
        self.assertGreaterEqual(info.peak_memory_size, info.memory_size)

    def test_version(self):
        self.assertEqual(mlrt.version()[:2], (0, 1))


if __name__ == "__main__":
    unittest.main()
