#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How much of the C interface each binding reaches, as its tests show it.

    coverage.py recorder FILE.c            writes a library that stands in for libmlrt, see below
    coverage.py check README FOLDER        fails if the records FOLDER/LANGUAGE.seen have less than the table in README
    coverage.py write README FOLDER        writes the table anew

The tests of each binding run with a library that has all functions of mlrt.h. Each writes down its name, and which fields of
the structs it was given are not 0; then it calls the same function of the real library. So the table says what the tests of
a binding have done, and not what its source seems to say.

The recorder takes the path of the real library from MLRT_RECORDED, and appends what it sees to the file MLRT_SEEN.
"""

import re
import sys
from pathlib import Path

import interface

LANGUAGES = {"cpp": "C++", "rust": "Rust", "go": "Go", "node": "Node", "java": "Java", "lua": "LuaJIT", "python": "Python"}

# Fields that a binding need not use: sizes, the argument of callbacks, and messages, which mlrt_last_message has too.
NOT_NEEDED = {"struct_size", "reserved", "user", "message", "message_size"}

# Structs for results, and those that lie inside of others.
RESULTS = {"mlrt_tree_info", "mlrt_memory_estimate", "mlrt_counters", "mlrt_hit", "mlrt_tile"}

START, END = "<!-- coverage: written by make bindings-coverage -->", "<!-- end of coverage -->"

HEAD = """\
/* SPDX-License-Identifier: MIT */
/* Written by bindings/coverage.py. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <mlrt.h>

/* Written at once: some languages end a process without leaving it time for more. */
static void see(const char *name, char *seen)
{
    if (__atomic_exchange_n(seen, 1, __ATOMIC_RELAXED)) return;
    const char *path = getenv("MLRT_SEEN");
    int file = path ? open(path, O_WRONLY | O_APPEND | O_CREAT, 0666) : -1;
    if (file < 0) return;
    char line[128] = {0};
    strncat(strncat(line, name, 120), "\\n", 2);
    if (write(file, line, strlen(line)) < 0) abort();
    close(file);
}

#define SEE(name) do { static char seen; see(name, &seen); } while (0)

static void *find(const char *name)
{
    void *library = dlopen(getenv("MLRT_RECORDED"), RTLD_NOW | RTLD_LOCAL);
    void *function = library ? dlsym(library, name) : NULL;
    if (!function) abort();
    return function;
}

static int is_set(const void *data, size_t size)
{
    const char *bytes = data;
    for (size_t i = 0; i < size; i++)
        if (bytes[i]) return 1;
    return 0;
}

/* Is the field within the caller's struct, and not 0? */
#define HAS(type, field) \\
    (offsetof(type, field) + sizeof s->field <= s->struct_size && is_set(&s->field, sizeof s->field))

static void look_at_mlrt_array(const mlrt_array *s)
{
    if (s->data && s->stride) SEE("mlrt_array.stride");
    if (s->data && s->row_stride) SEE("mlrt_array.row_stride");
}

