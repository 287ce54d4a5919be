#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sweep.py - what the library decides while it traces, and how it builds trees, against fixed choices

    sweep.py [--scene NAME|FILE]... [--views FILE.json] [--kinds primary,shadow,mirror] [--rounds 9] [--lives 2] [--jobs N]
    sweep.py --trees [--scene NAME|FILE]... [--views FILE.json] [--kinds frame,bounce] [--rounds 3] [--isa avx2,avx512] [--size 512]

measures the bench program of build/, the settings as they are, against one for every setting of src/base/tuning.h listed here
(in build/sweep/: the same objects, but for those that the setting changes; the kernels of SSE2 and plain C keep theirs), and prints
CSV: scene, kind, setting, and its rate over that of the settings as they are. A few programs with a scene each are there at once and
take turns, run by run, the settings as they are first. What counts is the median over the rounds of how much faster a setting was
than the settings as they are in the same round: so what else happens on a machine, for longer than a round, happens to all. As a
program may be slow all its life by where its memory lies, all this is done for several lives, and the median of these counts. The
settings as they are take part twice, which shows how far chance goes.

With --trees it compares trees: it builds the library for each of TREES, and one bench program traces the trees that these build, and
trees by other costs, all with its own kernels and run by run in turns (`bench --study costs`). It prints CSV, and on stderr, for each
instruction set and scene, the tree that is the fastest in the geometric mean of all kinds, over the mean of the two default trees.
"""
import argparse
import csv
import math
import os
import re
import shutil
import statistics
import subprocess
import sys

# So many settings at once, beside those as they are: each has a tree in memory.
AT_ONCE = 5

# Name -> macros. The first is what all are compared with.
SETTINGS = {
    "as it is": {},
    "as it is once more": {},
    "never squares": {"FIRST_OPEN_SQUARES": "0xFFFFFFFFu"},
    "always squares": {"SQUARE_BACKOFF": "0"},
    "tiles always open": {"FIRST_OPEN_TILES": "0xFFFFFFFFu"},
    "tiles always closed": {"TILE_BACKOFF": "0", "CELL_BACKOFF": "0"},
    "wide packets stay": {"WIDE_FACTOR": "1e30f"},
    "wide from 2.5": {"WIDE_FACTOR": "2.5f"},
    "few rays stay": {"MANY_PACKETS": "17"},
    "leaves never asked": {"FEW_LEAF_RAYS": "0"},
    "tests without end": {"MOST_TESTS": "0xFFFFFFFFu", "MOST_WAIST_TESTS": "0xFFFFFFFFu",
                          "MOST_ANY_TESTS": "0xFFFFFFFFu"},
    "trials at least every eighth tile": {"LAST_TRIAL": "7"},
    "512 set-ups kept": {"LEAF_SETUP_BITS": "9"},
}

# Likewise for the builder; default trees are compared by the bench program itself.
TREES = {
    "leaves of 4": {"LEAF_TRIANGLES": "4"},
    "leaves of 8": {"LEAF_TRIANGLES": "8"},
    "leaves of 12": {"LEAF_TRIANGLES": "12"},
    "nodes of 8": {"NODE_CHILDREN": "8"},
    "nodes of 12": {"NODE_CHILDREN": "12"},
    "no spare places": {"SPARE_SHARE": "0.0f"},
    "0.08 spare places": {"SPARE_SHARE": "0.08f"},
    "0.3 spare places": {"SPARE_SHARE": "0.3f"},
    "overlap 0.00001": {"OVERLAP_LIMIT": "1e-5f"},
    "overlap 0.001": {"OVERLAP_LIMIT": "1e-3f"},
    "spatial from 16": {"SPATIAL_SIZE": "16"},
    "plane gain 0.95": {"PLANE_GAIN": "0.95"},
    "plane gain 1": {"PLANE_GAIN": "1.0"},
}

# Trees of more bytes per triangle are no choice for the default.
MOST_BYTES = 60


def changed_sources(macros):
    """The units that depend on one of these macros, by what the compiler wrote when it built build/."""
    mentioned = set()
    for folder, _, files in os.walk("src"):
        for file in files:
            with open(os.path.join(folder, file)) as text:
                if file != "tuning.h" and any(f"MLRT_{macro}" in line for line in text for macro in macros):
                    mentioned.add(os.path.join(folder, file))
    sources = set()
    for folder, _, files in os.walk(os.path.join("build", "obj")):
        for file in files:
            if file.endswith(".d"):
                with open(os.path.join(folder, file)) as text:
                    words = text.read().split()
                sources.update([words[1]] if mentioned & set(words) else [])
    return sorted(sources - {"src/isa/sse.c", "src/isa/scalar.c"})


def make_default(jobs):
    """Builds the bench program with the settings as they are, and returns where it is."""
    subprocess.run(["make", "--no-print-directory", f"-j{jobs}", "build/bin/bench"], check=True, stdout=sys.stderr)
    return os.path.join("build", "bin", "bench")


def tuning_with(macros):
    """The text of tuning.h with a setting. Each macro must be there, once."""
    with open(os.path.join("src", "base", "tuning.h")) as text:
        tuning = text.read()
    for macro, value in macros.items():
        tuning, count = re.subn(rf"^(#define MLRT_{macro} +).*", rf"\g<1>{value}", tuning, flags=re.M)
        if count != 1:
            raise SystemExit(f"sweep.py: MLRT_{macro} is there {count} times in src/base/tuning.h")
    return tuning


def make_with(name, macros, target, jobs):
    """Builds a target with a setting, and returns where it is."""
    folder = os.path.join("build", "sweep", name.replace(" ", "-"))
    shutil.rmtree(folder, ignore_errors=True)
    for part in ("obj", "examples"):
        shutil.copytree(os.path.join("build", part), os.path.join(folder, part))
    os.makedirs(os.path.join(folder, "src", "base"))
    with open(os.path.join(folder, "src", "base", "tuning.h"), "w") as text:
        text.write(tuning_with(macros))
    changed = [word for source in changed_sources(macros) for word in ("-W", source)]
    path = os.path.join(folder, target)
    make = ["make", "--no-print-directory", f"-j{jobs}"] + changed
    subprocess.run(make + [f"BUILD={folder}", f"CPPFLAGS=-I{folder}/src", path], check=True, stdout=sys.stderr)
    return path


class Bench:
    """A bench program that runs when it is told to."""

    def __init__(self, path, scene, options):
        command = [path, "--alone", "--paced", "--csv", "--scene", scene, "--kind", options.kinds]
        command += ["--runs", str(options.rounds)] + (["--views", options.views] if options.views else [])
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.scene = None

    def wait(self):
        """Until the program has nothing to do. The kind of its next run, or None after the last."""
        for line in self.process.stdout:
            if line.startswith("turn "):
                return line.split()[1]
            if "," in line and not line.startswith("scene,"):
                self.scene = line.split(",")[0]
        if self.process.wait() != 0:
            raise SystemExit(f"bench: exit code {self.process.returncode}")
        return None

    def run(self):
        """One run's seconds, and the kind of the next"""
        try:
            self.process.stdin.write("\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            raise SystemExit(f"bench: exit code {self.process.wait()}") from None
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"bench: exit code {self.process.wait()}")
        return float(line), self.wait()


