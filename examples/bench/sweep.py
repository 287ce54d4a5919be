#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sweep.py - what the library decides while it traces, against fixed choices

    sweep.py [--scene NAME|FILE]... [--views FILE.json] [--kinds primary,shadow] [--rounds 3] [--jobs N]

builds the bench program once for every setting of src/tuning.h listed here (in build/sweep/), and prints CSV: scene, kind, setting,
Mray/s, and the rate over that of the settings as they are. Settings take turns, round after round, and the best round of each
counts: what else happens on a machine only makes a run slower. The settings as they are take part twice, which shows how far
chance goes.
"""
import argparse
import os
import subprocess
import sys

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


def run(path, scene, options):
    """The scene's name, and kind -> Mray/s"""
    command = [path, "--alone", "--scene", scene, "--kind", options.kinds, "--runs", "9", "--csv"]
    command += ["--views", options.views] if options.views else []
    lines = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()[1:]
    rows = [line.split(",") for line in lines]
    return rows[0][0], {row[1]: float(row[5]) for row in rows}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scene", action="append")
    parser.add_argument("--views")
    parser.add_argument("--kinds", default="primary,shadow")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    programs = {name: program(name, options.jobs) for name in SETTINGS}
    print("scene,kind,setting,mrays,over_as_it_is")
    for scene in options.scene or ["room", "office", "building", "scan"]:
        best = {}  # kind -> setting -> Mray/s
        for _ in range(options.rounds):
            for name, path in programs.items():
                title, rates = run(path, scene, options)
                for kind, rate in rates.items():
                    of_kind = best.setdefault(kind, {})
                    of_kind[name] = max(rate, of_kind.get(name, 0))
        for kind, rates in best.items():
            for name, rate in rates.items():
                print(f"{title},{kind},{name},{rate:.2f},{rate / rates['as it is']:.3f}", flush=True)


if __name__ == "__main__":
    main()
