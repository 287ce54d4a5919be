#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""lives.py - the speeds that a program prints, each the best of several lives of its libraries

    lives.py [--lives N] PROGRAM [ARGUMENT]...

runs PROGRAM, which prints CSV (bench --csv, say), N times, one after the other, and prints its lines once: texts and whole numbers as
they are, which must agree, and the greatest of each number with a decimal point. The speed of shadows alone is computed again, from
that of a lit frame and of a frame. On stderr: how far the second best of each number is from the best.

What else happens on a machine, for some minutes at times, only makes a run slower: so the best counts, for all libraries alike. Where
the pages of a shared object lie in memory can move its speed, too, and a file stays where it is as long as the system caches it. So
each time, all libraries that take part are copied to a folder of their own: that of build/, Embree, and another build of the library
after --against.
"""
import argparse
import csv
import io
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

# The libraries that are compared, by the names that a program loads them by.
COMPARED = re.compile(r"(lib(?:mlrt|embree)\S*) => (\S+)")
SPEED = re.compile(r"\d+\.\d+")


def copy_libraries(program, folder):
    for name, path in COMPARED.findall(subprocess.check_output(["ldd", program], text=True)):
        shutil.copy(path, os.path.join(folder, name))


def copy_argument(arguments, folder):
    """The arguments, with a copy of the library after --against."""
    arguments = list(arguments)
    if "--against" in arguments[:-1]:
        place = arguments.index("--against") + 1
        arguments[place] = shutil.copy(arguments[place], os.path.join(folder, "against.so"))
    return arguments


def run_copy(program, arguments):
    with tempfile.TemporaryDirectory() as folder:
        copy_libraries(program, folder)
        output = subprocess.run([program] + copy_argument(arguments, folder), check=True, stdout=subprocess.PIPE, text=True,
                                env=dict(os.environ, LD_LIBRARY_PATH=folder)).stdout
    return list(csv.reader(io.StringIO(output)))


def best_of(values):
    """Of one cell in all runs."""
    if all(SPEED.fullmatch(value) for value in values):
        return max(values, key=float)
    if len(set(values)) > 1:
        sys.exit(f"lives.py: runs disagree: {values}")
    return values[0]


def is_difference(row):
    return "lit-frame" in row


def subtract_frames(rows):
    """The lines lit-frame, computed again as bench does: a lit frame's time less that of a frame of the same scene and method."""
    known = {tuple(cell for cell in row if not SPEED.fullmatch(cell)): row for row in rows}
    for row in filter(is_difference, rows):
        texts = [cell for cell in row if not SPEED.fullmatch(cell)]
        lit, frame = (known[tuple(kind if text == "lit-frame" else text for text in texts)] for kind in ("lit", "frame"))
        for place, cell in enumerate(row):
            if SPEED.fullmatch(cell) and float(lit[place]) > 0 and float(frame[place]) > 0:
                time = 1 / float(lit[place]) - 1 / float(frame[place])
                row[place] = f"{1 / time if time > 0 else 0:.3f}"


def distances(row):
    """How many times the best of a cell's numbers is the second best."""
    for cells in zip(*row):
        speeds = sorted(float(cell) for cell in cells if SPEED.fullmatch(cell))
        if len(speeds) > 1 and speeds[-2] > 0:
            yield speeds[-1] / speeds[-2]


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].strip())
    parser.add_argument("--lives", type=int, default=3)
    parser.add_argument("program")
    parser.add_argument("arguments", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    runs = [run_copy(options.program, options.arguments) for _ in range(options.lives)]
    if len({len(run) for run in runs}) > 1:
        sys.exit("lives.py: runs print different numbers of lines")
    rows = [[best_of(cells) for cells in zip(*row)] for row in zip(*runs)]
    subtract_frames(rows)
    csv.writer(sys.stdout, lineterminator="\n").writerows(rows)
    apart = [distance for row in zip(*runs) if not is_difference(row[0]) for distance in distances(row)]
    if apart:
        print(f"lives.py: best over second best of {options.lives} runs: median {statistics.median(apart):.2f}, "
              f"greatest {max(apart):.2f}", file=sys.stderr)


if __name__ == "__main__":
    main()
