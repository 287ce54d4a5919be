#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""lives.py - the speeds that a program prints, as medians over several lives of its libraries

    lives.py [--lives N] PROGRAM [ARGUMENT]...

runs PROGRAM, which prints CSV (bench --csv, say), N times, one after the other, and prints its lines once: texts and whole numbers as
they are, which must agree, and the median of each number with a decimal point. On stderr: how far apart the runs' numbers lie.

What else happens on a machine for some minutes moves one life only. Besides, where the pages of a shared object lie in memory can
move its speed, and a file stays where it is as long as the system caches it. So each time, all libraries that take part are copied to
a folder of their own: that of build/, Embree, and another build of the library after --against.
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


def median_of(values):
    """Of one cell in all runs."""
    if not all(re.fullmatch(r"\d+\.\d+", value) for value in values):
        if len(set(values)) > 1:
            sys.exit(f"lives.py: runs disagree: {values}")
        return values[0]
    decimals = len(values[0].split(".")[1])
    return f"{statistics.median(map(float, values)):.{decimals}f}"


def spread_of(values):
    """The greatest over the least, or None for what is no speed."""
    numbers = [float(value) for value in values if re.fullmatch(r"\d+\.\d+", value)]
    return max(numbers) / min(numbers) if numbers and min(numbers) > 0 else None


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].strip())
    parser.add_argument("--lives", type=int, default=3)
    parser.add_argument("program")
    parser.add_argument("arguments", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    runs = [run_copy(options.program, options.arguments) for _ in range(options.lives)]
    if len({len(run) for run in runs}) > 1:
        sys.exit("lives.py: runs print different numbers of lines")
    rows = list(zip(*runs))
    writer = csv.writer(sys.stdout, lineterminator="\n")
    spreads = []
    for row in rows:
        cells = list(zip(*row))
        writer.writerow(median_of(cell) for cell in cells)
        spreads += [spread for spread in map(spread_of, cells) if spread]
    if spreads:
        print(f"lives.py: greatest over least of {options.lives} runs: median {statistics.median(spreads):.2f}, "
              f"greatest {max(spreads):.2f}", file=sys.stderr)


if __name__ == "__main__":
    main()
