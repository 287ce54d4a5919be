#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""check_lives.py - lives.py prints the best of each number, shadows alone by two of them, and stops where runs disagree

    check_lives.py PATH_OF_LIVES

The program that it runs is this script: each time it is called with a file, it prints the next rows of that file as CSV.
"""
import os
import subprocess
import sys
import tempfile


def print_next_rows(path):
    with open(path, encoding="ascii") as file:
        first, *others = file.read().splitlines()
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(others))
    print("scene,kind,count,mrays,peer_mrays")
    print(first.replace(";", "\n"))


def run_lives(lives, rows):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "rows")
        with open(path, "w", encoding="ascii") as file:
            file.write("\n".join(rows))
        return subprocess.run([sys.executable, lives, "--lives", str(len(rows)), sys.executable, __file__, "--row", path],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)


def main():
    if sys.argv[1] == "--row":
        print_next_rows(sys.argv[2])
        return
    best = run_lives(sys.argv[1], ["room,sun,16,5.0,2.0", "room,sun,16,1.00,8.0", "room,sun,16,4.0,0.0"])
    assert best.stdout == "scene,kind,count,mrays,peer_mrays\nroom,sun,16,5.0,8.0\n", best
    assert "median 2.62, greatest 4.00" in best.stderr, best.stderr  # 5/4 and 8/2
    # The first life has the best frame, the second the best lit frame: neither's difference is the one wanted.
    shadows = run_lives(sys.argv[1], ["room,frame,16,4.0,1.0;room,lit,16,1.0,1.0;room,lit-frame,16,1.333,0.0",
                                      "room,frame,16,2.1,1.0;room,lit,16,2.0,0.5;room,lit-frame,16,42.0,1.0"])
    assert shadows.stdout.endswith("\nroom,frame,16,4.0,1.0\nroom,lit,16,2.0,1.0\nroom,lit-frame,16,4.000,0.000\n"), shadows
    for rows in (["room,sun,16,1.0,1.0", "hall,sun,16,1.0,1.0"], ["room,sun,16,1.0,1.0", "room,sun,15,1.0,1.0"]):
        disagreement = run_lives(sys.argv[1], rows)
        assert disagreement.returncode != 0 and disagreement.stdout.count("\n") < 2, disagreement
    print("check_lives.py: the best of each is right, shadows alone as well, and runs that disagree are refused")


main()
