# SPDX-License-Identifier: MIT
"""How fast mlrt is from Python, beside open3d, embreex and trimesh, whichever of them are installed (pip install them).

    python bench.py --scene dragon.ply --views cameras.json --threads 1,2     Mray/s, and what a call costs
    python bench.py --only trimesh --csv speed.csv                            a procedural scene, one table; also as CSV

Each scene has coherent rays, the pixels of a view row by row, and random ones: origins anywhere in the bounding box, directions
anywhere on the sphere. All get the same rays in the arrays they like best: float32, contiguous, (n, 3) each, for open3d packed
as its (n, 6) tensor before the clock runs; through trimesh float64, as trimesh's own arrays are. Contestants take turns, and of
all turns the median counts: processor time of the process with one thread, elapsed time with more and over Dask. Whether they
agree on what is hit is checked.
"""

import argparse
import csv
import importlib
import json
import sys
import timeit
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any, Callable, NamedTuple, Optional

import numpy as np

import mlrt
import mlrt.trimesh

Question = Callable[[], Any]

# What is asked, and what each returns.
QUESTIONS = {
    "triangle": "the number of the triangle: mlrt outputs='triangle', embreex run(); open3d cannot",
    "all": "mlrt t, u, v, mesh, triangle, facing; embreex output=True: t, u, v, ids, normal; open3d cast_rays: the same",
    "any": "mlrt occluded, embreex query='OCCLUDED', open3d test_occlusions",
}
METHODS: dict[str, dict[str, Any]] = {
    "intersects_first": {},
    "intersects_any": {},
    "intersects_id, first hit": {"multiple_hits": False},
    "intersects_location, first hit": {"multiple_hits": False},
    "intersects_id, all hits": {},
    "intersects_location, all hits": {},
}


class Scene(NamedTuple):
    name: str
    vertices: np.ndarray  # float32 (n, 3)
    faces: np.ndarray  # int32 (m, 3)
    view: dict[str, Any]


Line = tuple[str, ...]  # of a CSV file


class Row(NamedTuple):
    scene: str
    rays: str
    question: str
    threads: int
    speeds: dict[str, float]  # Mray/s


# ---- scenes and rays ---------------------------------------------------------------------------------------------------


def bumpy_sphere(rings: int = 400) -> Scene:
    """2 * rings * 2 * rings triangles around zero."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1), indexing="ij")
    radius = 1 + 0.02 * np.sin(23 * theta) * np.sin(19 * phi)
    vertices = radius * np.stack((np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)))
    corner = (np.arange(rings)[:, None] * (2 * rings + 1) + np.arange(2 * rings)).ravel()
    right, down = corner + 1, corner + 2 * rings + 1
    faces = np.concatenate((np.stack((corner, right, down), 1), np.stack((right, down + 1, down), 1)))
    view = {"eye": [0, 1, 3], "look": [0, 0, 0], "up": [0, 1, 0], "vfov": 40}
    return Scene("sphere", vertices.reshape(3, -1).T.astype(np.float32).copy(), faces.astype(np.int32), view)


def read_ply(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of a binary little-endian PLY with float x, y, z and triangles of uchar + 3 int."""
    data = path.read_bytes()
    start = data.index(b"end_header\n") + len(b"end_header\n")
    counts = [int(line.split()[2]) for line in data[:start].decode().splitlines() if line.startswith("element")]
    vertices = np.frombuffer(data, "<f4", 3 * counts[0], start).reshape(-1, 3)
    faces = np.frombuffer(data, np.dtype([("count", "u1"), ("corners", "<i4", 3)]), counts[1], start + vertices.nbytes)
    if (faces["count"] != 3).any():
        raise SystemExit(f"{path}: not all faces are triangles")
    return vertices.astype(np.float32), faces["corners"].astype(np.int32)


def view_of(vertices: np.ndarray) -> dict[str, Any]:
    """From outside at everything, for scenes without a view."""
    lower, upper = vertices.min(axis=0), vertices.max(axis=0)
    middle = (lower + upper) / 2
    return {"eye": middle + (upper - lower).max() * np.array([0.6, 0.5, 1.4]), "look": middle, "up": [0, 1, 0], "vfov": 45}


def scenes(files: Iterable[str], views: Optional[str]) -> Iterator[Scene]:
    known = json.loads(Path(views).read_text()) if views else {}
    for file in files:
        vertices, faces = read_ply(Path(file))
        name = Path(file).stem
        yield Scene(name, vertices, faces, known[name][0] if name in known else view_of(vertices))


