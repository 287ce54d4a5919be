#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Breaks rules of the library one at a time, and shows the test that fails: mutants.py [--csv] FOLDER [WORD...]

tests/mutants.txt has the changes. Each is made in a copy of the sources in FOLDER, whose kernels are compiled in plain C;
then the test that it names must fail. With words, only changes whose title has one of them are made. JOBS copies are
worked on at a time (default: one per processor).

One line for each change, as CSV with --csv. Exit status 1: a test that passes in spite of its change, a change whose old
lines are not in the file exactly once, or one that does not compile.
"""
import argparse
import csv
import os
import queue
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
COPIED = ["Makefile", "include", "src", "tests", "examples"]
TIMEOUT = 600  # seconds: a change may make a loop endless


class Mistake(Exception):
    pass


class Mutant:
    def __init__(self, part, title):
        self.part, self.title = part, title
        self.program = self.test = None
        self.hunks = []  # [file, old lines, new lines]


def read_table(path):
    """The mutants of the table: "## part", "# change", "test: PROGRAM TEST", "in: FILE", old lines behind "-", new ones
    behind "+"."""
    mutants, part = [], None
    with open(path) as file:
        for number, line in enumerate(file, 1):
            line = line.rstrip("\n")
            last = mutants[-1] if mutants else None
            if line.startswith("## "):
                part = line[3:]
            elif line.startswith("# "):
                mutants.append(Mutant(part, line[2:]))
            elif line.startswith("test: "):
                last.program, last.test = line[6:].split()
            elif line.startswith("in: "):
                last.hunks.append([line[4:], [], []])
            elif line[:1] in ("-", "+"):
                last.hunks[-1][1 if line[0] == "-" else 2].append(line[1:])
            elif line and not line.startswith("//"):
                raise Mistake(f"{path}:{number}: {line}")
    for mutant in mutants:
        if not mutant.test or not mutant.hunks:
            raise Mistake(f"{mutant.title}: no test, or no change")
    return mutants


# ---- copies ------------------------------------------------------------------------------------------------------------


def read_bytes(path):
    with open(path, "rb") as file:
        return file.read()


def write_if_new(path, contents):
    """Leaves the times of files that stay as they are, so that make builds what changed."""
    if os.path.exists(path) and read_bytes(path) == contents:
        return
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(contents)


def copy_sources(copy):
    for name in COPIED:
        top = os.path.join(ROOT, name)
        folders = os.walk(top) if os.path.isdir(top) else [(ROOT, [], [name])]
        for folder, _, files in folders:
            for file in files:
                path = os.path.join(folder, file)
                write_if_new(os.path.join(copy, os.path.relpath(path, ROOT)), read_bytes(path))


def build(copy, programs):
    """None, or what the compiler says."""
    targets = [f"build/scalar/tests/{program}" for program in programs]
    # Not make's own variables of a calling make, which would name other folders.
    environment = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    made = subprocess.run(["make", "-C", copy, "SCALAR=1", "OPTIMIZE=-O1", "CFLAGS=", *targets], env=environment,
                          capture_output=True, text=True)
    return None if made.returncode == 0 else made.stderr


def fails(copy, program, test):
    """1 if the test fails, 0 if it passes."""
    environment = dict(os.environ, ONE_TEST=test)
    try:
        run = subprocess.run([f"build/scalar/tests/{program}"], cwd=copy, env=environment, timeout=TIMEOUT,
                             capture_output=True, text=True, errors="replace")
    except subprocess.TimeoutExpired:
        return 1
    if "Running 1 test(s)" not in run.stdout + run.stderr:
        raise Mistake(f"{program} has no test {test}")
    return run.returncode != 0


# ---- one change ----------------------------------------------------------------------------------------------------------


def changed_text(mutant, file, old_lines, new_lines, text):
    old, new = ("".join(line + "\n" for line in lines) for lines in (old_lines, new_lines))
    if not old or ("\n" + text).count("\n" + old) != 1:
        raise Mistake(f"{mutant.title}: {file} does not have the old lines exactly once")
    return ("\n" + text).replace("\n" + old, "\n" + new, 1)[1:]


def apply(mutant, copy):
    texts = {}
    for file, old_lines, new_lines in mutant.hunks:
        text = texts.get(file) or read_bytes(os.path.join(ROOT, file)).decode()
        texts[file] = changed_text(mutant, file, old_lines, new_lines, text)
    for file, text in texts.items():
        write_if_new(os.path.join(copy, file), text.encode())


def restore(mutant, copy):
    for file, _, _ in mutant.hunks:
        write_if_new(os.path.join(copy, file), read_bytes(os.path.join(ROOT, file)))


def try_mutant(mutant, copies):
    """What became of it: "caught", "survived", or a mistake of the table."""
    copy = copies.get()
    try:
        apply(mutant, copy)
        wrong = build(copy, [mutant.program])
        if wrong:
            return f"does not compile: {wrong}"
        return "caught" if fails(copy, mutant.program, mutant.test) else "survived"
    except Mistake as mistake:
        return str(mistake)
    finally:
        restore(mutant, copy)
        copies.put(copy)


def prepare(copy, mutants):
    copy_sources(copy)
    wrong = build(copy, sorted({mutant.program for mutant in mutants}))
    if wrong:
        raise Mistake(wrong)


def check_tests(copy, mutants):
    """Without any change, each test must pass."""
    for program, test in sorted({(mutant.program, mutant.test) for mutant in mutants}):
        if fails(copy, program, test):
            raise Mistake(f"{program}: {test} fails without any change")


def main(arguments):
    mutants = [mutant for mutant in read_table(os.path.join(ROOT, "tests", "mutants.txt"))
               if not arguments.words or any(word in mutant.title for word in arguments.words)]
    jobs = int(os.environ.get("JOBS") or os.cpu_count())
    copies = queue.Queue()
    writer = csv.writer(sys.stdout, lineterminator="\n")
    if arguments.csv:
        writer.writerow(["part", "change", "test", "result"])
    caught = 0
    with ThreadPoolExecutor(jobs) as pool:
        paths = [os.path.join(os.path.abspath(arguments.folder), str(job)) for job in range(jobs)]
        for path in pool.map(lambda path: prepare(path, mutants) or path, paths):
            copies.put(path)
        check_tests(paths[0], mutants)
        for mutant, result in zip(mutants, pool.map(lambda mutant: try_mutant(mutant, copies), mutants)):
            caught += result == "caught"
            if arguments.csv:
                writer.writerow([mutant.part, mutant.title, f"{mutant.program}: {mutant.test}", result])
            else:
                print(f"{result:8} {mutant.part}: {mutant.title} ({mutant.program}: {mutant.test})")
            sys.stdout.flush()
    print(f"mutants: {caught} of {len(mutants)} caught", file=sys.stderr)
    return caught != len(mutants)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", action="store_true", help="a table of comma-separated values")
    parser.add_argument("folder", help="where copies of the sources are changed and built")
    parser.add_argument("words", nargs="*", help="only changes with one of these in their titles")
    try:
        sys.exit(main(parser.parse_args()))
    except Mistake as mistake:
        sys.exit(f"mutants: {mistake}")
