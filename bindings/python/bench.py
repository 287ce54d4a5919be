# SPDX-License-Identifier: MIT
"""What a call costs from Python: microseconds per call, the best of many runs, on a tree of one box."""

import timeit

import numpy as np

import mlrt

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
FACES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
CALLS = (
    "tree.trace(origins, directions)",
    "tree.trace(origins, directions, outputs=('t', 'triangle'))",
    "tree.trace(origins, directions, out=out)",
    "tree.occluded(origins, directions)",
    "tree.hits(origins, directions, 0)",
    "tree.contains(origins)",
    "tree.trace(wide[:, :3], directions)",
    "tree.trace(doubles, directions)",
)


def measure(call: str, names: dict) -> float:
    """Microseconds per call."""
    return min(timeit.repeat(call, globals=names, number=1000, repeat=50)) * 1e3


def names_for(tree: mlrt.Tree, count: int) -> dict:
    """Rays from outside of the box into it, side by side."""
    origins = np.linspace((-0.9, 0.3, 5), (0.9, 0.4, 5), count, dtype=np.float32)
    directions = np.tile(np.array([0, 0, -1], np.float32), (count, 1))
    wide = np.zeros((count, 8), np.float32)
    wide[:, :3] = origins
    out = tree.trace(origins, directions)
    return {"tree": tree, "origins": origins, "directions": directions, "wide": wide, "doubles": origins.astype(float), "out": out}


if __name__ == "__main__":
    box = mlrt.Tree(CORNERS, FACES)
    few, many = names_for(box, 1), names_for(box, 256)
    print(f"{'':60} {'1 ray':>8} {'256 rays':>9}")
    for call in CALLS:
        print(f"{call:60} {measure(call, few):8.1f} {measure(call, many):9.1f}")
