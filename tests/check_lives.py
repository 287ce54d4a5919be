#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""check_lives.py - lives.py prints the median of each number, and stops where runs disagree

    check_lives.py PATH_OF_LIVES

The program that it runs is this script: each time it is called with a file, it prints the next row of that file as CSV.
"""
import os
import subprocess
import sys
import tempfile


def print_next_row(path):
    with open(path, encoding="ascii") as file:
        first, *others = file.read().splitlines()
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(others))
    print("scene,count,mrays")
    print(first)


def run_lives(lives, rows):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "rows")
        with open(path, "w", encoding="ascii") as file:
            file.write("\n".join(rows))
        return subprocess.run([sys.executable, lives, "--lives", str(len(rows)), sys.executable, __file__, "--row", path],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)


def main():
    if sys.argv[1] == "--row":
        print_next_row(sys.argv[2])
        return
    medians = run_lives(sys.argv[1], ["room,16,5.0", "room,16,1.00", "room,16,2.0"])
    assert medians.stdout == "scene,count,mrays\nroom,16,2.0\n", medians
    assert "median 5.00, greatest 5.00" in medians.stderr, medians.stderr
    for rows in (["room,16,1.0", "hall,16,1.0"], ["room,16,1.0", "room,15,1.0"]):
        disagreement = run_lives(sys.argv[1], rows)
        assert disagreement.returncode != 0 and disagreement.stdout.count("\n") < 2, disagreement
    print("check_lives.py: medians are right, and runs that disagree are refused")


main()