def coherent_rays(scene: Scene, count: int) -> tuple[np.ndarray, np.ndarray]:
    view, size = scene.view, int(count**0.5)
    target = view["look"] if "look" in view else np.add(view["eye"], view["dir"])
    camera = mlrt.Camera.look_at(view["eye"], target, size, size, view["vfov"], view["up"])
    origins, directions = camera.rays()
    return origins.reshape(-1, 3), directions.reshape(-1, 3)


def random_rays(scene: Scene, count: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(1)
    lower, upper = scene.vertices.min(axis=0), scene.vertices.max(axis=0)
    directions = random.normal(size=(int(count**0.5) ** 2, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    origins = lower + (upper - lower) * random.random(directions.shape)
    return origins.astype(np.float32), directions.astype(np.float32)


# ---- contestants -------------------------------------------------------------------------------------------------------


def installed(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


class Mlrt:
    """mlrt, with a pool if there is more than one thread."""

    def __init__(self, scene: Scene) -> None:
        self.tree = mlrt.Tree(scene.vertices, scene.faces)

    def questions(self, origins: np.ndarray, directions: np.ndarray, threads: int) -> dict[str, Question]:
        pool = mlrt.Pool(threads) if threads > 1 else None
        return {
            "triangle": lambda: self.tree.trace(origins, directions, outputs="triangle", pool=pool),
            "all": lambda: self.tree.trace(origins, directions, pool=pool),
            "any": lambda: self.tree.occluded(origins, directions, pool=pool),
        }

    def hit(self, result: Any) -> np.ndarray:
        return np.asarray(result.hit)


class Embreex:
    """embreex, which has no threads: its figures for several are left out."""

    def __init__(self, scene: Scene) -> None:
        self.scene = importlib.import_module("embreex.rtcore_scene").EmbreeScene()
        self.mesh = importlib.import_module("embreex.mesh_construction").TriangleMesh(self.scene, scene.vertices, scene.faces)

    def questions(self, origins: np.ndarray, directions: np.ndarray, threads: int) -> dict[str, Question]:
        if threads > 1:
            return {}
        return {
            "triangle": lambda: self.scene.run(origins, directions),
            "all": lambda: self.scene.run(origins, directions, output=True),
            "any": lambda: self.scene.run(origins, directions, query="OCCLUDED"),
        }

    def hit(self, result: Any) -> np.ndarray:
        return np.asarray(result["primID"] != -1)


class Open3d:
    def __init__(self, scene: Scene) -> None:
        open3d: Any = importlib.import_module("open3d")
        self.tensor = open3d.core.Tensor
        self.scene = open3d.t.geometry.RaycastingScene()
        self.scene.add_triangles(self.tensor(scene.vertices), self.tensor(scene.faces.astype(np.uint32)))

    def questions(self, origins: np.ndarray, directions: np.ndarray, threads: int) -> dict[str, Question]:
        rays = self.tensor(np.concatenate((origins, directions), axis=1))
        return {
            "all": lambda: self.scene.cast_rays(rays, nthreads=threads),
            "any": lambda: self.scene.test_occlusions(rays, nthreads=threads),
        }

    def hit(self, result: Any) -> np.ndarray:
        return np.asarray(np.isfinite(result["t_hit"].numpy()))


PEERS: dict[str, Any] = {"embreex": Embreex, "open3d": Open3d}


# ---- measuring ---------------------------------------------------------------------------------------------------------


def take_turns(contestants: dict[str, Question], rounds: int, clock: Callable[[], float]) -> dict[str, float]:
    """Seconds: of each the median of `rounds` runs, one of each in turn, after one that does not count."""
    seconds: dict[str, list[float]] = {name: [] for name in contestants}
    for turn in range(rounds + 1):
        for name, ask in contestants.items():
            start = clock()
            ask()
            if turn:
                seconds[name].append(clock() - start)
    return {name: median(values) for name, values in seconds.items()}


def measure_arrays(scene: Scene, peers: list[str], options: argparse.Namespace) -> Iterator[Row]:
    contestants: dict[str, Any] = {"mlrt": Mlrt(scene)}
    contestants.update((name, PEERS[name](scene)) for name in peers)
    for kind, rays in (("coherent", coherent_rays(scene, options.rays)), ("random", random_rays(scene, options.rays))):
        hits = {name: one.hit(one.questions(*rays, 1)["all"]()) for name, one in contestants.items()}
        for name in peers:
            different = np.count_nonzero(hits[name] != hits["mlrt"])
            print(f"{scene.name}, {kind}: {name} differs in hit or miss for {different} rays", file=sys.stderr)
            if different > len(rays[0]) // 100:
                raise SystemExit("they do not answer the same question")
        for threads in options.threads:
            questions = {name: one.questions(*rays, threads) for name, one in contestants.items()}
            for question in QUESTIONS:
                asked = {name: asks[question] for name, asks in questions.items() if question in asks}
                seconds = take_turns(asked, options.rounds, process_time if threads == 1 else perf_counter)
                yield Row(scene.name, kind, question, threads, {name: len(rays[0]) / s / 1e6 for name, s in seconds.items()})


def measure_drop_in(scene: Scene, options: argparse.Namespace) -> Iterator[Row]:
    """trimesh with embreex, and with mlrt.trimesh in its place."""
    trimesh: Any = importlib.import_module("trimesh")
    embree: Any = importlib.import_module("trimesh.ray.ray_pyembree")
    mesh = trimesh.Trimesh(scene.vertices, scene.faces, process=False)
    rays = [array.astype(np.float64) for array in coherent_rays(scene, options.rays)]
    contestants = {"mlrt.trimesh": mlrt.trimesh.RayMeshIntersector(mesh), "trimesh": embree.RayMeshIntersector(mesh)}
    for title, arguments in METHODS.items():
        method = title.split(",")[0]
        asked: dict[str, Question] = {
            name: partial(getattr(one, method), *rays, **arguments) for name, one in contestants.items()
        }
        seconds = take_turns(asked, options.rounds, process_time)
        yield Row(scene.name, "coherent", title, 1, {name: len(rays[0]) / s / 1e6 for name, s in seconds.items()})


def microseconds(ask: Question) -> float:
    """Processor time per call, the best of many."""
    number = max(1, int(0.01 / max(timeit.timeit(ask, timer=process_time, number=1), 1e-6)))
    return min(timeit.repeat(ask, timer=process_time, number=number, repeat=40)) / number * 1e6


def box() -> Scene:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))], np.int32)
    return Scene("box", corners, faces, {})