def compare_once(paths, scene, options):
    """The scene's name, and of each setting and kind the rate over that of the first setting"""
    programs = {name: Bench(path, scene, options) for name, path in paths.items()}
    kinds = [program.wait() for program in programs.values()]
    ratios = {}  # setting, kind -> one of each round
    while kinds[0]:
        kind = kinds[0]
        runs = {name: program.run() for name, program in programs.items()}
        first = next(iter(runs.values()))[0]
        for name, (seconds, _) in runs.items():
            ratios.setdefault((name, kind), []).append(first / seconds)
        kinds = [following for _, following in runs.values()]
    title = next(iter(programs.values())).scene
    return title, {key: statistics.median(values) for key, values in ratios.items()}


def compare(paths, scene, options):
    """The same, of several lives"""
    lives = [compare_once(paths, scene, options) for _ in range(options.lives)]
    return lives[0][0], {key: statistics.median(gains[key] for _, gains in lives) for key in lives[0][1]}


def mean_of(values):
    return math.exp(sum(math.log(value) for value in values) / len(values))


def judge(rows, isa, scene):
    """Which tree has the greatest mean rate over the two default trees', of those that are not too large"""
    gains, sizes = {}, {}
    for row in rows:
        if (row["isa"], row["scene"]) == (isa, scene):
            gains.setdefault(row["setting"], []).append(float(row["over_default"]))
            sizes[row["setting"]] = float(row["bytes_per_triangle"])
    means = {setting: mean_of(values) for setting, values in gains.items()}
    default = (means.pop("default") * means["default once more"]) ** 0.5
    chance = means.pop("default once more") / default
    best = max((setting for setting in means if sizes[setting] <= MOST_BYTES), key=means.get)
    print(f"{isa}, {scene}: {best} {means[best] / default:.3f}, least kind {min(gains[best]) / default:.3f}; "
          f"default once more {chance:.3f}", file=sys.stderr)


def compare_trees(options):
    """Prints what `bench --study costs` says of all trees, and judges it."""
    command = [make_default(options.jobs), "--study", "costs", "--isa", options.isa, "--size", str(options.size)]
    libraries = [make_with(name, macros, "libmlrt.so", options.jobs) for name, macros in TREES.items()]
    command += ["--trees", ",".join(libraries), "--runs", str(options.rounds or 3)]
    command += ["--kind", options.kinds] if options.kinds else []
    command += ["--views", options.views] if options.views else []
    for scene in options.scene or ["room", "office", "building", "scan"]:
        command += ["--scene", scene]
    lines = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            print(line, end="", flush=True)
            lines.append(line)
    if process.returncode != 0:
        raise SystemExit(f"bench: exit code {process.returncode}")
    rows = list(csv.DictReader(lines))
    for isa, scene in dict.fromkeys((row["isa"], row["scene"]) for row in rows):
        judge(rows, isa, scene)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scene", action="append")
    parser.add_argument("--views")
    parser.add_argument("--kinds")
    parser.add_argument("--rounds", type=int)
    parser.add_argument("--trees", action="store_true")
    parser.add_argument("--check", action="store_true", help="only see whether all macros are there")
    parser.add_argument("--isa", default="avx2,avx512")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--lives", type=int, default=2)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    if options.check:
        for macros in [*SETTINGS.values(), *TREES.values()]:
            tuning_with(macros)
        return
    if options.trees:
        compare_trees(options)
        return
    options.kinds = options.kinds or "primary,shadow,mirror"
    options.rounds = options.rounds or 9
    as_they_are = make_default(options.jobs)
    paths = {
        name: make_with(name, macros, os.path.join("bin", "bench"), options.jobs) if macros else as_they_are
        for name, macros in SETTINGS.items()
    }
    as_it_is, *others = paths
    print("scene,kind,setting,over_as_it_is")
    for scene in options.scene or ["room", "office", "building", "scan"]:
        for begin in range(0, len(others), AT_ONCE):
            names = [as_it_is] + others[begin : begin + AT_ONCE]
            title, gains = compare({name: paths[name] for name in names}, scene, options)
            for (name, kind), gain in gains.items():
                if name != as_it_is:
                    print(f"{title},{kind},{name},{gain:.3f}", flush=True)


if __name__ == "__main__":
    main()
