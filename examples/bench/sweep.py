#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sweep.py - what the library decides while it traces, against fixed choices

    sweep.py [--scene NAME|FILE]... [--views FILE.json] [--kinds primary,shadow] [--rounds 9] [--lives 2] [--jobs N]

measures the bench program of build/, the settings as they are, against one for every setting of src/base/tuning.h listed here
(in build/sweep/: the same objects, but for those that the setting changes; the kernels of SSE2 and plain C keep theirs), and prints
CSV: scene, kind, setting, and its rate over that of the settings as they are. A few programs with a scene each are there at once and
take turns, run by run, the settings as they are first. What counts is the median over the rounds of how much faster a setting was
than the settings as they are in the same round: so what else happens on a machine, for longer than a round, happens to all. As a
program may be slow all its life by where its memory lies, all this is done for several lives, and the median of these counts. The
settings as they are take part twice, which shows how far chance goes.
"""
import argparse
import os
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
    "always squares": {"SQUARE_RUN": "0"},
    "tiles always open": {"FIRST_OPEN_TILES": "0xFFFFFFFFu"},
    "tiles always closed": {"TILE_RUN": "0"},
    "wide packets stay": {"WIDE_FACTOR": "1e30f"},
    "wide from 2.5": {"WIDE_FACTOR": "2.5f"},
    "few rays stay": {"MANY_PACKETS": "17"},
    "leaves never asked": {"FEW_LEAF_RAYS": "0"},
    "tests without end": {"MOST_TESTS": "0xFFFFFFFFu"},
    "512 set-ups kept": {"LEAF_SETUP_BITS": "9"},
    "small leaves": {"TRIANGLE_COST": "0.08f"},
    "large leaves": {"TRIANGLE_COST": "0.005f"},
}


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


def program(name, jobs):
    """Builds the bench program with a setting, and returns where it is."""
    macros = SETTINGS[name]
    make = ["make", "--no-print-directory", f"-j{jobs}"]
    if not macros:
        subprocess.run(make + ["build/bin/bench"], check=True, stdout=sys.stderr)
        return os.path.join("build", "bin", "bench")
    folder = os.path.join("build", "sweep", name.replace(" ", "-"))
    shutil.rmtree(folder, ignore_errors=True)
    for part in ("obj", "examples"):
        shutil.copytree(os.path.join("build", part), os.path.join(folder, part))
    flags = " ".join(f"-DMLRT_{macro}={value}" for macro, value in macros.items())
    changed = [word for source in changed_sources(macros) for word in ("-W", source)]
    path = os.path.join(folder, "bin", "bench")
    subprocess.run(make + changed + [f"BUILD={folder}", f"CPPFLAGS={flags}", path], check=True, stdout=sys.stderr)
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


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scene", action="append")
    parser.add_argument("--views")
    parser.add_argument("--kinds", default="primary,shadow")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--lives", type=int, default=2)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    paths = {name: program(name, options.jobs) for name in SETTINGS}
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