def rays_at_the_box(count: int) -> tuple[np.ndarray, np.ndarray]:
    """A square of pixels, all of which see it."""
    camera = mlrt.Camera.look_at((2, 1.5, 4), (0, 0, 0), int(count**0.5), int(count**0.5), fov=15)
    origins, directions = camera.rays()
    return origins.reshape(-1, 3), directions.reshape(-1, 3)


def calls(tree: mlrt.Tree, count: int) -> dict[str, Question]:
    origins, directions = rays_at_the_box(count)
    wide = np.zeros((count, 8), np.float32)
    wide[:, :3] = origins
    doubles, out = origins.astype(np.float64), tree.trace(origins, directions)
    one = origins[0].tolist(), directions[0].tolist()
    of_one: dict[str, Question] = {
        "`trace_ray(origin, direction)`": lambda: tree.trace_ray(*one),
        "the same, of arrays `origins[0]`, `directions[0]`": lambda: tree.trace_ray(origins[0], directions[0]),
        "`occluded_ray(origin, direction)`": lambda: tree.occluded_ray(*one),
    }
    of_all: dict[str, Question] = {
        "`trace(origins, directions)`": lambda: tree.trace(origins, directions),
        "the same, `outputs=(\"t\", \"triangle\")`": lambda: tree.trace(origins, directions, outputs=("t", "triangle")),
        "the same, `outputs=\"triangle\"`": lambda: tree.trace(origins, directions, outputs="triangle"),
        "the same, `t_max=5.0`": lambda: tree.trace(origins, directions, t_max=5.0),
        "the same, `out=`": lambda: tree.trace(origins, directions, out=out),
        "the same, origins in a wider array": lambda: tree.trace(wide[:, :3], directions),
        "the same, origins in float64": lambda: tree.trace(doubles, directions),
        "`occluded(origins, directions)`": lambda: tree.occluded(origins, directions),
        "`hits(origins, directions, 0)`": lambda: tree.hits(origins, directions, 0),
        "`contains(origins)` (all outside)": lambda: tree.contains(origins),
    }
    return of_one | of_all if count == 1 else of_all


def peer_calls(scene: Scene, peers: list[str], count: int) -> dict[str, Question]:
    origins, directions = rays_at_the_box(count)
    found = {}
    for name in peers:
        questions = PEERS[name](scene).questions(origins, directions, 1)
        for question in ("triangle", "all", "any"):
            if question in questions:
                found[f"{name}, {question}"] = questions[question]
    return found


