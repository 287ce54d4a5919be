#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tables.py - keeps tables, figures and charts of documents equal to the data that programs of this tree wrote

    tables.py [--check] DATA FILE...

FILE is a Markdown file, whose tables and figures are written anew, or a chart (PNG), whose stamp is compared (stamp.py). With --check
nothing is written, and the exit status is 1 if something would be; so it is in either case where a table of figures
(with a column aligned to the right) has no data, or where a chart is not that of its data.

A table stands between two lines:

    <!-- table: DATA.csv rows=COLUMN columns=COLUMN cell={FORMAT:VALUE} ... -->
    <!-- end of table -->

DATA.csv        several may be given, A.csv=TITLE,B.csv=TITLE: the column `file` has the titles
rows=A,B        a row for each combination of what these columns have. rows=cell: a row for each cell=
columns=A,B     a column for each combination; without it, for each cell=. A^ is what A has before a "="
cell=[TITLE:]   what is in a cell: text, with _ for spaces, and values in braces. A VALUE is a column, a sum A+B, or a
                quotient of these. FORMAT is Python's (s: text), or % with decimals, ppm, ms, or `speed`, three digits of a rate;
                ? after it leaves out 0. TITLE: where there are several
where=A=x|y:T   only rows whose A is x or y, in this order, with titles, if any; where=A!=x: only the others
several=WHAT    of several rows for one cell the least, median, greatest, sum, (geometric) mean, or `spread`, three columns;
                mean,least: the mean for the first value of a cell, the least for the others
join=A:B,C      first, rows that agree in B and C become one, in which column D of the row whose A is x is D@x: so D@x/D@y
                compares methods, or files
ratio=x/y       one more column: the first cell's value in column x over that in column y
label=A|B       heads of the columns of rows=

DATA.md is the output of a program in Markdown: section=N stands for all of its section "## N.", without the head. For
figures its tables have the columns `section`, `scene` (the second word of the line above the table), `row`, and their own,
with _ for spaces and colons.

A figure in a sentence is watched by a comment below its paragraph, with a cell as above:

    <!-- figure: 1.23 is DATA.csv cell={.2f:VALUE} where=... -->
