# SPDX-License-Identifier: MIT
"""Arrays in and out: strides, dtypes, shapes, what is copied and what is not, and what is refused."""

import unittest

import numpy as np
from support import assert_same, box, integer_scene

import mlrt
from mlrt import _abi
from mlrt._arrays import elements
from mlrt._rays import Rays


class Inputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.vertices, cls.faces, cls.origins, cls.directions = integer_scene(4)
        cls.tree = mlrt.Tree(cls.vertices, cls.faces)
        cls.expected = cls.tree.trace(cls.origins, cls.directions).triangle

    def check(self, origins, directions, expected=None):
        got = self.tree.trace(origins, directions, outputs="triangle").triangle
        self.assertTrue((got == (self.expected if expected is None else expected)).all())

    def test_dtypes(self):
        for dtype in (np.float64, np.int32, np.int8, ">f4", np.float16):
            self.check(self.origins.astype(dtype), self.directions)
        self.check(self.origins.tolist(), self.directions.tolist())

    def test_strides(self):
        both = np.concatenate((self.origins, self.directions), axis=1)
        self.check(both[:, :3], both[:, 3:])
        self.check(self.origins[::-1], self.directions[::-1], self.expected[::-1])
        self.check(self.origins[::3], self.directions[::3], self.expected[::3])
        self.check(np.asfortranarray(self.origins), np.asfortranarray(self.directions))
        self.check(self.origins[:, ::-1][:, ::-1], self.directions)

    def test_unaligned_and_read_only(self):
        memory = bytearray(self.origins.nbytes + 1)
        memory[1:] = self.origins.tobytes()
        self.check(np.frombuffer(memory, np.float32, offset=1).reshape(-1, 3), self.directions)
        self.check(np.frombuffer(self.origins.tobytes(), np.float32).reshape(-1, 3), self.directions)

    def test_broadcast(self):
        tree = mlrt.Tree(*box())
        directions = np.eye(3, dtype=np.float32)
        self.assertEqual(tree.trace([0, 0, 0], directions).t.tolist(), [1, 1, 1])
        grid = tree.trace(np.zeros((5, 1, 3)), directions, t_min=np.zeros((4, 1, 1)))
        self.assertEqual(grid.t.shape, (4, 5, 3))
        one = tree.trace([0, 0, 0], [0, 0, 2])
        self.assertEqual((one.t.shape, float(one.t)), ((), 0.5))
        with self.assertRaises(ValueError):
            tree.trace(np.zeros((2, 3)), np.zeros((4, 3)))

    def test_no_rays_and_no_triangles(self):
        for shape in ((0, 3), (4, 0, 3)):
            hits = self.tree.trace(np.zeros(shape), np.zeros(shape))
            self.assertEqual(hits.t.shape, shape[:-1])
            self.assertEqual(self.tree.occluded(np.zeros(shape), np.zeros(shape)).shape, shape[:-1])
            self.assertEqual(self.tree.hits(np.zeros(shape), np.zeros(shape), 2).t.shape, shape[:-1] + (2,))
        for empty in (mlrt.Tree(np.zeros((0, 3)), np.zeros((0, 3), int)), mlrt.Tree.from_meshes([])):
            self.assertFalse(empty.occluded([0, 0, 0], [0, 0, 1]))

    def test_what_is_passed_through(self):
        wide = np.zeros((8, 7), np.float32)
        for array in (wide[:, :3], wide[::2, 2:5], wide.reshape(4, 14)[:, 3:6]):
            kept, address, stride = elements(array, 3)
            self.assertEqual(address, array.ctypes.data)
            self.assertEqual(stride, array.strides[0])
        for array in (wide[::-1, :3], wide[:, :6:2], np.broadcast_to(wide[0, :3], (8, 3))):
            kept, address, stride = elements(array, 3)
            self.assertFalse(np.shares_memory(kept, array))