# ---- tables ------------------------------------------------------------------------------------------------------------


def print_table(title: str, names: list[str], rows: Iterable[Row]) -> list[Row]:
    """Prints rows as they come; the last column is the first name's speed over the best of the others."""
    print(f"\n{title}\n")
    print("| scene | rays | question | threads | " + " | ".join(names) + " | ratio |")
    print("| --- | --- | --- | ---: |" + " ---: |" * (len(names) + 1))
    done = []
    for row in rows:
        others = [row.speeds[name] for name in names[1:] if name in row.speeds]
        cells = [f"{row.speeds[name]:.1f}" if name in row.speeds else "" for name in names]
        ratio = f"{row.speeds[names[0]] / max(others):.2f}" if others else ""
        print(f"| {row.scene} | {row.rays} | {row.question} | {row.threads} | " + " | ".join(cells + [ratio]) + " |", flush=True)
        done.append(row)
    return done


def print_calls(peers: list[str]) -> list[Line]:
    scene = box()
    tree = mlrt.Tree(scene.vertices, scene.faces)
    few, many = (calls(tree, count) | peer_calls(scene, peers, count) for count in (1, 256))
    print("\nMicroseconds of processor time per call, a tree of one box, the best of many\n\n| call | 1 ray | 256 rays |\n| --- | ---: | ---: |")
    done: list[Line] = [("call", "one_us", "many_us")]
    for call, ask in few.items():
        several = f"{microseconds(many[call]):.0f}" if call in many else ""
        done.append((call, f"{microseconds(ask):.1f}", several))
        print(f"| {call} | {done[-1][1]} | {several} |", flush=True)
    return done


