#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The layers of src (docs/design.md, "The house"): check_layers.py COMPILER [FLAG...]

Reads every #include of src and fails if
  - a file includes one of a folder above its own, or beside it (LAYERS);
  - files include each other in a circle;
  - a file that is not compiled once per instruction set includes text that is (UNITS);
  - a header does not compile alone, as it is found: with what it includes, and nothing before it;
  - a struct has more members than anyone keeps in mind (MEMBERS), and no parts;
  - a line is wider than COLUMNS, as comments can be, which the formatter leaves as they are.
"""
import os
import re
import subprocess
import sys

# From the top down; folders of one line lie side by side, and know nothing of each other.
LAYERS = [
    ["api"],
    ["run"],
    ["isa"],
    ["trace", "mlrta"],
    ["hits"],
    ["job"],
    ["rays", "bvh"],
    ["scene"],
    ["exact"],
    ["simd"],
    ["base"],
]

MEMBERS = 12
COLUMNS = 120

# What is compiled once per instruction set; what includes CHOSEN is text for them.
UNITS = ["isa/scalar.c", "isa/neon.c", "isa/sse.c", "isa/avx2.c", "isa/avx512.c"]
CHOSEN = "simd/simd.h"

# Headers that need an instruction set.
FLAGS = {
    "simd/quad_sse.h": ["-msse2"],
    "simd/sse.h": ["-msse2"],
    "simd/avx2.h": ["-mavx2", "-mfma"],
    "simd/avx512.h": ["-mavx512f", "-mavx512dq", "-mfma"],
    "simd/intrinsics.h": ["-msse2", "-include", "simd/sse.h"],
}

SOURCE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "src")
LEVEL = {folder: level for level, folders in enumerate(LAYERS) for folder in folders}


def read_includes():
    """Of every file, the files of src that it includes."""
    includes = {}
    for folder in sorted(os.listdir(SOURCE)):
        path = os.path.join(SOURCE, folder)
        for file in sorted(os.listdir(path)) if folder in LEVEL else []:
            if file.endswith((".c", ".h")):
                with open(os.path.join(path, file), encoding="utf-8") as text:
                    includes[f"{folder}/{file}"] = re.findall(r'^\s*#\s*include\s+"(.*?)"', text.read(), re.M)
    return includes


def find_strays(includes):
    """Files that no layer has, and names that are no files of src."""
    for folder in sorted(os.listdir(SOURCE)):
        path = os.path.join(SOURCE, folder)
        if folder not in LEVEL and (not os.path.isdir(path) or any(f.endswith((".c", ".h")) for f in os.listdir(path))):
            if not folder.endswith(".py"):
                yield f"src/{folder}: of no layer"
    for file, names in includes.items():
        for name in names:
            if name not in includes and name != "mlrt.h":
                yield f'{file}: "{name}" is no file of src, by its path from there'


def find_arrows(includes):
    """Includes that do not point down."""
    for file, names in includes.items():
        own = file.split("/")[0]
        for name in names:
            other = name.split("/")[0]
            if name in includes and other != own and LEVEL[other] <= LEVEL[own]:
                yield f"{file} -> {name}"


def find_circles(includes):
    """Circles of files, a .c with its .h as one, each as the files along it."""
    parts = {}
    for file, names in includes.items():
        parts.setdefault(file[:-2], set()).update(name[:-2] for name in names if name[:-2] != file[:-2])
    done, path = set(), []

    def visit(file):
        if file in path:
            yield path[path.index(file) :] + [file]
        if file in done or file in path:
            return
        path.append(file)
        for name in sorted(parts.get(file, [])):
            yield from visit(name)
        path.pop()
        done.add(file)

    for file in parts:
        yield from visit(file)


def find_leaks(includes):
    """Files compiled once that include text for instruction sets."""
    reach = {}

    def reaches(file):
        if file not in reach:
            reach[file] = False  # a circle ends here
            reach[file] = file == CHOSEN or any(reaches(name) for name in includes.get(file, []))
        return reach[file]

    for file, names in includes.items():
        if file.endswith(".c") and file not in UNITS:
            for name in names:
                if reaches(name):
                    yield f"{file}: {name} is text for instruction sets"


def find_crowds(includes):
    """Structs of too many members; a part counts as one."""
    for file in includes:
        with open(os.path.join(SOURCE, file), encoding="utf-8") as text:
            code = re.sub(r"/\*.*?\*/|//[^\n]*", "", text.read(), flags=re.S)
        for begin in re.finditer(r"\b(?:struct|union)\s*(\w*)\s*\{", code):
            depth, own = 1, ""
            for character in code[begin.end() :]:
                depth += {"{": 1, "}": -1}.get(character, 0)
                if depth == 0:
                    break
                own += character if depth == 1 else ""
            bare = re.sub(r"\([^()]*\)", "", re.sub(r"\[[^\]]*\]|\([^()]*\)", "", own))
            members = sum(1 + line.count(",") for line in bare.split(";") if line.strip())
            if members > MEMBERS:
                yield f"{file}: {begin.group(1) or 'a struct'} has {members} members, more than {MEMBERS}"


def find_wide_lines(includes):
    """Lines of too many columns."""
    for file in includes:
        with open(os.path.join(SOURCE, file), encoding="utf-8") as text:
            for number, line in enumerate(text, 1):
                if len(line.rstrip("\n")) > COLUMNS:
                    yield f"{file}:{number}: {len(line) - 1} columns, more than {COLUMNS}"


def compile_alone(header, compiler):
    """The compiler's first words, or none."""
    flags = FLAGS.get(header, [])
    command = compiler + ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wno-unused", "-fsyntax-only"]
    command += [f"-I{SOURCE}", f"-I{os.path.join(os.path.dirname(SOURCE), 'include')}"] + flags
    if flags and subprocess.run(command + ["-x", "c", os.devnull], capture_output=True).returncode:
        return ""  # another processor
    # By #include, so that it is a header to the compiler.
    result = subprocess.run(command + ["-x", "c", "-"], input=f'#include "{header}"\n', capture_output=True, text=True)
    errors = [line for line in result.stderr.splitlines() if "error" in line]
    return (errors + [result.stderr or "?"])[0] if result.returncode else ""


def main():
    compiler = sys.argv[1:] or ["cc"]
    includes = read_includes()
    wrong = list(find_strays(includes))
    wrong += [f"arrow upward: {arrow}" for arrow in find_arrows(includes)]
    wrong += ["circle: " + " -> ".join(circle) for circle in find_circles(includes)]
    wrong += list(find_leaks(includes)) + list(find_crowds(includes)) + list(find_wide_lines(includes))
    headers = [file for file in includes if file.endswith(".h")]
    for header in headers:
        words = compile_alone(header, compiler)
        if words:
            wrong.append(f"{header} does not compile alone: {words}")
    if wrong:
        sys.exit("check-layers:\n" + "\n".join(wrong))
    print(f"check-layers: {len(includes)} files in {len(LEVEL)} folders, no arrow upward, no circle; "
          f"{len(headers)} headers compile alone; no struct over {MEMBERS} members")


if __name__ == "__main__":
    main()