class SharedElements(unittest.TestCase):
    """What is broadcast is named to the library, not copied, and the answers are those of copies."""

    def setUp(self):
        vertices, faces, origins, directions = integer_scene(9, ray_count=420)
        self.tree = mlrt.Tree(vertices, faces)
        self.directions = directions.reshape(12, 7, 5, 3)
        self.origins = origins[:12].reshape(12, 1, 1, 3)
        first = self.tree.trace(origins[:12], directions[::35])
        self.skip = np.stack((first.mesh, first.triangle), axis=-1).reshape(12, 1, 1, 2)
        self.t_min = np.linspace(0, 1, 12, dtype=np.float32).reshape(12, 1, 1)
        self.t_max = np.linspace(1, 4, 420, dtype=np.float32).reshape(12, 7, 5)

    def layout(self, *arguments, **options):
        """The mlrt_rays of a call, which must answer as if all arrays were written out."""
        rays = Rays(*arguments, **options)
        shape = rays.shape
        full = [np.ascontiguousarray(np.broadcast_to(array, shape + (3,))) for array in arguments]
        widths = {"t_min": (), "t_max": (), "skip": (2,)}
        written = {name: np.ascontiguousarray(np.broadcast_to(options[name], shape + widths[name])) for name in options}
        assert_same(self, self.tree.trace(*arguments, **options), self.tree.trace(*full, **written))
        self.assertTrue((self.tree.occluded(*arguments, **options) == self.tree.occluded(*full, **written)).all())
        assert_same(self, self.tree.hits(*arguments, 3, **options), self.tree.hits(*full, 3, **written))
        return _abi.Rays.from_buffer_copy(rays.packed)

    def check_all(self, array, original):
        """The array is one element of the caller's."""
        self.assertEqual((array.data, array.stride), (original.ctypes.data, _abi.STRIDE_ALL))

    def test_one_origin(self):
        for origin in (self.origins[3, 0, 0], self.origins[3], np.broadcast_to(self.origins[3, 0, 0], (12, 7, 5, 3))):
            rays = self.layout(origin, self.directions)
            self.check_all(rays.origins, self.origins[3])
            self.assertEqual((rays.row_length, rays.rays_per_origin), (5, 1))

    def test_one_of_all(self):
        t_max, skip = np.float32(2), self.skip[2, 0, 0]
        rays = self.layout(self.origins[:, 0, 0], self.directions[0, 0, 0], t_min=0.25, t_max=t_max, skip=skip)
        self.check_all(rays.directions, self.directions)
        self.check_all(rays.skip, skip)
        self.assertEqual((rays.t_min.stride, rays.t_max.stride), (_abi.STRIDE_ALL, _abi.STRIDE_ALL))
        self.assertEqual((rays.origins.data, rays.rays_per_origin), (self.origins.ctypes.data, 1))

    def test_rays_per_origin(self):
        for shape in ((12, 35), (12, 7, 5)):
            ones = (12,) + (1,) * (len(shape) - 1)
            origins, skip = self.origins.reshape(ones + (3,)), self.skip.reshape(ones + (2,))
            directions = self.directions.reshape(shape + (3,))
            rays = self.layout(origins, directions, t_min=self.t_min.reshape(ones), t_max=self.t_max.reshape(shape), skip=skip)
            self.assertEqual((rays.rays_per_origin, rays.count), (35, 420))
            for array, original in ((rays.origins, origins), (rays.t_min, self.t_min), (rays.directions, directions)):
                self.assertEqual((array.data, array.stride), (original.ctypes.data, 0))
            self.assertEqual(rays.skip.data, skip.ctypes.data)

    def test_origins_in_a_wider_array(self):
        wide = np.zeros((12, 7), np.float32)
        wide[:, 2:5] = self.origins[:, 0, 0]
        rays = self.layout(wide[:, None, None, 2:5], self.directions, skip=self.skip[4])
        self.assertEqual((rays.origins.data, rays.origins.stride), (wide[:, 2:].ctypes.data, 28))
        self.assertEqual((rays.rays_per_origin, rays.skip.stride), (35, _abi.STRIDE_ALL))

    def test_groups_that_differ(self):
        rows = np.broadcast_to(self.skip, (12, 7, 1, 2))
        self.assertEqual(self.layout(self.origins, self.directions, skip=rows).rays_per_origin, 35)
        self.assertEqual(self.layout(self.origins, self.directions, skip=rows.copy()).rays_per_origin, 5)
        each = np.broadcast_to(self.skip, (12, 7, 5, 2)).copy()
        rays = self.layout(self.origins, self.directions, skip=each)
        self.assertEqual((rays.rays_per_origin, rays.skip.data), (1, each.ctypes.data))

    def test_what_has_to_be_copied(self):
        rays = self.layout(self.origins[0], self.directions[:, :1, :1], t_max=self.t_max)
        self.assertEqual((rays.rays_per_origin, rays.directions.stride, rays.count), (1, 12, 420))
        rays = self.layout(self.origins, self.directions[:1])
        self.assertEqual((rays.rays_per_origin, rays.directions.stride), (35, 12))
        self.layout(self.origins[:, :, :, ::-1], self.directions)
        self.layout(self.origins[0, 0, 0, ::-1], self.directions)

    def test_points_along_one_direction(self):
        tree, points = mlrt.Tree(*box()), np.random.default_rng(1).uniform(-2, 2, (50, 3)).astype(np.float32)
        self.assertTrue((tree.contains(points) == (np.abs(points) < 1).all(axis=1)).all())