def print_distributed(found: list[Scene], options: argparse.Namespace) -> list[Line]:
    """Random rays and a picture over one and two worker processes, each with one thread; in turn, the median."""
    dask: Any = importlib.import_module("dask.distributed")
    distributed: Any = importlib.import_module("mlrt.distributed")
    array: Any = importlib.import_module("dask.array")
    print("\nMray/s over Dask, from rays that the workers have to triangles and t that they keep\n")
    print("| scene | rays | one process without Dask | 1 worker | 2 workers | 2 over 1 |\n| --- | --- | ---: | ---: | ---: | ---: |")
    done: list[Line] = [("scene", "rays", "alone", "one_worker", "two_workers")]
    with ExitStack() as stack:
        workers = {"processes": True, "threads_per_worker": 1, "dashboard_address": None}
        clusters = [stack.enter_context(dask.LocalCluster(n_workers=count, **workers)) for count in (1, 2)]
        clients = [stack.enter_context(dask.Client(cluster, set_as_default=False)) for cluster in clusters]
        for scene in found:
            tree = mlrt.Tree(scene.vertices, scene.faces)
            rays = random_rays(scene, options.rays)
            size = int(len(rays[0]) ** 0.5)
            target = scene.view["look"] if "look" in scene.view else np.add(scene.view["eye"], scene.view["dir"])
            camera = mlrt.Camera.look_at(scene.view["eye"], target, size, size, scene.view["vfov"], scene.view["up"])
            asks: dict[str, dict[str, Question]] = {"random": {"alone": lambda: tree.trace(*rays, outputs=("triangle", "t"))}}
            asks["picture"] = {"alone": lambda: tree.render(camera, outputs=("triangle", "t"))}
            for client in clients:
                cluster_scene = stack.enter_context(distributed.Scene(tree, client=client))
                piece = max(len(rays[0]) // 16, 1)
                lying = [client.persist(array.from_array(one, chunks=(piece, 3))) for one in rays]
                client.gather(client.compute([one.sum() for one in lying]))
                name = str(len(client.scheduler_info()["workers"]))

                def trace(client: Any = client, scene: Any = cluster_scene, lying: Any = lying, piece: int = piece) -> None:
                    with client.as_current():
                        dask.wait(scene.trace(*lying, outputs=("triangle", "t"), rays_per_piece=piece).t)

                def render(client: Any = client, scene: Any = cluster_scene, piece: int = piece) -> None:
                    with client.as_current():
                        dask.wait(scene.render(camera, outputs=("triangle", "t"), rays_per_piece=piece).t)

                asks["random"][name], asks["picture"][name] = trace, render
            for kind, contestants in asks.items():
                seconds = take_turns(contestants, options.rounds, perf_counter)
                speeds = [len(rays[0]) / seconds[name] / 1e6 for name in ("alone", "1", "2")]
                done.append((scene.name, kind, *(f"{speed:.3f}" for speed in speeds)))
                cells = " | ".join(f"{speed:.1f}" for speed in speeds)
                print(f"| {scene.name} | {kind} | {cells} | {speeds[2] / speeds[1]:.2f} |", flush=True)
    return done


def visits(tree: mlrt.Tree, any_hit: bool, origins: np.ndarray, directions: np.ndarray) -> tuple[float, float]:
    """Nodes and leaves, and triangles tested, per ray."""
    counters = mlrt.Counters()
    if any_hit:
        tree.occluded(origins, directions, counters=counters)
    else:
        tree.trace(origins, directions, outputs="triangle", counters=counters)
    return counters.cell_count / counters.ray_count, counters.triangle_test_count / counters.ray_count


def print_counts(found: list[Scene]) -> None:
    print("\nWhat random rays look at, per ray\n\n| scene | question | nodes and leaves | triangles |\n| --- | --- | ---: | ---: |")
    for scene in found:
        tree = mlrt.Tree(scene.vertices, scene.faces)
        rays = random_rays(scene, 1 << 16)
        for question, any_hit in (("closest", False), ("any", True)):
            cells, tests = visits(tree, any_hit, *rays)
            print(f"| {scene.name} | {question} | {cells:.2f} | {tests:.2f} |", flush=True)


def lines_of(rows: list[Row], names: list[str]) -> list[Line]:
    """With the best of all but the first, which the ratio is to."""
    done: list[Line] = [("scene", "rays", "question", "threads", *names, "best_other")]
    for row in rows:
        others = [row.speeds[name] for name in names[1:] if name in row.speeds]
        speeds = [f"{row.speeds[name]:.3f}" if name in row.speeds else "" for name in names]
        done.append((row.scene, row.rays, row.question, str(row.threads), *speeds, f"{max(others):.3f}" if others else ""))
    return done


def write_csv(path: str, lines: list[Line]) -> None:
    with open(path, "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", action="append", default=[], metavar="FILE.ply", help="binary PLY; may be given several times")
    parser.add_argument("--views", metavar="FILE.json", help='{"name of a scene": [{"eye", "look" or "dir", "up", "vfov"}]}')
    parser.add_argument("--rays", type=int, default=1 << 20, help="how many; rounded down to a square (default: %(default)s)")
    parser.add_argument("--threads", type=lambda text: [int(one) for one in text.split(",")], default=[1], metavar="1,2")
    parser.add_argument("--rounds", type=int, default=7, help="turns that each takes (default: %(default)s)")
    parser.add_argument("--only", choices=("arrays", "trimesh", "calls", "counts", "distributed"), help="one of the tables")
    parser.add_argument("--csv", metavar="FILE", help="with --only: write the table there as well")
    options = parser.parse_args()
    if options.csv and options.only in (None, "counts"):
        parser.error("--csv needs --only, of a table of times")
    return options


def main() -> None:
    options = parse()
    found = list(scenes(options.scene, options.views)) or [bumpy_sphere()]
    peers = [name for name in PEERS if installed(name)]
    with_trimesh = installed("trimesh.ray.ray_pyembree") is not None
    missing = [name for name in PEERS if name not in peers] + ([] if with_trimesh else ["trimesh with embreex"])
    if missing:
        print(f"Not installed, so not compared with: {', '.join(missing)}.")
    lines: list[Line] = []
    if options.only in (None, "arrays"):
        for question, meaning in QUESTIONS.items():
            print(f"- {question}: {meaning}")
        names = ["mlrt", *peers]
        speeds = (row for scene in found for row in measure_arrays(scene, peers, options))
        rows = print_table("Mray/s from numpy arrays; embreex has one thread", names, speeds)
        lines = lines_of(rows, ["mlrt", *PEERS])  # a column for each peer, so that documents need not change
    if options.only in (None, "trimesh") and with_trimesh:
        names = ["mlrt.trimesh", "trimesh"]
        speeds = (row for scene in found for row in measure_drop_in(scene, options))
        lines = lines_of(print_table("Mray/s through trimesh with embreex, and with mlrt.trimesh", names, speeds), names)
    if options.only in (None, "calls"):
        lines = print_calls(peers)
    if options.only in (None, "counts"):
        print_counts(found)
    if options.only in (None, "distributed") and installed("distributed") is not None:
        lines = print_distributed(found, options)
    if options.csv:
        write_csv(options.csv, lines)


if __name__ == "__main__":
    main()
