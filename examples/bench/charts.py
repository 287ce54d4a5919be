#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""charts.py - draws what the bench program measured

    charts.py DATA OUTPUT

reads DATA/bench-avx2.csv, DATA/bench-triangles.csv and DATA/bench-resolution.csv, those of them that exist, as `bench
--csv` and `bench --study ...` print them, and writes OUTPUT/speed-scenes.png, -triangles.png and -resolution.png.

Only lines of one thread are drawn. Colours: M. Okabe, K. Ito, "Color Universal Design", 2008, as in ../study/charts.py.
"""
import csv
import os
import sys

import matplotlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
import stamp

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

BLUE, BLACK, GREY = "#0072B2", "#000000", "#777777"

KINDS = {
    "frame": "frame: rays made, traced, shaded",
    "lit": "lit: and shadow rays to a light",
    "primary": "primary: rays made, traced",
    "shadow": "shadow: light to hits",
    "sun": "sun: hits in one direction",
    "array": "array: camera rays in rows",
    "list": "list: the same, no rows given",
    "parallel": "parallel: camera rays of one direction, in rows",
    "bounce": "bounce: diffuse rays",
    "reach": "reach: hits to light, records",
    "mirror": "mirror: reflections, records",
    "lens": "lens: origins on a lens",
    "one-way": "one-way: occlusion in one direction, records",
    "hemisphere": "hemisphere: 16 rays of occlusion from each hit",
    "record": "record: camera rays, full records",
    "samples": "samples: four for each pixel, a list",
    "curve": "curve: camera rays along a Morton curve",
    "panorama": "panorama: all around, a list",
    "area": "area: hits to a light with an extent, a list",
    "single": "single: a call per ray",
    "single-any": "single-any: a call per ray, any hit",
}

WHO = [("mrays", "mlrt, exact", BLUE, 2.6), ("embree_fast_mrays", "Embree 3 fast", BLACK, 1.4),
       ("embree_robust_mrays", "Embree 3 robust", GREY, 1.4)]

ISAS = {"avx512": "both with AVX-512", "avx2": "AVX2", "sse": "SSE2", "auto": "widest vectors"}

FAMILY_DASHES, DASH_NAMES = ["-", "--", ":", "-."], ["solid", "dashed", "dotted", "dash-dotted"]


def read(path):
    if not os.path.exists(path):
        return []
    with open(path, newline="") as file:
        return [row for row in csv.DictReader(file) if row["threads"] == "1"]


def in_order(rows, column):
    return list(dict.fromkeys(row[column] for row in rows))


def rate(row, column):
    value = float(row[column])
    return value if value > 0 else None


def plain_ticks(axis, subs=(1, 2, 5)):
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


MACHINE = [""]  # what the data of the chart were measured on, in its corner


def finish(figure, path):
    figure.text(0.995, 0.006, MACHINE[0], ha="right", fontsize=7, color="0.5")
    figure.savefig(path, dpi=110)
    plt.close(figure)
    print(path)


def legend_below(figure, handles):
    figure.legend(handles=handles, loc="lower center", ncol=6, frameon=False, fontsize=9.5)


# ---- scenes ----------------------------------------------------------------------------------------------------------

def best_row(rows, scene, kind):
    found = [row for row in rows if row["scene"] == scene and row["kind"] == kind]
    return max(found, key=lambda row: float(row["mrays"])) if found else None


def draw_ratios(axes, rows, scenes, kind):
    for number, scene in enumerate(scenes):
        row = best_row(rows, scene, kind)
        if not row or not rate(row, "embree_fast_mrays"):
            continue
        fast, robust = (rate(row, "mrays") / rate(row, column) for column in ("embree_fast_mrays", "embree_robust_mrays"))
        axes.plot([1, fast], [number, number], color=BLUE, linewidth=1.2, zorder=2)
        axes.plot(fast, number, "o", color=BLACK, markersize=6, zorder=4)
        axes.plot(robust, number, "s", color=GREY, markersize=5, markerfacecolor="white", zorder=3)
        axes.text(0.97, number, f"{fast:.2f}", transform=axes.get_yaxis_transform(), va="center", ha="right", fontsize=8)


def draw_scenes(rows, path):
    scenes, kinds = in_order(rows, "scene"), [kind for kind in KINDS if kind in in_order(rows, "kind")]
    columns = min(3, len(kinds))
    lines = -(-len(kinds) // columns)
    figure, grid = plt.subplots(lines, columns, squeeze=False, sharex=True, sharey=True,
                                figsize=(4.6 * columns + 1.2, (0.26 * len(scenes) + 1.1) * lines + 1.0))
    cells = [axes for row in grid for axes in row]
    for axes, kind in zip(cells, kinds):
        draw_ratios(axes, rows, scenes, kind)
        axes.set_xscale("log")
        plain_ticks(axes.xaxis)
        axes.axvline(1, color=BLACK, linewidth=0.8)
        axes.grid(axis="x", color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.set_title(KINDS[kind], fontsize=10.5)
    cells[0].set_yticks(range(len(scenes)), scenes)
    cells[0].set_ylim(len(scenes) - 0.4, -0.6)
    low, high = cells[0].get_xlim()
    cells[0].set_xlim(low, high * (high / low) ** 0.18)
    for axes in cells[len(kinds):]:
        axes.axis("off")
    for axes in cells[len(kinds) - columns:len(kinds)]:
        axes.tick_params(labelbottom=True)
    legend_below(figure, [Line2D([], [], linestyle="", marker="o", color=BLACK, label="mlrt / Embree 3 fast (the number)"),
                          Line2D([], [], linestyle="", marker="s", color=GREY, markerfacecolor="white",
                                 label="mlrt / Embree 3 robust")])
    figure.suptitle("Speed of mlrt, whose answers are exact, to that of Embree 3 on the same rays, one thread, both with "
                    f"{ISAS[rows[0]['isa']]}. Right of 1, mlrt is faster", fontsize=12)
    figure.tight_layout(rect=(0, 0.42 / figure.get_figheight(), 1, 0.99))
    finish(figure, path)


# ---- triangles and resolution ----------------------------------------------------------------------------------------

def draw_lines(axes, rows, column, dash):
    for name, _, colour, width in WHO:
        points = [(float(row[column]), 1000 / rate(row, name)) for row in rows if rate(row, name)]
        points.sort()
        axes.plot([x for x, _ in points], [y for _, y in points], dash, color=colour, linewidth=width, marker="o",
                  markersize=3, zorder=4 if colour == BLUE else 3)


def dress(axes, title, label):
    axes.set_xscale("log")
    axes.set_yscale("log")
    plain_ticks(axes.yaxis)
    axes.grid(True, color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_title(title, fontsize=10.5)
    axes.set_xlabel(label)


def who_handles():
    return [Line2D([], [], color=colour, linewidth=width, label=title) for _, title, colour, width in WHO]


def draw_triangles(rows, path):
    kinds = [kind for kind in KINDS if kind in in_order(rows, "kind")]
    families = list(dict.fromkeys(row["scene"].split(":")[0] for row in rows))
    figure, panels = plt.subplots(1, len(kinds), squeeze=False, figsize=(5.6 * len(kinds) + 0.6, 5))
    for axes, kind in zip(panels[0], kinds):
        for family, dash in zip(families, FAMILY_DASHES):
            draw_lines(axes, [r for r in rows if r["kind"] == kind and r["scene"].split(":")[0] == family], "triangles", dash)
        dress(axes, KINDS[kind], "triangles")
    panels[0][0].set_ylabel("nanoseconds per ray")
    legend_below(figure, who_handles() + [Line2D([], [], color="none", label=f"{name}: {family}")
                                          for family, name in zip(families, DASH_NAMES)])
    size = rows[0]["size"]
    figure.suptitle(f"Time per ray and the number of triangles, {size} x {size} pixels, one thread, {ISAS[rows[0]['isa']]}", fontsize=12)
    figure.tight_layout(rect=(0, 0.07, 1, 0.99))
    finish(figure, path)


def draw_resolution(rows, path):
    scenes, kinds = in_order(rows, "scene"), [kind for kind in KINDS if kind in in_order(rows, "kind")]
    sizes = sorted({int(row["size"]) for row in rows})
    figure, grid = plt.subplots(len(kinds), len(scenes), squeeze=False, sharey=True,
                                figsize=(3.4 * len(scenes) + 0.8, 3.8 * len(kinds) + 0.8))
    for line, kind in zip(grid, kinds):
        for axes, scene in zip(line, scenes):
            draw_lines(axes, [r for r in rows if r["kind"] == kind and r["scene"] == scene], "size", "-")
            dress(axes, f"{scene}, {kind}", "pixels per side")
            axes.set_xticks(sizes, [str(size) for size in sizes], fontsize=8)
            axes.xaxis.set_minor_formatter(NullFormatter())
        line[0].set_ylabel("nanoseconds per ray")
    legend_below(figure, who_handles())
    figure.suptitle(f"Time per ray and resolution, one thread, {ISAS[rows[0]['isa']]}", fontsize=12)
    figure.tight_layout(rect=(0, 0.35 / figure.get_figheight(), 1, 0.99))
    finish(figure, path)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    data, output = sys.argv[1:]
    for name, draw, chart in (("bench-avx2", draw_scenes, "scenes"), ("bench-triangles", draw_triangles, "triangles"),
                              ("bench-resolution", draw_resolution, "resolution")):
        table, picture = os.path.join(data, name + ".csv"), os.path.join(output, f"speed-{chart}.png")
        rows = read(table)
        if rows:
            MACHINE[0] = stamp.machine_of(table)
            draw(rows, picture)
            stamp.stamp(picture, [table])


if __name__ == "__main__":
    main()