class Rows(unittest.TestCase):
    """Arrays with two axes are rows of pixels; in flat lists the library looks for them."""

    def length(self, origins, directions):
        rays = Rays(origins, directions)
        return _abi.Rays.from_buffer_copy(rays.packed).row_length

    def setUp(self):
        camera = mlrt.Camera.look_at((3, 2, 4), (0, 0, 0), 512, 256)
        self.origins, self.directions = camera.rays()

    def test_pictures(self):
        origins, directions = self.origins, self.directions
        unit = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
        parallel = mlrt.Camera.orthographic((3, 2, 4), (0, 0, 0), 512, 256, 4).rays()
        for pair in ((origins, directions), (origins, unit), parallel):
            self.assertEqual(self.length(*pair), 512)
            self.assertEqual(self.length(*(array.transpose(1, 0, 2) for array in pair)), 256)
            self.assertEqual(self.length(*(array.reshape(-1, 3) for array in pair)), 0)
        self.assertEqual(self.length(origins[0, 0], directions), 512)

    def test_answers_stay_the_same(self):
        tree = mlrt.Tree(*box())
        origins, directions = (array.reshape(-1, 3) for array in (self.origins, self.directions))
        guessed, plain = tree.trace(origins, directions), tree.trace(origins, directions, row_length=len(origins))
        assert_same(self, guessed, plain)


