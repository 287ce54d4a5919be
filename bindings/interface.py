# SPDX-License-Identifier: MIT
"""Reads include/mlrt.h: its functions, structs, callbacks and constants, with their texts.

Relies on the style of the header: a text stands in front of a function, a struct or a callback, and behind a field or a constant.
"""

import re
from collections import namedtuple
from pathlib import Path

HEADER = Path(__file__).resolve().parents[1] / "include" / "mlrt.h"

Parameter = namedtuple("Parameter", "type name count")  # count: elements of an array, as text, or ""
Field = namedtuple("Field", "type name count text")
Struct = namedtuple("Struct", "name fields text")
Function = namedtuple("Function", "name result parameters text")
Constant = namedtuple("Constant", "name value text")
Interface = namedtuple("Interface", "functions structs callbacks constants handles")

COMMENT = r"/\*(?:(?!\*/).)*\*/"


def clean(comment: str) -> str:
    """A comment without its marks."""
    lines = (re.sub(r"^ ?\* ?", "", line.strip() if line.strip() == "*" else line) for line in (comment or "")[2:-2].split("\n"))
    return "\n".join(line.rstrip() for line in lines).strip()


def one_line(comment: str) -> str:
    """A comment behind a field or a constant, as one line."""
    return " ".join(clean(comment).split())


def declaration(text: str) -> Parameter:
    """Type and name of `const float *name` or `float name[3]`."""
    match = re.fullmatch(r"\s*(.*?)\s*(\w+)\s*(?:\[(\w+)\])?\s*", " ".join(text.split()))
    return Parameter(match[1].replace("struct ", ""), match[2], match[3] or "")


def parameters(text: str) -> list:
    return [] if text.strip() == "void" else [declaration(parameter) for parameter in text.split(",")]


def read(path: Path = HEADER) -> Interface:
    text = path.read_text()
    structs = []
    for match in re.finditer(rf"({COMMENT})\ntypedef struct (\w+) \{{\n(.*?)\n\}} \2;", text, re.S):
        fields = []
        for field in re.finditer(r"([^;/]+);[ \t]*(" + COMMENT + r")?", match[3], re.S):
            for name in [declaration(field[1])]:
                fields.append(Field(*name, one_line(field[2])))
        structs.append(Struct(match[2], fields, clean(match[1])))
    functions = [
        Function(match[3], match[2].strip(), parameters(match[4]), clean(match[1]))
        for match in re.finditer(rf"({COMMENT})\nMLRT_API ([\w ]+?[ *]+)(\w+)\((.*?)\);", text, re.S)
    ]
    callbacks = [
        Function(match[3], match[2].strip(), parameters(match[4]), clean(match[1]))
        for match in re.finditer(rf"({COMMENT})\ntypedef ([\w ]+ \*?)\(\*(\w+)\)\((.*?)\);", text, re.S)
    ]
    constants = [Constant("MLRT_NONE", "0xFFFFFFFF", "The id that is reported for a miss. In a `skip` element it means that nothing is skipped.")]
    for match in re.finditer(r"\nenum \{\n(.*?)\n\};", text, re.S):
        for constant in re.finditer(r"(MLRT_\w+) = (\w+),?[ \t]*(" + COMMENT + r")?", match[1], re.S):
            constants.append(Constant(constant[1], constant[2], one_line(constant[3])))
    handles = re.findall(r"\ntypedef struct (\w+) \1;", text)
    exported = set(re.findall(r"^MLRT_API .*?(mlrt_\w+)\(", text, re.M))
    assert {function.name for function in functions} == exported, "a function of the header has no text"
    return Interface(functions, structs, callbacks, constants, handles)