static void look_at_mlrt_const_array(const mlrt_const_array *s)
{
    if (s->data && s->stride == MLRT_STRIDE_ALL) SEE("mlrt_const_array.stride = MLRT_STRIDE_ALL");
    else if (s->data && s->stride) SEE("mlrt_const_array.stride");
}
"""

ARRAYS = ["mlrt_array.stride", "mlrt_array.row_stride", "mlrt_const_array.stride", "mlrt_const_array.stride = MLRT_STRIDE_ALL"]


def input_structs(header: interface.Interface) -> list:
    """Structs whose fields callers set, those first that others point to."""
    last = {"mlrt_host": 0, "mlrt_light": 1}
    structs = [s for s in header.structs if s.name not in RESULTS and s.fields[0].name == "struct_size"]
    return sorted(structs, key=lambda s: last.get(s.name, 2))


def fields_of(struct: interface.Struct) -> list:
    return [field for field in struct.fields if field.name not in NOT_NEEDED]


def things(header: interface.Interface) -> list:
    """All that can be seen, in the order of the header."""
    names = [function.name for function in header.functions]
    for struct in input_structs(header):
        names += [f"{struct.name}.{field.name}" for field in fields_of(struct)]
    return names + ARRAYS


def recorder(header: interface.Interface) -> str:
    structs = input_structs(header)
    known = {struct.name for struct in structs}
    text = HEAD
    for struct in structs:
        text += f"\nstatic void look_at_{struct.name}(const {struct.name} *s, size_t count)\n{{\n"
        text += f"    for (; s && count; count--, s = (const {struct.name} *)((const char *)s + s->struct_size)) {{\n"
        for field in struct.fields:
            if field.type in ("mlrt_array", "mlrt_const_array"):
                text += f"        if (HAS({struct.name}, {field.name}.data)) SEE(\"{struct.name}.{field.name}\");\n"
                text += f"        if (HAS({struct.name}, {field.name}.data)) look_at_{field.type}(&s->{field.name});\n"
                continue
            pointed = re.fullmatch(r"const (mlrt_\w+) \*", field.type)
            if pointed and pointed[1] in known:
                number = "s->light_count" if field.name == "lights" else "1"
                text += f"        if (HAS({struct.name}, {field.name})) look_at_{pointed[1]}(s->{field.name}, {number});\n"
            if field.name not in NOT_NEEDED:
                text += f"        if (HAS({struct.name}, {field.name})) SEE(\"{struct.name}.{field.name}\");\n"
        text += "    }\n}\n"
    for function in header.functions:
        types = ", ".join(p.type + ("*" if p.count else "") for p in function.parameters) or "void"
        named = ", ".join(f"{p.type} {p.name}" + (f"[{p.count}]" if p.count else "") for p in function.parameters) or "void"
        text += f"\n{function.result} {function.name}({named})\n{{\n    SEE(\"{function.name}\");\n"
        for p in function.parameters:
            pointed = re.fullmatch(r"const (mlrt_\w+) \*", p.type)
            if pointed and pointed[1] in known:
                number = "mesh_count" if p.name == "meshes" else "1"
                text += f"    look_at_{pointed[1]}({p.name}, {number});\n"
            if p.type == "const mlrt_array *":
                text += f"    if ({p.name}) look_at_mlrt_array({p.name});\n"
        call = f"(({function.result}(*)({types}))find(\"{function.name}\"))({', '.join(p.name for p in function.parameters)})"
        text += f"    {'' if function.result == 'void' else 'return '}{call};\n}}\n"
    return text


def seen_by(folder: Path) -> dict:
    """What the tests of each language that have run have seen."""
    return {l: set((folder / f"{l}.seen").read_text().split("\n")) for l in LANGUAGES if (folder / f"{l}.seen").exists()}


def column_of(seen: set, header: interface.Interface) -> dict:
    """Row -> cell."""
    column = {f"`{function.name}`": "yes" if function.name in seen else "-" for function in header.functions}
    for struct in input_structs(header):
        names = [f"{struct.name}.{field.name}" for field in fields_of(struct)]
        column[f"fields of `{struct.name}`"] = f"{sum(name in seen for name in names)} of {len(names)}"
    column["strides of arrays"] = f"{sum(name in seen for name in ARRAYS)} of {len(ARRAYS)}"
    missing = [name for name in things(header) if name not in seen]
    for struct in input_structs(header):
        names = [f"{struct.name}.{field.name}" for field in fields_of(struct)]
        if all(name in missing for name in names):
            missing[missing.index(names[0])] = struct.name
            missing = [name for name in missing if name not in names]
    column["missing"] = ", ".join(f"`{name}`" for name in missing) or "nothing"
    return column


def parse(text: str) -> dict:
    """Language -> row -> cell, of the table in a README."""
    columns = {language: {} for language in LANGUAGES}
    for line in text[text.index(START) : text.index(END)].splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == len(LANGUAGES) + 1 and cells[0] and not cells[0].startswith("-"):
            for language, cell in zip(LANGUAGES, cells[1:]):
                columns[language][cells[0]] = cell
        for language, name in LANGUAGES.items():
            if line.startswith(f"- {name}: "):
                columns[language]["missing"] = line.split(": ", 1)[1]
    return columns


def is_more(cell: str, written: str) -> bool:
    """Do the tests reach more than the table says? Tests of a language may grow before the table is written anew."""
    if written is None:
        return False
    numbers = [{"yes": "1 of 1", "-": "0 of 1"}.get(text, text).split(" of ") for text in (cell, written)]
    return numbers[0][1] == numbers[1][1] and int(numbers[0][0]) > int(numbers[1][0])


def table(columns: dict) -> str:
    rows = [row for row in next(iter(columns.values())) if row != "missing"]
    lines = ["| | " + " | ".join(LANGUAGES.values()) + " |", "| --- " * (len(LANGUAGES) + 1) + "|"]
    lines += ["| " + " | ".join([row] + [columns[l].get(row, "-") for l in LANGUAGES]) + " |" for row in rows]
    lines += ["", "What the tests do not reach:", ""]
    lines += [f"- {name}: {columns[language].get('missing', 'not recorded')}" for language, name in LANGUAGES.items()]
    return "\n".join(lines)


def main() -> int:
    header = interface.read()
    command, target = sys.argv[1], Path(sys.argv[2])
    if command == "recorder":
        target.write_text(recorder(header))
        return 0
    found = {language: column_of(seen, header) for language, seen in seen_by(Path(sys.argv[3])).items()}
    text = target.read_text()
    written = parse(text)
    if command == "check":
        less, more = [], []
        for language, column in found.items():
            for row, cell in column.items():
                if row != "missing" and cell != written[language].get(row):
                    line = f"coverage of {LANGUAGES[language]}: {row}: {cell}; the table says {written[language].get(row)}"
                    (more if is_more(cell, written[language].get(row)) else less).append(line)
        print(*less, *more, sep="\n", end="\n" if less or more else "")
        if less or more:
            print("make bindings-coverage writes the table anew")
        return len(less) > 0
    columns = {language: found.get(language, written[language]) for language in LANGUAGES}
    order = {row: column_of(set(), header)[row] for row in column_of(set(), header)}
    for language in LANGUAGES:
        columns[language] = {row: columns[language].get(row, empty if row != "missing" else "not recorded") for row, empty in order.items()}
    before, after = text[: text.index(START)], text[text.index(END) :]
    target.write_text(f"{before}{START}\n{table(columns)}\n{after}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