class Meshes(unittest.TestCase):
    def test_index_types_and_strides(self):
        vertices, faces, origins, directions = integer_scene(5)
        expected = mlrt.Tree(vertices, faces).trace(origins, directions).triangle
        interleaved = np.zeros((len(vertices), 8), np.float32)
        interleaved[:, 2:5] = vertices
        padded = np.zeros((len(faces), 5), np.uint16)
        padded[:, 1:4] = faces
        meshes = [(vertices, faces.astype(dtype)) for dtype in ("u1", "i2", "u2", "i4", "i8", "u8", ">u4", ">i2")]
        meshes += [(interleaved[:, 2:5], faces), (vertices.astype(np.float64), faces.tolist()), (vertices, padded[:, 1:4])]
        meshes += [(vertices[faces.ravel()], None), (vertices[faces], None), (vertices, faces[:, ::-1][:, ::-1])]
        meshes += [(vertices, np.asfortranarray(faces)), (np.asfortranarray(vertices), faces)]
        for mesh in meshes:
            tree = mlrt.Tree(*mesh)
            self.assertTrue((tree.trace(origins, directions).triangle == expected).all())

    def test_overlapping_rows_are_copied(self):
        strip = np.array([0, 1, 2, 3, 4, 5], np.uint32)
        windows = np.lib.stride_tricks.sliding_window_view(strip, 3)
        vertices = np.random.default_rng(0).random((6, 3), np.float32)
        self.assertEqual(mlrt.Tree(vertices, windows).info.tree_hash, mlrt.Tree(vertices, windows.copy()).info.tree_hash)

    def test_several_meshes(self):
        vertices, faces = box()
        tree = mlrt.Tree.from_meshes([(vertices + 5, faces), (vertices, faces)], ids=[7, 3])
        hits = tree.trace([[5, 5.5, 9], [0, 0.5, 9], [9, 9, 9]], [0, 0, -1])
        self.assertEqual(hits.mesh.tolist(), [7, 3, mlrt.NONE])
        for ids in ([1], [1, 1], [1, mlrt.NONE], [1, -1]):
            with self.assertRaises(ValueError):
                mlrt.Tree.from_meshes([(vertices, faces)] * 2, ids=ids)

    def test_impossible_triangles_are_counted(self):
        vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0], [2, 0, 0]])
        info = mlrt.Tree(vertices, [[0, 1, 2], [0, 1, 3], [0, 1, 4]]).info
        self.assertEqual((info.triangle_count, info.non_finite_count, info.zero_area_count), (3, 1, 1))


class Outputs(unittest.TestCase):
    def setUp(self):
        self.tree = mlrt.Tree(*box())
        self.directions = np.random.default_rng(0).normal(size=(20, 3)).astype(np.float32)
        self.expected = self.tree.trace([0, 0, 0], self.directions)

    def test_only_what_is_asked_for(self):
        for outputs in ("t", ("triangle", "u"), ("facing", "mesh", "v")):
            hits = self.tree.trace([0, 0, 0], self.directions, outputs=outputs)
            for name, array in hits._asdict().items():
                if name in outputs:
                    self.assertEqual(array.tobytes(), getattr(self.expected, name).tobytes())
                else:
                    self.assertIsNone(array)
        for count in (1, 20):
            rays = self.directions[:count]
            hits = self.tree.trace(rays, rays, outputs=(name for name in ("t", "mesh")))
            self.assertEqual([array is None for array in hits], [False, True, True, False, True, True, True])
        with self.assertRaises(ValueError):
            self.tree.trace([0, 0, 0], [0, 0, 1], outputs=("t", "normal"))
        for rays in (self.directions, np.ones((1, 3), np.float32)):
            with self.assertRaisesRegex(ValueError, "outputs: at least one"):
                self.tree.trace(rays, rays, outputs=[])
            with self.assertRaises(mlrt.ArgumentError):
                self.tree.trace(rays, rays, out=mlrt.Hits())

    def test_into_arrays_with_strides(self):
        table = np.full((20, 4), 9, np.float32)
        out = mlrt.Hits(t=table[:, 1], triangle=table.view(np.uint32)[:, 3])
        self.assertIs(self.tree.trace([0, 0, 0], self.directions, out=out), out)
        self.assertTrue((out.t == self.expected.t).all() and (out.triangle == self.expected.triangle).all())
        self.assertTrue((table[:, ::2] == 9).all())

    def test_picture_into_a_larger_one(self):
        camera = mlrt.Camera.look_at((3, 2, 4), (0, 0, 0), 16, 12)
        canvas = np.zeros((30, 40), np.float32)
        self.tree.render(camera, out=mlrt.Hits(t=canvas[5:17, 7:23]))
        self.assertTrue((canvas[5:17, 7:23] == self.tree.render(camera).t).all())
        self.assertEqual(np.count_nonzero(canvas), 16 * 12)

    def test_occluded_into_bytes(self):
        out = np.full(20, 7, np.uint8)
        self.tree.occluded([0, 0, 0], self.directions, out=out)
        self.assertTrue((out == 1).all())

    def test_impossible_outputs(self):
        read_only = np.zeros(20, np.float32)
        read_only.flags.writeable = False
        impossible = [np.zeros(19, np.float32), np.zeros(20), np.zeros(20, np.float32)[::-1], read_only, [0.0] * 20]
        impossible += [np.broadcast_to(np.float32(0), 20), np.zeros(20, ">f4")]
        for array in impossible:
            with self.assertRaises(ValueError):
                self.tree.trace([0, 0, 0], self.directions, out=mlrt.Hits(t=array))


    def test_outputs_in_the_same_memory(self):
        table = np.zeros((21, 6), np.float32)
        rays, other = table[:20, :3], table[:20, 3]
        self.tree.trace(rays, self.directions, t_max=table[:20, 4], out=mlrt.Hits(t=other, u=table[:20, 5]))
        first, last = table.reshape(-1)[:20], table.reshape(-1)[-20:]
        self.tree.trace(last[:3], self.directions, out=mlrt.Hits(t=first))
        for out, text in (
            ({"t": other, "u": other}, "t and u share"),
            ({"t": first, "v": table.reshape(-1)[19:39]}, "t and v share"),
            ({"t": first, "triangle": first.view(np.uint32)}, "t and triangle share"),
            ({"u": table[1:, 3], "t": other}, "t and u share"),
            ({"t": table[:20, 1]}, "t shares memory with the rays"),
            ({"t": first}, "t shares memory with the rays"),
        ):
            with self.assertRaisesRegex(ValueError, f"^out: {text}"):
                self.tree.trace(rays, self.directions, out=mlrt.Hits(**out))
        with self.assertRaisesRegex(ValueError, "^out: occluded shares memory with the rays"):
            self.tree.occluded(self.directions, [0, 0, 1], out=self.directions.view(np.uint8).reshape(-1)[:20])
        camera = mlrt.Camera.look_at((3, 2, 4), (0, 0, 0), 5, 4)
        for strides in ((4, 4), (16, 4), (4, 12)):
            windows = np.lib.stride_tricks.as_strided(first, (4, 5), strides)
            with self.assertRaisesRegex(ValueError, "^out: t has elements that share memory"):
                self.tree.render(camera, out=mlrt.Hits(t=windows))
        turned = np.zeros((5, 4), np.float32).T
        self.tree.render(camera, out=mlrt.Hits(t=turned))
        self.assertEqual(turned.tolist(), self.tree.render(camera).t.tolist())


