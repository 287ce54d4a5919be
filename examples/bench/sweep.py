#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sweep.py - what the library decides while it traces, against fixed choices

    sweep.py [--scene NAME|FILE]... [--views FILE.json] [--kinds primary,shadow] [--rounds 15] [--lives 3] [--jobs N]

builds the bench program once for every setting of src/tuning.h listed here (in build/sweep/), and prints CSV: scene, kind, setting,
Mray/s, and the rate over that of the settings as they are. A few programs with a scene each are there at once and take turns, run by
run, the settings as they are first. How much faster a setting is, is the median over the rounds of how much faster it was than the
settings as they are in the same round: so what else happens on a machine, for longer than a round, happens to all. As a program
may be slow all its life by where its memory lies, all this is done for several lives, and the median of these counts; Mray/s
are those of the median life's median run. The settings as they are take part twice, which shows how far chance goes.
"""
import argparse
import os
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
    "runs of 1": {"TILE_RUN": "1", "SQUARE_RUN": "1"},
    "runs of 8": {"TILE_RUN": "8", "SQUARE_RUN": "8"},
    "wide packets stay": {"WIDE_FACTOR": "1e30f"},
    "wide packets go alone": {"LEAST_PART": "17"},
    "wide from 2": {"WIDE_FACTOR": "2.0f"},
    "wide from 5": {"WIDE_FACTOR": "5.0f"},
    "none foreseen": {"FORESEEN_TRIANGLES": "17"},
    "all foreseen": {"FORESEEN_TRIANGLES": "1"},
    "few rays stay": {"MANY_PACKETS": "17"},
    "few rays up to 16": {"FEW_RAYS": "16"},
    "few rays up to 64": {"FEW_RAYS": "64"},
    "8 set-ups kept": {"LEAF_SETUP_BITS": "3"},
    "128 set-ups kept": {"LEAF_SETUP_BITS": "7"},
    "small leaves": {"TRIANGLE_COST": "0.08f"},
    "large leaves": {"TRIANGLE_COST": "0.005f"},
}


def program(name, jobs):
    """Builds the bench program with a setting, and returns where it is."""
    folder = os.path.join("build", "sweep", name.replace(" once more", "").replace(" ", "-"))
    flags = " ".join(f"-DMLRT_{macro}={value}" for macro, value in SETTINGS[name].items())
    path = os.path.join(folder, "bin", "bench")
    make = ["make", "--no-print-directory", f"-j{jobs}", f"BUILD={folder}", f"CPPFLAGS={flags}", path]
    subprocess.run(make, check=True, stdout=sys.stderr)
    return path


class Bench:
    """A bench program that runs when it is told to."""

    def __init__(self, path, scene, options):
        command = [path, "--alone", "--paced", "--csv", "--scene", scene, "--kind", options.kinds]
        command += ["--runs", str(options.rounds)] + (["--views", options.views] if options.views else [])
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.lines = []  # of CSV

    def read_line(self):
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"bench: exit code {self.process.wait()}")
        return line.strip()

    def wait(self):
        """Until the next run is prepared."""
        while (line := self.read_line()) != "turn":
            self.lines.append(line.split(","))

    def run(self):
        """One run's seconds"""
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return float(self.read_line())

    def finish(self):
        """The scene's name, and kind -> Mray/s"""
        rows = (self.lines + [line.strip().split(",") for line in self.process.stdout])[1:]
        if self.process.wait() != 0:
            raise SystemExit(f"bench: exit code {self.process.returncode}")
        return rows[0][0], {row[1]: float(row[5]) for row in rows}


def compare_once(paths, scene, options):
    """Of each setting the scene's name, kind -> Mray/s, and kind -> rate over that of the first setting"""
    programs = {name: Bench(path, scene, options) for name, path in paths.items()}
    gains = {name: {} for name in programs}
    for kind in options.kinds.split(","):
        ratios = {name: [] for name in programs}
        for program in programs.values():
            program.wait()
        for turn in range(options.rounds):
            seconds = {}
            for name, program in programs.items():
                if turn:
                    program.wait()
                seconds[name] = program.run()
            first = next(iter(seconds.values()))
            for name, value in seconds.items():
                ratios[name].append(first / value)
        for name, values in ratios.items():
            gains[name][kind] = statistics.median(values)
    return {name: program.finish() + (gains[name],) for name, program in programs.items()}


def compare(paths, scene, options):
    """The scene's name, and of each setting and kind Mray/s and the rate over that of the first setting"""
    lives = [compare_once(paths, scene, options) for _ in range(options.lives)]
    result = {}
    for name in paths:
        for kind in options.kinds.split(","):
            rate, gain = (statistics.median(life[name][of][kind] for life in lives) for of in (1, 2))
            result[name, kind] = rate, gain
    return lives[0][next(iter(paths))][0], result


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scene", action="append")
    parser.add_argument("--views")
    parser.add_argument("--kinds", default="primary,shadow")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--lives", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    paths = {name: program(name, options.jobs) for name in SETTINGS}
    as_it_is, *others = paths
    print("scene,kind,setting,mrays,over_as_it_is")
    for scene in options.scene or ["room", "office", "building", "scan"]:
        for begin in range(0, len(others), AT_ONCE):
            names = [as_it_is] + others[begin : begin + AT_ONCE]
            title, result = compare({name: paths[name] for name in names}, scene, options)
            for (name, kind), (rate, gain) in result.items():
                if begin == 0 or name != as_it_is:
                    print(f"{title},{kind},{name},{rate:.2f},{gain:.3f}", flush=True)


if __name__ == "__main__":
    main()
