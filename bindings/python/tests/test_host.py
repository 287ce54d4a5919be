# SPDX-License-Identifier: MIT
"""What surrounds a build: memory foreseen and limited, progress, signals, the log; and what the library can do."""

import logging
import signal
import subprocess
import sys
import threading
import time
import types
import unittest
from unittest import mock

import numpy as np
from support import box, isas

import mlrt
from mlrt import _host


class Bar:
    """Stands for tqdm.auto.tqdm."""

    made: list = []
    error = None

    def __init__(self, total, unit, unit_scale):
        self.total, self.unit, self.steps, self.closed = total, unit, [], False
        Bar.made.append(self)

    def update(self, count):
        self.steps.append(count)
        if Bar.error is not None:
            raise Bar.error

    def close(self):
        self.closed = True


def soup(count):
    """Triangles that take some time to build."""
    vertices = np.random.default_rng(0).normal(size=(count * 3, 3)).astype(np.float32)
    vertices[1::3] = vertices[::3] + vertices[1::3] / 30
    vertices[2::3] = vertices[::3] + vertices[2::3] / 30
    return vertices


class Interrupted(Exception):
    pass


class WithBar(unittest.TestCase):
    def setUp(self):
        Bar.made, Bar.error = [], None
        module = types.ModuleType("tqdm.auto")
        module.tqdm = Bar
        patch = mock.patch.dict(sys.modules, {"tqdm": types.ModuleType("tqdm"), "tqdm.auto": module})
        patch.start()
        self.addCleanup(patch.stop)


class Builds(WithBar):
    def test_the_bar_reaches_its_end(self):
        vertices = soup(30000)
        expected = mlrt.Tree(vertices).info.tree_hash
        for pool in (None, mlrt.Pool(3)):
            self.assertEqual(mlrt.Tree(vertices, progress=True, pool=pool).info.tree_hash, expected)
            bar = Bar.made.pop()
            self.assertEqual((bar.total, sum(bar.steps), bar.unit, bar.closed), (30000, 30000, "triangles", True))
            self.assertGreater(len(bar.steps), 2)
            self.assertGreaterEqual(min(bar.steps), 0)
        mlrt.Tree.from_meshes([box(), box(2, 3)], progress=True)
        self.assertEqual(Bar.made.pop().total, 24)
        mlrt.Tree.from_meshes([], progress=True)

    def test_what_is_raised_in_the_bar_ends_the_build(self):
        Bar.error = Interrupted("here")
        for pool in (None, mlrt.Pool(3)):
            with self.assertLogs("mlrt", "INFO") as logged, self.assertRaisesRegex(Interrupted, "here"):
                mlrt.Tree(soup(30000), progress=True, pool=pool)
            self.assertEqual(logged.output, ["INFO:mlrt:stopped by the host"])
            bar = Bar.made.pop()
            self.assertEqual((len(bar.steps), bar.closed), (1, True))

    def test_errors_of_the_library(self):
        with self.assertRaises(mlrt.IndexRangeError):
            mlrt.Tree(box()[0], box()[1] + 8, progress=True)
        self.assertTrue(Bar.made.pop().closed)