class Refused(unittest.TestCase):
    def setUp(self):
        self.vertices, self.faces = box()
        self.tree = mlrt.Tree(self.vertices, self.faces)

    def test_index_out_of_range(self):
        for wrong in (8, -1, 2**32, 2**40 + 1):
            faces = self.faces.astype(np.int64)
            faces[5, 1] = wrong
            with self.assertRaises(mlrt.IndexRangeError) as caught:
                mlrt.Tree(self.vertices, faces)
            self.assertIn("triangle 5", str(caught.exception))
            self.assertEqual(caught.exception.status, 3)

    def test_library_errors(self):
        with self.assertRaises(mlrt.ArgumentError):
            mlrt.Tree.kdtree(self.vertices, self.faces, max_depth=99)
        with self.assertRaises(mlrt.ArgumentError):
            mlrt.Tree(self.vertices, self.faces, traversal_cost=float("nan"))

    def test_numbers_that_would_become_others(self):
        """2^32 would be 0, 1.7 would be 1."""
        ray, mesh = ([0.5, 0.25, -9], [0, 0, 1]), (self.vertices, self.faces)
        first = self.tree.trace_ray(*ray)
        behind = [(first.mesh, first.triangle), np.array([first.mesh, first.triangle], np.int8)]
        for skip in behind:
            self.assertEqual((float(self.tree.trace(*ray, skip=skip).t), self.tree.trace_ray(*ray, skip=skip).t), (10, 10))
        for skip in ((-1, -1), (mlrt.NONE, mlrt.NONE)):
            self.assertEqual((float(self.tree.trace(*ray, skip=skip).t), self.tree.trace_ray(*ray, skip=skip).t), (8, 8))
        for wrong in (1 << 32, -2, 0.5):
            skip = (wrong, first.triangle)
            for call in (self.tree.trace, self.tree.occluded, self.tree.trace_ray, self.tree.occluded_ray):
                with self.assertRaisesRegex((ValueError, TypeError), "skip", msg=f"{call} {skip}"):
                    call(*ray, skip=skip)
        for call in (
            lambda: mlrt.Tree.from_meshes([mesh, mesh], ids=[0.5, 1.5]),
            lambda: mlrt.Tree.from_meshes({1.5: mesh}),
            lambda: mlrt.Tree.kdtree(*mesh, max_depth=2.5),
            lambda: mlrt.Tree(*mesh, memory_limit=1e9),
            lambda: mlrt.estimate_tree([1.5]),
            lambda: self.tree.hits(*ray, 2.5),
            lambda: mlrt.Tree.load(self.tree.to_bytes(), geometry_hash=0.5),
        ):
            with self.assertRaisesRegex(TypeError, ": an integer is needed, not "):
                call()

    def test_more_rays_than_a_call_can_have(self):
        one, two = np.ones(3, np.float32), np.ones((2, 1, 3), np.float32)
        for array, shape in ((one, (1 << 31, 3)), (one, (1 << 33, 3)), (two, (2, 1 << 32, 3))):
            rays = np.broadcast_to(array, shape)
            for call in (self.tree.trace, self.tree.occluded, lambda *rays: self.tree.hits(*rays, 1)):
                with self.assertRaisesRegex(mlrt.TooLargeError, "^rays: ") as caught:
                    call(rays, [0, 0, 1])
                self.assertEqual(caught.exception.status, 5)

    def test_masked_elements(self):
        rays = np.ma.array(np.ones((2, 3), np.float32), mask=np.zeros((2, 3)))
        self.assertEqual(self.tree.trace(rays * 0, rays).t.tolist(), [1, 1])
        faces = np.ma.array(self.faces, mask=np.arange(36).reshape(12, 3) == 7)
        rays[1, 2] = np.ma.masked
        for call in (
            lambda: self.tree.trace([0, 0, 0], rays),
            lambda: self.tree.occluded([0, 0, 0], [0, 0, 1], t_max=rays[1]),
            lambda: self.tree.trace([0, 0, 0], [0, 0, 1], mask=rays[1].astype(int)),
            lambda: self.tree.trace([0, 0, 0], [0, 0, 1], skip=rays[:, 1:].astype(int)),
            lambda: mlrt.Tree(self.vertices, faces),
        ):
            with self.assertRaisesRegex(ValueError, "masked"):
                call()

    def test_shapes_and_types(self):
        for vertices, faces in (
            (self.vertices[:, :2], self.faces),
            (self.vertices, self.faces[:, :2]),
            (self.vertices, self.faces.astype(float)),
            (self.vertices[0], self.faces),
            (self.vertices, None),
        ):
            with self.assertRaises((ValueError, TypeError)):
                mlrt.Tree(vertices, faces)
        for arguments in (
            {"origins": [0, 0]},
            {"origins": 0},
            {"skip": [0.5, 0]},
            {"skip": [0, 0, 0]},
            {"method": "fast"},
            {"isa": "mmx"},
            {"row_length": -1},
            {"row_length": 2.5},
            {"row_length": 1 << 32},
        ):
            with self.assertRaises((ValueError, TypeError), msg=str(arguments)):
                self.tree.trace(**{"origins": [0, 0, 0], "directions": [0, 0, 1], **arguments})
        with self.assertRaises(ValueError):
            mlrt.Tree(self.vertices, self.faces, preset="fine")
        with self.assertRaises(ValueError):
            mlrt.Tree.kdtree(self.vertices, self.faces, preset="fine")
        with self.assertRaises(ValueError):
            mlrt.Tree.kdtree(self.vertices, self.faces, rules_off=["all"])
        with self.assertRaises(ValueError):
            mlrt.Pool(5000)


if __name__ == "__main__":
    unittest.main()