"""
import csv
import itertools
import os
import re
import statistics
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import stamp

TABLE = re.compile(r"(<!-- table: (\S+)\s+([^>]*?)\s*-->\n)(.*?)(<!-- end of table -->)", re.S)
FIGURE = re.compile(r"((?:^[^\n]+\n)+)\s*((?:<!-- figure:[^>]*?-->\s*)+)", re.M)
ONE_FIGURE = re.compile(r"<!-- figure: (.+?) is (\S+)\s+([^>]*?)\s*-->")
SEVERAL = {"least": min, "median": statistics.median, "greatest": max, "sum": sum, "mean": statistics.geometric_mean}
PART = re.compile(r"\{([^}:]*):([^}]*)\}")


class Mistake(Exception):
    pass


# ---- data ------------------------------------------------------------------------------------------------------------


def joined(text):
    return re.sub(r"[ :]+", "_", text.strip())


def read_markdown(path):
    """The rows of all tables."""
    rows, section, scene, head = [], "", "", None
    with open(path) as file:
        for line in file:
            cells = [cell.strip(" *`") for cell in line.strip().strip("|").split("|")]
            if not line.startswith("|"):
                head = None
                section = line[3:].split(".")[0] if line.startswith("## ") else section
                scene = line.partition(": ")[2].split()[0] if ": " in line else scene
            elif head is None:
                head = [joined(cell) for cell in ["row"] + cells[1:]]
            elif not line.startswith("| ---"):
                values = [joined(cells[0])] + [cell.replace(",", "") for cell in cells[1:]]
                rows.append(dict(zip(head, values), section=section, scene=scene))
    return rows


def located(data, name):
    path = os.path.join(data, name)
    if not os.path.exists(path):
        raise Mistake(f"{path} is not there")
    return path


def read(data, names):
    rows = []
    for name in names.split(","):
        file, _, title = name.partition("=")
        path = located(data, file)
        if file.endswith(".md"):
            rows += read_markdown(path)
            continue
        with open(path, newline="") as lines:
            rows += [dict(row, file=title.replace("_", " ")) for row in csv.DictReader(lines)]
    return rows


def read_section(data, name, number):
    path = located(data, name)
    with open(path) as file:
        found = re.search(rf"^## {number}\.[^\n]*\n\n(.*?)\n*(?=^## |\Z)", file.read(), re.S | re.M)
    if not found:
        raise Mistake(f"{path} has no section {number}")
    return found[1] + "\n"


# ---- specifications --------------------------------------------------------------------------------------------------


def spaced(text):
    return re.sub(r"_(?![^{]*\})", " ", text)


def value_in(row, column):
    if column.endswith("^"):
        return row[column[:-1]].split("=")[0]
    return row.get(column)


def word(value):
    """As a specification writes it."""
    return (value or "").replace(" ", "_")


class Specification:
    def __init__(self, text):
        self.rows, self.columns, self.cells, self.ratios, self.label = [], [], [], [], None
        self.wanted, self.unwanted, self.several, self.join = {}, [], None, None
        for argument in text.split():
            key, _, value = argument.partition("=")
            if key in ("rows", "columns"):
                setattr(self, key, value.split(","))
            elif key == "cell":
                title, _, template = value.rpartition(":{") if not value.startswith("{") else ("", "", value[1:])
                self.cells.append((spaced(title), spaced("{" + template)))
            elif key == "where" and "!=" in value:
                self.unwanted.append(tuple(value.split("!=")))
            elif key == "where":
                column, _, values = value.partition("=")
                pairs = [one.partition(":") for one in values.split("|")]
                self.wanted[column] = {one: title.replace("_", " ") for one, _, title in pairs}
            elif key == "ratio":
                self.ratios.append(value.split("/"))
            elif key == "several":
                self.several = value
            elif key == "join":
                column, _, keys = value.partition(":")
                self.join = column, keys.split(",")
            elif key == "label":
                self.label = [spaced(one) for one in value.split("|")]
            else:
                raise Mistake(f"{key}= is nothing known")

    def joined(self, rows):
        if self.join is None:
            return rows
        column, keys = self.join
        found = {}
        for row in rows:
            key = tuple(row[one] for one in keys)
            one = found.setdefault(key, dict(zip(keys, key)))
            one.update({f"{name}@{word(row[column])}": value for name, value in row.items() if name not in keys})
        return list(found.values())

    def keep(self, rows):
        rows = self.joined(rows)
        return [row for row in rows if all(word(value_in(row, c)) in values for c, values in self.wanted.items())
                and all(word(value_in(row, c)) != value for c, value in self.unwanted)]

    def keys(self, rows, columns):
        """All combinations that occur, in the order of `where`, else of the data."""
        orders = []
        for column in columns:
            seen = {word(value_in(row, column)): value_in(row, column) for row in rows}
            orders.append([seen[one] for one in self.wanted.get(column, seen) if one in seen])
        present = {tuple(value_in(row, c) for c in columns) for row in rows}
        return [key for key in itertools.product(*orders) if key in present]

    def title(self, column, value):
        return self.wanted.get(column, {}).get(word(value)) or value


# ---- cells -----------------------------------------------------------------------------------------------------------


def number(row, value):
    """The value of an expression, or None."""
    def total(names):
        texts = [row.get(name, "") for name in names.split("+")]
        if any(text == "" or text is None for text in texts):
            return None
        return sum(float(text) for text in texts)

    above, _, below = value.partition("/")
    top, bottom = total(above), total(below) if below else 1
    return None if top is None or not bottom else top / bottom


def show(form, value):
    if form.endswith("?"):
        form, value = form[:-1], value or None
    if value is None:
        return ""
    if form == "speed":
        return f"{value:.0f}" if value >= 100 else f"{value:.1f}"
    if form == "ppm":
        return f"{1e6 * value:,.0f}"
    if form == "ms":
        return f"{1e3 * value:,.{0 if value >= 0.1 or value == 0 else 2 if value >= 0.001 else 4}f}"
    if form.endswith("%"):
        return f"{100 * value:{form[:-1]}f} %"
    return f"{value:{form}}"


def values_of(rows, template, several):
    """For each value in the template one number; of several rows those that `several` says."""
    values = []
    ways = several.split(",") if several else [None]
    for i, (form, value) in enumerate(PART.findall(template)):
        found = [row[value] if form == "s" else number(row, value) for row in rows]
        found = [one for one in found if one is not None]
        if len(found) > 1 and several is None:
            raise Mistake(f"{len(found)} rows have a {value} for one cell")
        way = ways[min(i, len(ways) - 1)]
        values.append((SEVERAL[way](found) if way else found[0]) if found else None)
    return values


def fill(template, values):
    left = iter(values)
    text = PART.sub(lambda part: show(part[1], next(left)), template)
    return "" if all(value is None for value in values) else text.replace(" ()", "")


def cell_text(rows, template, several):
    if PART.search(template) is None:
        raise Mistake(f"{template} has no value")
    return fill(template, values_of(rows, template, several))


# ---- tables ----------------------------------------------------------------------------------------------------------


def markdown(head, body, labels):
    rows = [head, ["---"] * labels + ["---:"] * (len(head) - labels)] + body
    return "".join("| " + " | ".join(row) + " |\n" for row in rows)


def heads_of(titles):
    """Heads of columns from the parts of their titles; what a title begins with as the one before it is left out."""
    heads, before = [], ()
    for title in titles:
        title = tuple(part for part in title if part)
        heads.append(": ".join(title[-1:] if title[:-1] == before[:-1] and len(title) > 1 else title))
        before = title
    return heads


def make_table(rows, specification):
    s = specification
    rows = s.keep(rows)
    if not rows:
        raise Mistake("no row of the data is left")
    kinds = ["least", "median", "greatest"] if s.several == "spread" else [s.several]
    by_cell = s.rows == ["cell"]
    keys = [((), cell) for cell in s.cells] if by_cell else [(key, None) for key in s.keys(rows, s.rows)]
    columns = s.keys(rows, s.columns) if s.columns else [()]
    shown = [None] if by_cell else s.cells
    head = s.label or (["" if by_cell else name.rstrip("^") for name in s.rows])
    head = head + heads_of([[s.title(c, value) for c, value in zip(s.columns, key)] + [cell[0] if cell else ""]
                            + [kind if len(kinds) > 1 else ""] for key in columns for cell in shown for kind in kinds])
    head += [f"{s.title(s.columns[-1], a)} / {s.title(s.columns[-1], b)}" for a, b in s.ratios]
    body = []
    for key, row_cell in keys:
        of_row = [row for row in rows if by_cell or tuple(value_in(row, c) for c in s.rows) == key]
        line = [row_cell[0]] if by_cell else [s.title(c, value) for c, value in zip(s.rows, key)]
        firsts = {}
        for column in columns:
            of_cell = [row for row in of_row if tuple(value_in(row, c) for c in s.columns) == column]
            for cell in shown:
                template = (row_cell or cell)[1]
                line += [cell_text(of_cell, template, kind) for kind in kinds]
                firsts.setdefault(column[-1] if column else "", number(of_cell[0], PART.findall(template)[0][1]) if of_cell and s.ratios else None)
        for above, below in s.ratios:
            line.append(f"{firsts[above] / firsts[below]:.2f}" if firsts.get(above) and firsts.get(below) else "")
        body.append(line)
    return markdown(head, body, 1 if by_cell else len(s.rows))


def table_of(data, names, text):
    if names.endswith(".md"):
        return read_section(data, names, text.partition("=")[2])
    return make_table(read(data, names), Specification(text))


def figure_of(data, names, text):
    specification = Specification(text)
    return cell_text(specification.keep(read(data, names)), specification.cells[0][1], specification.several)


# ---- documents -------------------------------------------------------------------------------------------------------


def line_of(text, place):
    return text.count("\n", 0, place) + 1


def renew(text, data, report):
    def replace(block):
        begin, names, words, old, end = block.groups()
        try:
            new = table_of(data, names, words)
        except (Mistake, KeyError, ValueError) as mistake:
            report(line_of(text, block.start()), f"{names}: {mistake}")
            return block[0]
        if new != old:
            lines = zip(new.split("\n"), old.split("\n") + [""] * new.count("\n"))
            report(line_of(text, block.start()), next((f"not {a!r} but {b!r}" for b, a in lines if a != b), "ends too late"), False)
        return begin + new + end

    return TABLE.sub(replace, text)


def check_forms(text, report):
    """Comments that look like those above, but are not of their form, would check nothing."""
    watched = sum(len(ONE_FIGURE.findall(found[2])) for found in FIGURE.finditer(text))
    for kind, count in (("table", len(TABLE.findall(text))), ("figure", watched)):
        if text.count(f"<!-- {kind}:") != count:
            report(1, f"{text.count(f'<!-- {kind}:')} comments begin with `{kind}:`, {count} are of its form and in its place")


def renew_figures(text, data, report):
    """In the comment and in the paragraph above it, if the figure is there only once; whether the sentence still holds is for
    its author to see."""
    def replace(found):
        paragraph, comments = found[1], found[2]
        for written, names, words in ONE_FIGURE.findall(comments):
            place = re.compile(rf"(?<![\d.,]){re.escape(written)}(?!\d|[.,]\d)")
            times = len(place.findall(paragraph))
            try:
                right = figure_of(data, names, words)
            except (Mistake, KeyError, ValueError) as mistake:
                report(line_of(text, found.start()), f"figure {written}: {names}: {mistake}")
                continue
            if times == 0 or (right != written and times > 1):
                report(line_of(text, found.start()), f"figure {written}: {names} says {right}; it is in the paragraph {times} times")
            elif right != written:
                report(line_of(text, found.start()), f"figure {written}: {names} says {right}", False)
                paragraph = place.sub(right, paragraph)
                comments = comments.replace(f"<!-- figure: {written} is {names} {words} -->", f"<!-- figure: {right} is {names} {words} -->")
        return found[0].replace(found[1], paragraph, 1).replace(found[2], comments, 1)

    return FIGURE.sub(replace, text)


def check_owners(text, report):
    """Columns that are aligned to the right have figures, and those have data."""
    outside = TABLE.sub(lambda block: "\n" * block[0].count("\n"), text)
    for found in re.finditer(r"^\|[-:| ]*-:[-:| ]*\|$", outside, re.M):
        report(line_of(outside, found.start()), "a table of figures without data: <!-- table: ... -->")


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--check"]
    is_check = len(arguments) < len(sys.argv) - 1
    if len(arguments) < 2:
        sys.exit(__doc__)
    data, failed = arguments[0], False
    for path in arguments[1:]:
        if path.endswith(".png"):
            for mistake in stamp.mistakes(path, data):
                print(f"{path} {mistake}")
                failed = True
            continue

        def report(line, mistake, stays=True):
            nonlocal failed
            print(f"{path}:{line}: {mistake}")
            failed = failed or stays or is_check

        with open(path) as file:
            old = file.read()
        new = renew_figures(renew(old, data, report), data, report)
        check_forms(new, report)
        check_owners(new, report)
        if new != old and not is_check:
            with open(path, "w") as file:
                file.write(new)
    sys.exit(failed)


if __name__ == "__main__":
    main()