@unittest.skipUnless(hasattr(signal, "setitimer"), "needs timers")
class Signals(WithBar):
    """Signals arrive while C code runs."""

    def setUp(self):
        super().setUp()
        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, self.interrupt))
        self.addCleanup(signal.setitimer, signal.ITIMER_REAL, 0)
        unraisable = mock.patch.object(sys, "unraisablehook", lambda lost: self.lost.append(lost.exc_type))
        self.lost = []
        self.sigint = signal.getsignal(signal.SIGINT)  # ignored where the tests run in the background
        unraisable.start()
        self.addCleanup(unraisable.stop)

    def interrupt(self, number, frame):
        raise Interrupted

    def check_ends(self, call):
        """A call that takes long enough is ended by the signal, and long before its end."""
        start = time.perf_counter()
        call()
        whole = time.perf_counter() - start
        for _ in range(5):
            start = time.perf_counter()
            with self.assertRaises(Interrupted):  # also if the signal comes before the call
                signal.setitimer(signal.ITIMER_REAL, whole / 8)
                call()
            self.assertLess(time.perf_counter() - start, 0.8 * whole)
        self.assertEqual(self.lost, [])
        self.assertEqual(signal.getsignal(signal.SIGALRM), self.interrupt)
        self.assertIs(signal.getsignal(signal.SIGINT), self.sigint)

    def test_builds(self):
        vertices = soup(150000)
        self.check_ends(lambda: mlrt.Tree(vertices, progress=True))

    def test_pictures(self):
        tree, camera = mlrt.Tree(soup(3000)), mlrt.Camera.look_at((3, 2, 4), (0, 0, 0), 600, 600)
        self.check_ends(lambda: tree.render(camera, method="ray", progress=True))

    def test_without_a_bar_it_is_raised_at_the_end(self):
        vertices = soup(30000)
        for _ in range(5):
            with self.assertRaises(Interrupted):
                signal.setitimer(signal.ITIMER_REAL, 0.002)
                mlrt.Tree(vertices)
        self.assertEqual(self.lost, [])

    def test_handlers_that_raise_nothing(self):
        seen = []
        signal.signal(signal.SIGALRM, lambda *_: seen.append(1))
        signal.setitimer(signal.ITIMER_REAL, 0.002)
        self.assertEqual(mlrt.Tree(soup(30000), progress=True).info.triangle_count, 30000)
        self.assertEqual(seen, [1])

    def test_a_signal_that_comes_when_its_handler_is_set(self):
        seen, install = [], signal.signal

        def install_and_raise(number, handler):
            previous = install(number, handler)
            if number == signal.SIGALRM and handler == callbacks._handle:
                signal.raise_signal(number)
            return previous

        signal.signal(signal.SIGALRM, lambda *_: seen.append(1))
        callbacks = _host.Callbacks()
        with mock.patch.object(_host.signal, "signal", install_and_raise), callbacks:
            pass
        self.assertEqual(seen, [1])

    def test_handlers_that_raise_while_others_are_set(self):
        install = signal.signal
        self.addCleanup(signal.signal, signal.SIGUSR1, signal.signal(signal.SIGUSR1, self.interrupt))
        # The first of two is replaced, and the second raises; then the first is set again, and raises before the second is.
        for begins, raised in ((True, signal.SIGUSR1), (False, signal.SIGALRM)):
            callbacks, once = _host.Callbacks(), [raised]

            def install_and_raise(number, handler):
                previous = install(number, handler)
                wanted = callbacks._handle if begins else self.interrupt
                if once and number == signal.SIGALRM and handler == wanted:
                    signal.raise_signal(once.pop())
                return previous

            with mock.patch.object(_host.signal, "signal", install_and_raise), self.assertRaises(Interrupted), callbacks:
                pass
            for number in (signal.SIGALRM, signal.SIGUSR1):
                self.assertEqual(signal.getsignal(number), self.interrupt)

    def test_in_other_threads(self):
        made = []
        thread = threading.Thread(target=lambda: made.append(mlrt.Tree(*box(), progress=True)))
        thread.start()
        thread.join()
        self.assertEqual(len(made), 1)


