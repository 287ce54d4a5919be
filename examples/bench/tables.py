#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tables.py - keeps the tables of documents equal to what the bench program measured

    tables.py [--check] DATA FILE...

rewrites each table of the Markdown files that stands between two lines

    <!-- table: NAME.csv WHAT KIND... -->
    <!-- end of table -->

from DATA/NAME.csv. WHAT is one of

    ratio       the library's speed over that of Embree's fast mode; a row for each kind, a column for each scene
    gain        the library's speed over that of the build that it was run against (bench --against); likewise
    mrays, embree_fast_mrays, embree_robust_mrays
                millions of rays per second; likewise
    ratio,gain  two of these in each cell, the second in brackets
    all         ratio and millions of rays per second, of one kind: a row for each scene
    settings    what sweep.py wrote: a row for each setting, a column for each kind and scene
    costs       of bench --study costs, by one instruction set in place of a kind: a row for each setting; for each
                scene, over the default tree, the geometric mean of all kinds, and in brackets the least of them
    builds      of bench --study build, with as many threads as the number in place of a kind: for each scene seconds
                and bytes per triangle of each builder (one thread: processor time), and ratios
    spread      a row for each kind: the least, the median and the greatest `ratio` of all scenes. NAME may be
                several, NAME.csv=TITLE,NAME.csv=TITLE,...: side by side

A kind is the bench's, or KIND=TITLE with _ for spaces. With --check nothing is written, and the exit status is 1 if
something would be.
"""
import csv
import os
import re
import statistics
import sys

BLOCK = re.compile(r"(<!-- table: (\S+) (\S+) ([^>]*?) -->\n).*?(<!-- end of table -->)", re.S)
RATES = ("mrays", "embree_fast_mrays", "embree_robust_mrays")


def read(path, threads="1"):
    with open(path, newline="") as file:
        return [row for row in csv.DictReader(file) if row.get("threads", "1") == threads]


def in_order(rows, column):
    return list(dict.fromkeys(row[column] for row in rows))


def show_speed(row, column):
    rate = float(row[column])
    return f"{rate:.0f}" if rate >= 100 else f"{rate:.1f}"


def show_ratio(row):
    rate, peer = float(row["mrays"]), float(row["embree_fast_mrays"])
    return f"{rate / peer:.2f}" if rate > 0 and peer > 0 else ""


def show_gain(row):
    rate, old = float(row["mrays"]), float(row.get("old_mrays") or 0)
    return f"{rate / old:.2f}" if rate > 0 and old > 0 else ""


def show_cell(row, what):
    shows = {"ratio": show_ratio, "gain": show_gain}
    first, *rest = [shows[part](row) if part in shows else show_speed(row, part) for part in what.split(",")]
    return " ".join([first] + [f"({text})" for text in rest if text]).strip()


def table(head, body):
    rows = [head, ["---"] + ["---:"] * (len(head) - 1)] + body
    return "".join("| " + " | ".join(row) + " |\n" for row in rows)


def table_of_kinds(rows, titles, what):
    found = {(row["scene"], row["kind"]): row for row in rows}
    scenes = in_order(rows, "scene")
    body = [[title] + [show_cell(found[scene, kind], what) if (scene, kind) in found else "" for scene in scenes]
            for kind, title in titles.items()]
    return table(["kind"] + scenes, body)


def table_of_all(rows, kind):
    body = [[row["scene"]] + [show_speed(row, column) for column in RATES] + [show_ratio(row)]
            for row in rows if row["kind"] == kind]
    return table(["scene", "mlrt", "Embree fast", "robust", "/ fast"], body)


def table_of_settings(rows, titles):
    found = {(row["setting"], row["kind"], row["scene"]): f"{float(row['over_as_it_is']):.2f}" for row in rows}
    columns = [(kind, scene) for kind in titles for scene in in_order(rows, "scene")]
    first = in_order(rows, "scene")[0]
    head = [f"{titles[kind]}: {scene}" if scene == first else scene for kind, scene in columns]
    body = [[setting] + [found[setting, kind, scene] for kind, scene in columns] for setting in in_order(rows, "setting")]
    return table(["setting"] + head, body)


def table_of_costs(rows, isa):
    scenes, settings = in_order(rows, "scene"), in_order(rows, "setting")

    def cell(setting, scene):
        ratios = [float(row["over_default"]) for row in rows
                  if (row["setting"], row["scene"], row["isa"]) == (setting, scene, isa)]
        return f"{statistics.geometric_mean(ratios):.2f} ({min(ratios):.2f})" if ratios else ""

    return table(["setting"] + scenes, [[setting] + [cell(setting, scene) for scene in scenes] for setting in settings])


BUILDERS = {"fast": "mlrt_fast", "default": "mlrt", "best": "mlrt_best", "Embree medium": "embree_fast_medium",
            "Embree high": "embree_fast_high"}


def table_of_builds(rows, threads):
    clock = "processor_seconds" if threads == "1" else "seconds"
    found = {(row["scene"], row["builder"]): row for row in rows}

    def line(scene):
        cells = [found[scene, builder] for builder in BUILDERS.values()]
        seconds = [float(cell[clock]) for cell in cells]
        times = [f"{time:.3g} s, {float(cell['bytes_per_triangle']):.0f} B" for time, cell in zip(seconds, cells)]
        return [scene] + times + [f"{seconds[0] / seconds[3]:.2f}", f"{seconds[1] / seconds[4]:.2f}"]

    head = ["scene"] + list(BUILDERS) + ["fast / medium", "default / high"]
    return table(head, [line(scene) for scene in in_order(rows, "scene")])


def table_of_spreads(data, names, titles):
    head, columns = ["rays"], []
    for name in names.split(","):
        file, _, title = name.partition("=")
        head += [f"{title}: least", "median", "greatest"]
        columns.append(read(os.path.join(data, file)))

    def spread(rows, kind):
        ratios = [float(row["mrays"]) / float(row["embree_fast_mrays"]) for row in rows
                  if row["kind"] == kind and float(row["embree_fast_mrays"]) > 0]
        return [f"{value:.2f}" for value in (min(ratios), statistics.median(ratios), max(ratios))] if ratios else [""] * 3

    return table(head, [[title] + sum((spread(rows, kind) for rows in columns), []) for kind, title in titles.items()])


def make_table(data, name, what, titles):
    if what == "spread":
        return table_of_spreads(data, name, titles)
    if what == "builds":
        return table_of_builds(read(os.path.join(data, name), *titles), *titles)
    rows = read(os.path.join(data, name))
    if what == "costs":
        return table_of_costs(rows, *titles)
    if what == "all":
        return table_of_all(rows, *titles)
    if what == "settings":
        return table_of_settings(rows, titles)
    return table_of_kinds(rows, titles, what)


def renew(text, data):
    def replace(block):
        begin, name, what, kinds, end = block.groups()
        titles = {kind.split("=")[0]: kind.split("=")[-1].replace("_", " ") for kind in kinds.split()}
        return begin + make_table(data, name, what, titles) + end

    return BLOCK.sub(replace, text)


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--check"]
    is_check = len(arguments) < len(sys.argv) - 1
    if len(arguments) < 2:
        sys.exit(__doc__)
    status = 0
    for path in arguments[1:]:
        with open(path) as file:
            old = file.read()
        new = renew(old, arguments[0])
        if new == old:
            continue
        print(f"{path}: tables {'are not those of' if is_check else 'renewed from'} {arguments[0]}")
        if is_check:
            status = 1
            continue
        with open(path, "w") as file:
            file.write(new)
    sys.exit(status)


if __name__ == "__main__":
    main()
