#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""charts.py - draws what the accuracy program measured

    charts.py DATA OUTPUT

reads DATA/methods.csv, DATA/stability.csv and DATA/stages.csv as `accuracy --csv` prints them, DATA/price.csv as `bench
--csv --against` prints it, and DATA/pays.csv as `pays --csv` prints it, those of them that exist, and writes
OUTPUT/accuracy-summary.png, -speed.png, -stability.png, -stages.png, -price.png, and OUTPUT/depth-pays.png.

An axis of wrong decisions is logarithmic and ends in a grey band for "none among the rays asked". Within the band
a method has a place of its own, so that lines and marks do not hide each other; the place means nothing else.

Colours: M. Okabe, K. Ito, "Color Universal Design", 2008; methods of one family differ in mark or dash as well.
"""
import collections
import csv
import math
import os
import sys

import matplotlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
import stamp

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

BLUE, ORANGE, GREEN, PURPLE, SKY, BLACK, GREY = "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#000000", "#777777"
RED = "#D55E00"

Style = collections.namedtuple("Style", "title colour mark filled size")

# The order is that of legends: single-ray tests in one walk, Embree, the library.
METHODS = {
    "mt_float": Style("Möller–Trumbore, float", ORANGE, "o", True, 7),
    "mt_epsilon": Style("Möller–Trumbore, float, ε = 1e-6", ORANGE, "o", False, 7),
    "mt_double": Style("Möller–Trumbore, double", ORANGE, "s", True, 7),
    "wald2004": Style("Wald 2004, float", PURPLE, "^", True, 7),
    "pluecker": Style("Plücker, float", GREEN, "v", True, 7),
    "woop2013": Style("Woop et al. 2013 (watertight), float", SKY, "P", True, 8),
    "mt_boxes": Style("Möller–Trumbore, float, over mlrt's boxes", ORANGE, "D", False, 7),
    "tinybvh": Style("tinybvh 1.6, 1 ray", GREEN, "X", True, 8),
    "embree_fast": Style("Embree 3 fast, 1 ray", BLACK, "o", True, 7),
    "embree_fast16": Style("Embree 3 fast, 16 rays", BLACK, "o", False, 7),
    "embree_robust": Style("Embree 3 robust, 1 ray", GREY, "s", True, 7),
    "embree_robust16": Style("Embree 3 robust, 16 rays", GREY, "s", False, 7),
    "guess_tile": Style("mlrt without exactness, tiles", RED, "p", False, 9),
    "guess_tile_camera": Style("mlrt without exactness, from the camera", RED, "p", True, 9),
    "mlrt_ray": Style("mlrt, 1 ray", BLUE, "o", False, 9),
    "mlrt_packet2": Style("mlrt, 2×2 packets", BLUE, "s", False, 9),
    "mlrt_packet4": Style("mlrt, 4×4 packets", BLUE, "D", True, 8),
    "mlrt_multilevel": Style("mlrt, multi-level", BLUE, "*", False, 14),
    "mlrt_camera": Style("mlrt, multi-level, from the camera", BLUE, "*", True, 14),
    "mlrt_tile": Style("mlrt, tiles", RED, "*", False, 14),
    "mlrt_tile_camera": Style("mlrt, tiles, from the camera", RED, "*", True, 14),
}

GENERATORS = {
    "camera": "picture",
    "random": "in random directions",
    "surface": "aimed at points inside triangles",
    "edge": "aimed at edges",
    "vertex": "aimed at vertices",
    "axis": "along an axis",
    "split_plane": "in a split plane",
}


def read(path):
    if not os.path.exists(path):
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def in_order(rows, column):
    return list(dict.fromkeys(row[column] for row in rows))


def thousands(count):
    return f"{count:,}".replace(",", "\u202f")


# ---- the axis of wrong decisions -------------------------------------------------------------------------------------

BAND = 1.6  # decades that the place for 0 is wide


class WrongAxis:
    """Positions on a logarithmic axis of wrong decisions per million, with a band for 0 below the smallest possible value."""

    def __init__(self, ray_counts):
        self.floor = math.floor(math.log10(1e6 / max(ray_counts)) + 1e-9)

    def place(self, wrong, share=0.5):
        """`share`, 0 .. 1: where in the band a 0 goes."""
        if wrong > 0:
            return math.log10(wrong)
        return self.floor - BAND * (0.9 - 0.8 * share)

    def dress(self, axes, vertical):
        low, high = self.floor - BAND, 6.15
        ticks = [self.floor - BAND / 2] + list(range(self.floor, 7))
        labels = ["0"] + [{0: "1", 1: "10", 2: "100"}.get(e, f"$10^{{{e}}}$") for e in range(self.floor, 7)]
        axis = axes.yaxis if vertical else axes.xaxis
        axis.set_ticks(ticks, labels)
        axis.set_minor_locator(NullLocator())
        if vertical:
            axes.set_ylim(low, high)
            axes.axhspan(low, self.floor - 0.03, color="#eeeeee", zorder=0)
        else:
            axes.set_xlim(low, high)
            axes.axvspan(low, self.floor - 0.03, color="#eeeeee", zorder=0)


MACHINE = [""]  # what the data of the chart were measured on, in its corner


def finish(figure, path):
    """Writes a chart. Its corner says where it was measured; programs of studies take the widest instruction set there is."""
    widest = MACHINE[0].rpartition("has ")[2].partition(")")[0]
    used = f": tiles, single rays and Embree with {widest}; kd-trees and tinybvh with AVX2" if widest else ""
    figure.text(0.995, 0.006, MACHINE[0] + used, ha="right", fontsize=7, color="0.5")
    figure.savefig(path, dpi=110)
    plt.close(figure)
    print(path)


# ---- in ten seconds ---------------------------------------------------------------------------------------------------

# The scene, and what a point is called: of several ways to call a library, the fastest counts.
SUMMARY_SCENE = "office"
SUMMARY = [
    ("mlrt", ["mlrt_tile_camera", "mlrt_tile"], BLUE, "*", 20),
    ("mlrt without exactness", ["guess_tile_camera", "guess_tile"], SKY, "*", 16),
    ("Embree, fast", ["embree_fast", "embree_fast16"], BLACK, "o", 10),
    ("Embree, robust", ["embree_robust", "embree_robust16"], GREY, "s", 10),
    ("tinybvh", ["tinybvh"], GREEN, "X", 11),
    ("textbook: Möller–Trumbore", ["mt_boxes"], ORANGE, "D", 9),
    ("the paper's method, exact", ["mlrt_camera", "mlrt_multilevel"], PURPLE, "^", 11),
]


LABEL_HEIGHT = 1.13  # on the logarithmic axis of the summary


def draw_summary(rows, path):
    """Speed of a picture's rays against wrong answers to rays aimed at edges, one panel."""
    def rows_of(generator, members):
        return [r for r in rows if r["scene"] == SUMMARY_SCENE and r["generator"] == generator and r["method"] in members]

    edge_rays = [int(r["rays"]) for r in rows if r["scene"] == SUMMARY_SCENE and r["generator"] == "edge"]
    axis = WrongAxis(edge_rays)
    figure, axes = plt.subplots(figsize=(8.6, 4.9))
    axis.dress(axes, vertical=False)
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="major", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    labels = []
    for title, members, colour, mark, size in SUMMARY:
        pictures, edges = rows_of("camera", members), rows_of("edge", members)
        if not pictures or not edges:
            continue
        x = axis.place(max(float(r["wrong_per_million"]) for r in edges))
        y = max(float(r["mrays"]) for r in pictures)
        axes.plot(x, y, mark, color=colour, markersize=size, zorder=3)
        labels.append((y, x, title, colour))
    lowest_free = {True: 0, False: 0}  # on each side of the chart, from the bottom up: labels do not overlap
    for y, x, title, colour in sorted(labels):
        right = x < 3
        height = max(y, lowest_free[right])
        lowest_free[right] = height * LABEL_HEIGHT
        axes.annotate(title, (x, height), xytext=(14 if right else -12, 0), textcoords="offset points", fontsize=10.5,
                      ha="left" if right else "right", va="center", color=colour)
    low, high = axes.get_ylim()
    axes.set_ylim(low / 1.3, high * 1.3)
    axes.set_ylabel("million rays per second, a picture")
    axes.set_xlabel("wrong answers per million rays aimed at edges")
    axes.set_title(f"Faster is up, more exact is left ({SUMMARY_SCENE}, one thread; grey: not one wrong answer)", fontsize=11)
    figure.tight_layout()
    finish(figure, path)