class Log(unittest.TestCase):
    def setUp(self):
        self.addCleanup(logging.getLogger("mlrt").setLevel, logging.NOTSET)

    def test_levels(self):
        vertices, faces = box()
        vertices[0] = np.nan
        with self.assertLogs("mlrt", "DEBUG") as logged:
            mlrt.Tree(vertices, faces)
        self.assertEqual([record.levelname for record in logged.records], ["WARNING", "INFO"])
        self.assertIn("triangles can never be hit", logged.output[0])
        self.assertIn("tree of 12 triangles", logged.output[1])
        with self.assertLogs("mlrt", "DEBUG") as logged, self.assertRaises(mlrt.IndexRangeError) as caught:
            mlrt.Tree(vertices, faces + 8)
        self.assertEqual([record.levelname for record in logged.records], ["DEBUG"])
        self.assertIn(logged.records[0].getMessage(), str(caught.exception))
        with self.assertLogs("mlrt", "DEBUG") as logged, self.assertRaises(mlrt.DataError):
            mlrt.Tree.load(b"")
        self.assertEqual(logged.output, ["DEBUG:mlrt:data: not a saved tree"])

    def test_no_callbacks_if_nobody_listens(self):
        with mock.patch.object(_host._abi, "LogCallback", side_effect=AssertionError):
            logging.getLogger("mlrt").setLevel(logging.CRITICAL)
            mlrt.Tree.load(mlrt.Tree(*box()).to_bytes())
            logging.getLogger("mlrt").setLevel(logging.WARNING)
            with self.assertRaises(AssertionError):
                mlrt.Tree(*box())

    def test_what_handlers_raise_arrives(self):
        def refuse(record):
            raise Interrupted

        logger = logging.getLogger("mlrt")
        logger.setLevel(logging.INFO)
        logger.addFilter(refuse)
        self.addCleanup(logger.removeFilter, refuse)
        with self.assertRaises(Interrupted):
            mlrt.Tree(*box())

    def test_nothing_is_printed(self):
        code = "import mlrt, numpy; mlrt.Tree(numpy.full((3, 3), numpy.nan))"
        result = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
        self.assertEqual((result.stdout, result.stderr), (b"", b""))
        code = "import logging; logging.basicConfig(format='%(name)s %(message)s'); " + code
        result = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
        self.assertTrue(result.stderr.startswith(b"mlrt 1 triangles"), result.stderr)


class Memory(unittest.TestCase):
    def test_estimate(self):
        vertices = soup(5000)
        for options in ({}, {"preset": "fast"}, {"preset": "best"}):
            info, estimate = mlrt.Tree(vertices, **options).info, mlrt.estimate_tree(5000, **options)
            self.check_estimate(info, estimate, 0.75, 1.1)
        for options in ({}, {"preset": "tuned"}):
            info, estimate = mlrt.Tree.kdtree(vertices, **options).info, mlrt.estimate_kdtree(5000, **options)
            self.check_estimate(info, estimate, 0.4, 2)

    def check_estimate(self, info, estimate, lowest, highest):
        for name in ("memory_size", "peak_memory_size"):
            real, foreseen = getattr(info, name), getattr(estimate, name)
            self.assertTrue(lowest <= real / foreseen <= highest, (name, real, foreseen))

    def test_several_meshes_and_masks(self):
        one = mlrt.estimate_tree(3000)
        several = mlrt.estimate_tree([1000, 2000])
        masked = mlrt.estimate_tree(np.array([1000, 2000]), masks=[1, 2])
        self.assertLess(abs(several.memory_size - one.memory_size), 1000)
        self.assertEqual(masked.memory_size - several.memory_size, 4 * 3000)
        for wrong in (-1, 1 << 64):
            with self.assertRaises(ValueError):
                mlrt.estimate_tree(wrong)
        with self.assertRaises(ValueError):
            mlrt.estimate_tree([1, 2], masks=[1])
        with self.assertRaises(mlrt.TooLargeError):
            mlrt.estimate_tree(1 << 40)

    def test_limit(self):
        vertices = soup(5000)
        peak = mlrt.Tree(vertices).info.peak_memory_size
        self.assertEqual(mlrt.Tree(vertices, memory_limit=peak).info.peak_memory_size, peak)
        for limit in (1, peak // 2, peak - 1):
            with self.assertRaisesRegex(mlrt.OutOfMemoryError, f"limit {limit}") as caught:
                mlrt.Tree(vertices, memory_limit=limit)
            self.assertIsInstance(caught.exception, MemoryError)
        for wrong in (-1, 1 << 64):
            with self.assertRaises(ValueError):
                mlrt.Tree(vertices, memory_limit=wrong)


class Capabilities(unittest.TestCase):
    def test_they_are_what_works(self):
        self.assertEqual(mlrt.capabilities(), set(isas()) - {"scalar"})


if __name__ == "__main__":
    unittest.main()
