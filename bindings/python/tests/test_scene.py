# SPDX-License-Identifier: MIT
"""The scene of bindings/c/scene.h, which every language's binding traces: prints the hash of the answers."""

import unittest
from pathlib import Path

import numpy as np

import mlrt

HEADER = Path(__file__).resolve().parents[2] / "c" / "scene.h"


class Draw:
    """A linear congruential generator."""

    def __init__(self):
        self.state = 1

    def numbers(self, count):
        drawn = []
        for _ in range(count):
            self.state = (self.state * 1664525 + 1013904223) % 2**32
            drawn.append(self.state >> 20)
        return np.array(drawn, np.uint32)

    def points(self, count, divisor):
        return ((self.numbers(3 * count).astype(np.float32) - 2048) / divisor).reshape(-1, 3)


def hash_of(hits):
    words = [getattr(hits, name).view(np.uint32) for name in ("t", "u", "v", "mesh", "triangle", "facing")]
    total = 0xCBF29CE484222325
    for byte in np.stack(words, axis=-1).astype("<u4").tobytes():
        total = (total ^ byte) * 0x100000001B3 % 2**64
    return total


class Scene(unittest.TestCase):
    def test_the_same_answers_as_in_every_language(self):
        draw = Draw()
        meshes = [(draw.points(100, 256), draw.numbers(450).reshape(-1, 3) % 100) for _ in range(2)]
        rays = [(draw.points(1, 256)[0], draw.points(1, 2048)[0]) for _ in range(1000)]
        origins, directions = (np.array(part, np.float32) for part in zip(*rays))
        aimed = np.arange(3, 1000, 4)
        directions[aimed] = meshes[0][0][aimed % 100] - origins[aimed]
        tree = mlrt.Tree.from_meshes(meshes, ids=[7, 3])
        total = hash_of(tree.trace(origins, directions))
        print(f"{total:016x}")
        self.assertIn(f"{total:016X}", HEADER.read_text())
        with mlrt.Pool(2) as pool:
            self.assertEqual(hash_of(tree.trace(origins, directions, pool=pool)), total)


if __name__ == "__main__":
    unittest.main()