# ---- the price of exactness ------------------------------------------------------------------------------------------


def draw_price(rows, path):
    """Time of the library over time of its build without exactness, a mark for each kind of rays and scene."""
    kinds, scenes = in_order(rows, "kind"), in_order(rows, "scene")
    kinds = [kind for kind in kinds if kind != "lit-frame"]  # a difference of two measurements
    marks = "osD^v<>PX*hp"
    colours = [BLUE, ORANGE, GREEN, PURPLE, SKY, RED, BLACK, GREY]
    figure, axes = plt.subplots(figsize=(13, 5))
    axes.axhline(1, color="#888888", linewidth=1)
    axes.axhspan(1, 1.08, color="#e8f2e8", zorder=0)
    for s, scene in enumerate(scenes):
        for k, kind in enumerate(kinds):
            for row in rows:
                if row["scene"] != scene or row["kind"] != kind or float(row["mrays"]) <= 0:
                    continue
                ratio = float(row["old_mrays"]) / float(row["mrays"])
                axes.plot(k + (s - (len(scenes) - 1) / 2) * 0.08, ratio, marks[s % len(marks)], color=colours[s % len(colours)],
                          markersize=6)
    axes.set_xticks(range(len(kinds)), kinds, rotation=30, ha="right")
    axes.set_ylabel("time, exact / guessing")
    axes.grid(True, axis="y", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    handles = [Line2D([], [], linestyle="", marker=marks[s % len(marks)], color=colours[s % len(colours)], label=scene)
               for s, scene in enumerate(scenes)]
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes.set_title("The price of exactness: time of each kind of rays over that of a build that guesses (band: up to 8 %)", fontsize=11)
    figure.tight_layout()
    finish(figure, path)


# ---- speed against wrong decisions -----------------------------------------------------------------------------------


def draw_speed(rows, path):
    scenes, generators = in_order(rows, "scene"), in_order(rows, "generator")
    present = [name for name in METHODS if any(row["method"] == name for row in rows)]
    figure, grid = plt.subplots(len(generators), len(scenes), squeeze=False, sharex="row", sharey="row",
                                figsize=(max(12, 2.75 * len(scenes) + 1.2), 3.4 * len(generators) + 1.5))
    for i, generator in enumerate(generators):
        of_row = [row for row in rows if row["generator"] == generator]
        axis = WrongAxis([int(row["rays"]) for row in of_row])
        for j, scene in enumerate(scenes):
            axes = grid[i][j]
            axis.dress(axes, vertical=False)
            axes.set_yscale("log")
            axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
            axes.yaxis.set_minor_formatter(NullFormatter())
            axes.grid(True, which="major", color="#dddddd", linewidth=0.6)
            axes.set_axisbelow(True)
            for row in of_row:
                if row["scene"] != scene:
                    continue
                style = METHODS[row["method"]]
                x = axis.place(float(row["wrong_per_million"]), present.index(row["method"]) / max(1, len(present) - 1))
                axes.plot(x, float(row["mrays"]), style.mark, color=style.colour, markersize=style.size,
                          markerfacecolor=style.colour if style.filled else "white", markeredgewidth=1.4,
                          zorder=4 if style.colour == BLUE else 3)
            if i == 0:
                axes.set_title(scene)
            if j == 0:
                kind = "camera rays" if generator == "camera" else f"rays {GENERATORS[generator]}"
                axes.set_ylabel(f"{kind}, {thousands(int(of_row[0]['rays']))}\n\nmillion rays per second")
            axes.tick_params(labelsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("wrong decisions per million rays", fontsize=9)
    handles = [Line2D([], [], linestyle="", marker=METHODS[m].mark, color=METHODS[m].colour, markeredgewidth=1.4,
                      markerfacecolor=METHODS[m].colour if METHODS[m].filled else "white",
                      markersize=METHODS[m].size, label=METHODS[m].title) for m in present]
    figure.legend(handles=handles, loc="lower center", ncol=5 if len(scenes) > 4 else 4, frameon=False, fontsize=9)
    figure.suptitle("Speed against wrong decisions, one thread. Better is up and to the left. "
                    "Grey band: not one wrong decision (places within it mean nothing)", fontsize=12)
    figure.tight_layout(rect=(0, 0.95 / figure.get_figheight(), 1, 0.99))
    finish(figure, path)


# ---- stability -------------------------------------------------------------------------------------------------------

Line = collections.namedtuple("Line", "title members colour dash width mark")

# Methods that share all arithmetic that decides are one line: the worst of them.
LINES = [
    Line("mlrt, all five methods", ["mlrt_ray", "mlrt_packet2", "mlrt_packet4", "mlrt_multilevel", "mlrt_tile"], BLUE, "-", 3.0, None),
    Line("Möller–Trumbore, double", ["mt_double"], RED, "-", 1.5, "s"),
    Line("Woop et al. 2013 (watertight), float", ["woop2013"], SKY, "-", 1.5, "P"),
    Line("tinybvh 1.6", ["tinybvh"], GREEN, "--", 1.5, "X"),
    Line("mlrt without exactness", ["guess_tile"], RED, "--", 1.5, "p"),
    Line("Embree 3 robust, 1 and 16 rays", ["embree_robust", "embree_robust16"], GREY, "-", 1.5, "s"),
    Line("Embree 3 fast, 1 and 16 rays", ["embree_fast", "embree_fast16"], BLACK, "--", 1.5, "o"),
    Line("Plücker, float", ["pluecker"], GREEN, "-", 1.5, "v"),
    Line("Möller–Trumbore, float", ["mt_float"], ORANGE, "-", 1.5, "o"),
    Line("Möller–Trumbore, float, ε = 1e-6", ["mt_epsilon"], ORANGE, ":", 1.5, "x"),
    Line("Wald 2004, float", ["wald2004"], PURPLE, "-", 1.5, "^"),
]

AIMS = {"random": "anywhere", "surface": "inside\ntriangles", "edge": "edges", "vertex": "vertices", "axis": "along\nan axis",
        "split_plane": "in a split\nplane"}

SWEEPS = {
    "aim": ("Aim: what the rays of a sphere are aimed at", None),
    "shift": ("Shift: distance from the origin", "radii of the sphere, along each axis"),
    "scale": ("Scale: size of sphere, origins and directions", "radius of the sphere"),
    "length": ("Length of the direction vector", "length / radius of the sphere"),
    "sliver": ("Slivers: triangles in a flat sheet", "length of a triangle / its height"),
    "grazing": ("Grazing: rays along a flat sheet", "angle between ray and sheet, degrees"),
}


def worst(rows, line, condition):
    values = [float(r["wrong_per_million"]) for r in rows if r["generator"] == condition and r["method"] in line.members]
    return max(values) if values else None


def draw_sweep(axes, axis, sweep, rows, lines):
    conditions = in_order(rows, "generator")
    values = [condition.split("=")[1] for condition in conditions]
    axis.dress(axes, vertical=True)
    axes.grid(True, axis="y", color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    if sweep == "aim":
        xs = list(range(len(values)))
        axes.set_xticks(xs, [AIMS[v] for v in values])
    else:
        xs = [float(v) for v in values]
        positive = [x for x in xs if x > 0]
        if min(xs) == 0:  # a place for 0 on a logarithmic axis
            xs = [x if x > 0 else min(positive) / 10 for x in xs]
        axes.set_xscale("log")
        axes.xaxis.set_minor_locator(NullLocator())
        if min(float(v) for v in values) == 0:
            ticks = [min(xs)] + [10.0 ** e for e in range(0, 8)]
            axes.set_xticks(ticks, ["0"] + [f"$10^{e}$" if e > 1 else str(10 ** e) for e in range(0, 8)])
        elif max(xs) / min(xs) > 1e20:
            axes.set_xticks([10.0 ** e for e in range(-30, 31, 10)])
        else:
            axes.set_xticks([10.0 ** e for e in range(math.ceil(math.log10(min(xs)) - 1e-9), int(math.log10(max(xs))) + 1)])
        if sweep == "grazing":
            axes.invert_xaxis()
    for number, line in enumerate(lines):
        share = number / max(1, len(lines) - 1)
        points = [(x, worst(rows, line, c)) for x, c in zip(xs, conditions)]
        points = [(x, axis.place(y, share)) for x, y in points if y is not None]
        offset = (number - 0.5 * (len(lines) - 1)) * 0.085 if sweep == "aim" else 0
        axes.plot([x + offset for x, _ in points], [y for _, y in points], marker=line.mark or "*", color=line.colour,
                  linestyle="" if sweep == "aim" else line.dash, linewidth=line.width,
                  markersize=(11 if line.mark is None else 6) if sweep == "aim" else 3.5 if line.mark else 0,
                  zorder=5 if line.mark is None else 3)
    title, label = SWEEPS[sweep]
    axes.set_title(title, fontsize=11)
    axes.set_xlabel(label or "")
    axes.tick_params(labelsize=8.5)


def draw_stability(rows, path):
    sweeps = [s for s in SWEEPS if any(row["generator"].startswith(s + "=") for row in rows)]
    lines = [line for line in LINES if any(row["method"] in line.members for row in rows)]
    axis = WrongAxis([int(row["rays"]) for row in rows])
    columns = min(3, len(sweeps))
    figure, grid = plt.subplots(math.ceil(len(sweeps) / columns), columns, squeeze=False, figsize=(15, 9.6))
    cells = [axes for row in grid for axes in row]
    for axes, sweep in zip(cells, sweeps):
        draw_sweep(axes, axis, sweep, [row for row in rows if row["generator"].startswith(sweep + "=")], lines)
    for axes in cells[len(sweeps):]:
        axes.axis("off")
    for row in grid:
        row[0].set_ylabel("wrong decisions per million rays")
    handles = [Line2D([], [], color=l.colour, linestyle=l.dash, linewidth=l.width, marker=l.mark, markersize=5,
                      label=l.title) for l in lines]
    figure.legend(handles=handles, loc="lower center", ncol=5, frameon=False, fontsize=9.5)
    count = thousands(int(rows[0]["rays"]))
    figure.suptitle(f"Where methods start to fail: {count} rays per value. Grey band: not one wrong decision (places within it mean nothing)",
                    fontsize=13)
    figure.tight_layout(rect=(0, 0.065, 1, 0.99))
    finish(figure, path)


# ---- stages ----------------------------------------------------------------------------------------------------------

STAGES = [
    ("float", "float filter", SKY),
    ("tie", "exact tie, recognised cheaply", GREEN),
    ("double", "double with a bound", ORANGE),
    ("exact", "exact integers", RED),
]


def draw_stages(rows, path):
    scenes = in_order(rows, "scene")
    generators = in_order(rows, "generator")
    titles = {"camera": "pictures", "random": "random rays", "edge": "rays aimed at edges"}
    figure, panels = plt.subplots(1, len(generators), figsize=(14, 1.8 + 0.55 * len(scenes)), sharey=True, squeeze=False)
    height = 0.84 / len(STAGES)
    for axes, generator in zip(panels[0], generators):
        for row in rows:
            if row["generator"] != generator:
                continue
            total = sum(float(row[stage]) for stage, _, _ in STAGES) or 1
            for s, (stage, _, colour) in enumerate(STAGES):
                share = 1e6 * float(row[stage]) / total
                y = scenes.index(row["scene"]) + (s - 1.5) * height
                if share > 0:
                    axes.barh(y, share, height * 0.92, color=colour, left=0)
                axes.text(max(share, 0.1) * 1.2, y, f"{share:,.0f}" if share >= 10 else f"{share:.2g}", va="center",
                          fontsize=6.5)
        axes.set_title(titles.get(generator, generator), fontsize=11)
        axes.set_xscale("log")
        axes.set_xlim(0.1, 3e7)
        axes.grid(axis="x", color="0.9")
        axes.set_axisbelow(True)
        axes.set_xlabel("of a million (ray, triangle) decisions")
    panels[0][0].set_yticks(range(len(scenes)), scenes)
    panels[0][0].set_ylim(len(scenes) - 0.4, -0.6)
    handles = [Line2D([], [], color=colour, linewidth=8, label=title) for _, title, colour in STAGES]
    figure.legend(handles=handles, loc="lower center", ncol=4, frameon=False, fontsize=9.5)
    figure.suptitle("Which stage of method tile decides", fontsize=12)
    figure.tight_layout(rect=(0, 0.5 / figure.get_figheight(), 1, 0.99))
    finish(figure, path)


# ---- which structure pays --------------------------------------------------------------------------------------------

PAYS = {"none": ("a loop over all triangles", "#f0e442"), "fast": ("MLRT_TREE_FAST", SKY), "default": ("MLRT_TREE_DEFAULT", BLUE),
        "best": ("MLRT_TREE_BEST", PURPLE), "kdtree": ("the paper's kd-tree", GREEN)}


PAYS_MESHES = (("spheres (below 20 triangles sheets)", ("sheet", "sphere")),
               ("rooms", ("room", "doubled", "office", "building")))
PAYS_RAYS = (("picture_ns", "rays of pictures"), ("single_ns", "random rays, a call for each"))
PAYS_TOLERANCE = 1.05  # structures that take no more than this times the least are as good: the first in the list counts


def draw_pays(rows, path):
    """For each number of triangles and of rays, the structure whose time to build and trace is least."""
    rows = [r for r in rows if r["structure"] in PAYS]
    names = list(PAYS)
    figure, grid = plt.subplots(2, 2, figsize=(13, 8.4), sharex=True)
    exponents = [e / 20 for e in range(0, 181)]
    for i, (mesh_title, scenes) in enumerate(PAYS_MESHES):
        of_meshes = [r for r in rows if r["scene"] in scenes]
        counts = sorted({int(r["triangles"]) for r in of_meshes})
        logs = [math.log10(count) for count in counts]
        for axes, (column, ray_title) in zip(grid[i], PAYS_RAYS):
            image, regret = [], []
            for count in counts:
                of_count = {r["structure"]: r for r in of_meshes if int(r["triangles"]) == count}
                line, loss = [], []
                for exponent in exponents:
                    times = {n: float(r["build_seconds"]) + 1e-9 * 10 ** exponent * float(r[column]) for n, r in of_count.items()}
                    least = min(times.values())
                    line.append(next(k for k, n in enumerate(names) if n in times and times[n] <= PAYS_TOLERANCE * least))
                    loss.append(times["default"] / least)
                image.append(line)
                regret.append(loss)
            edges = [logs[0] - 0.2] + [(a + b) / 2 for a, b in zip(logs, logs[1:])] + [logs[-1] + 0.2]
            steps = [e - 0.025 for e in exponents] + [exponents[-1] + 0.025]
            colours = matplotlib.colors.ListedColormap([PAYS[n][1] for n in names])
            axes.pcolormesh(steps, edges, image, cmap=colours, vmin=-0.5, vmax=len(names) - 0.5)
            lines = axes.contour(exponents, logs, regret, levels=[1.25, 2], colors="black", linewidths=[0.8, 1.5])
            axes.clabel(lines, fmt={1.25: "1.25", 2: "2"}, fontsize=8)
            axes.set_yticks(range(0, 8), ["1" if e == 0 else f"$10^{e}$" for e in range(0, 8)])
            axes.set_ylim(edges[0], edges[-1])
            axes.set_xticks(range(0, 10), ["1" if e == 0 else f"$10^{e}$" for e in range(0, 10)])
            axes.set_title(f"{mesh_title}: {ray_title}", fontsize=10.5)
    for row in grid:
        row[0].set_ylabel("triangles")
    for axes in grid[1]:
        axes.set_xlabel("rays")
    handles = [Line2D([], [], linestyle="", marker="s", markersize=10, color=colour, label=title) for title, colour in PAYS.values()]
    handles.append(Line2D([], [], color="black", label="the default takes so many times as long"))
    figure.legend(handles=handles, loc="lower center", ncol=3, frameon=False, bbox_to_anchor=(0.5, 0.015))
    figure.suptitle("What to build: least time for building and tracing together, one thread", fontsize=12)
    figure.tight_layout(rect=(0, 0.09, 1, 0.99))
    finish(figure, path)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    data, output = sys.argv[1:]
    for name, draw, chart in (("methods", draw_summary, "accuracy-summary"), ("methods", draw_speed, "accuracy-speed"),
                              ("stability", draw_stability, "accuracy-stability"), ("stages", draw_stages, "accuracy-stages"),
                              ("price", draw_price, "accuracy-price"), ("pays", draw_pays, "depth-pays")):
        table, picture = os.path.join(data, name + ".csv"), os.path.join(output, chart + ".png")
        rows = read(table)
        if rows:
            MACHINE[0] = stamp.machine_of(table)
            draw(rows, picture)
            stamp.stamp(picture, [table])


if __name__ == "__main__":
    main()
