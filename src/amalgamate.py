#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the library as one mlrt.c and one mlrt.h: amalgamate.py FOLDER

A translation unit of the normal build becomes a section of mlrt.c, in the order of the layers, from base up; headers that
units share come once, in front. The kernels that are compiled once for each instruction set are the last section: for each
set mlrt.c includes itself, and then is nothing but these kernels. So that the sections do not meet,

  - names at file scope without the prefix mlrt_ are given the section's (`find_box` becomes `find_box_bvh_build`), which
    also keeps them apart from those of system headers, which are all included; in the kernels macros do so, which paste
    the name of the instruction set to them;
  - macros of a section are undefined at its end;
  - everything at file scope is static, but for the functions of mlrt.h.

What the Makefile says by flags is said by pragmas: a target for each instruction set, no contraction of a * b + c.
Relies on the house style: clang-format, one declaration per item, an include guard in each header.
"""
import collections
import os
import re
import sys

SOURCE = os.path.dirname(os.path.abspath(__file__))
INCLUDE = os.path.join(os.path.dirname(SOURCE), "include")

Kernel = collections.namedtuple("Kernel", "name file condition target")

LAYERS = ["base", "simd", "exact", "scene", "rays", "bvh", "job", "hits", "mlrta", "trace", "run", "api"]

# As in the Makefile: KERNELS and ISA_FLAGS_...
KERNELS = [
    Kernel("scalar", "isa/scalar.c", "!MLRT_SSE_KERNELS && !MLRT_NEON_KERNELS", None),
    Kernel("neon", "isa/neon.c", "MLRT_NEON_KERNELS", None),
    Kernel("sse", "isa/sse.c", "MLRT_SSE_KERNELS", None),
    Kernel("avx2", "isa/avx2.c", "MLRT_SSE_KERNELS", "avx2,fma"),
    Kernel("avx512", "isa/avx512.c", "MLRT_SSE_KERNELS", "avx512f,avx512dq,fma"),
]
KERNEL_TEXT = "isa/kernels.h"

CHOSEN = "simd/simd.h"  # the vocabulary that a kernel's unit includes first

COUNTING = "counters.h"  # its macros differ between kernels that count and those that do not
COUNTING_MACROS = ["COUNT", "COUNTERS", "CLEAR_COUNTS", "MLRT_COUNTING"]

# System headers that not every system has. The intrinsics come as one.
CONDITIONS = {
    "immintrin.h": "defined(__SSE2__) || defined(__x86_64__)",
    "cpuid.h": "defined(__SSE2__) || defined(__x86_64__)",
    "arm_neon.h": "defined(__aarch64__)",
    "sys/mman.h": "defined(__linux__)",
}
INTRINSICS = {"emmintrin.h", "xmmintrin.h", "immintrin.h"}

HEAD = """\
/* SPDX-License-Identifier: MIT */
/*
 * mlrt, the whole library in one file, written by src/amalgamate.py: change the files it was made of instead.
 *
 *     cc -O2 -c mlrt.c         gcc or clang; on 32-bit x86 with -msse2 -mfpmath=sse; programs link with -lm -pthread
 *
 * The file includes itself, once for each instruction set, and so must keep its name.
 *
 * A DLL: -shared -DMLRT_BUILD_DLL. With a gcc for Windows that does not align the stack for AVX (GCC bug 54412; those
 * of Debian and MSYS2 do without) add -Wa,-muse-unaligned-vector-move.
 */
#ifndef _DEFAULT_SOURCE
#define _DEFAULT_SOURCE
#endif
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif

#include "mlrt.h"

"""

BEFORE_ALL = """
/* Some of what follows only tests call, and some has a use on other processors. */
#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wunused-function"
#pragma clang diagnostic ignored "-Wunused-variable"
#pragma clang diagnostic ignored "-Wunused-const-variable"
#elif defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-variable"
#pragma GCC diagnostic ignored "-Wunused-const-variable"
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#endif
"""

AFTER_ALL = """
#if defined(__clang__)
#pragma clang diagnostic pop
#elif defined(__GNUC__)
#pragma GCC pop_options
#pragma GCC diagnostic pop
#endif
"""

BEFORE_KERNELS = """\
#if defined(__clang__)
{clang}#elif defined(__GNUC__)
#pragma GCC push_options
{gcc}#endif
"""

AFTER_KERNELS = """\
#if defined(__clang__)
{clang}#elif defined(__GNUC__)
#pragma GCC pop_options
#endif
"""

TOKEN = re.compile(
    r"""(?P<skip>/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')
      | (?P<directive>^[ \t]*\#(?:\\\n|[^\n])*)
      | (?P<name>[A-Za-z_]\w*)
      | (?P<number>\.?\d(?:[eEpP][+-]|[\w.])*)
      | (?P<mark>->|[^\s\w])""",
    re.S | re.M | re.X,
)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def without_guard(text, path):
    guard = re.search(r"^#ifndef (\w+_H)\n#define \1\n", text, re.M)
    if not path.endswith(".h") or not guard:
        return text
    end = text.rindex("#endif")
    return text[: guard.start()] + text[guard.end() : end]


def find_header(name, includer):
    for folder in (SOURCE, INCLUDE):
        path = os.path.join(folder, name)
        if os.path.exists(path):
            return path
    sys.exit(f"{includer}: no {name}")


def uses_words(path):
    """Is a header compiled once per instruction set: is it of a vocabulary, or does it include the chosen one?"""
    if os.path.dirname(path) == os.path.join(SOURCE, "simd"):
        return os.path.basename(path) != "sixteen.h"
    includes = re.findall(r'^#include "(\w+/.*)"', read(path), re.M)
    return any(file == CHOSEN or uses_words(os.path.join(SOURCE, file)) for file in includes if file != "simd/quad.h")


class Text:
    """What the sections are made of: pastes files, each header once."""

    def __init__(self):
        self.system = []  # names of system headers, in the order of their appearance
        self.shared = []  # texts
        self.shared_paths = set()

    def text_of_shared(self):
        return "".join(self.shared)

    def share(self, path):
        if path in self.shared_paths or os.path.basename(path) == "mlrt.h":
            return
        self.shared_paths.add(path)
        self.shared.append(self.paste(path, lambda _: False, set()))

    def paste(self, path, is_own, seen):
        """The text of a file, with its headers of its own in it; the others become shared ones."""
        lines = [f"\n/* ---- {os.path.relpath(path, os.path.dirname(SOURCE))} ---- */\n\n"]
        text = without_guard(read(path), path)
        if os.path.basename(path) == COUNTING and is_own(path):
            text = "".join(re.findall(r"^#(?!include).*\n", text, re.M))
        for line in text.splitlines(keepends=True):
            system = re.match(r"#include <(.*)>", line)
            local = re.match(r'#include "(.*)"', line)
            if system:
                self.system.append("immintrin.h" if system[1] in INTRINSICS else system[1])
            elif local:
                if local[1] == CHOSEN:
                    continue
                header = find_header(local[1], path)
                if not is_own(header):
                    # quad.h includes one of two headers, by the processor: they stay between its #if and #endif.
                    if os.path.basename(path) == "quad.h" and local[1].startswith("simd/"):
                        lines.append(self.paste(header, is_own, seen))
                    else:
                        self.share(header)
                elif header not in seen:
                    seen.add(header)
                    lines.append(self.paste(header, is_own, seen))
            elif not re.match(r"#define _(POSIX_C|DEFAULT)_SOURCE", line) and "SPDX" not in line:
                lines.append(line)
        return "".join(lines)


# ---- declarations ----------------------------------------------------------------------------------------------------


class Item:
    """A declaration or definition at file scope: its tokens, those in braces apart."""

    def __init__(self):
        self.outer = []  # (start, text) outside of braces; a pair of braces is one "{}"
        self.inner = []

    def words(self):
        return [text for _, text in self.outer]


def items_of(text):
    item, depth, after_body = Item(), 0, False
    for match in TOKEN.finditer(text):
        if match.lastgroup in ("skip", "directive"):
            continue
        token = match[0]
        if after_body:
            # A function ends with its body; what else has braces goes on to a semicolon.
            words = item.words()
            if token != ";" and is_function(words):
                yield item
                item = Item()
            after_body = False
        if token == "{":
            if depth == 0:
                item.outer.append((match.start(), "{}"))
            depth += 1
        elif token == "}":
            depth -= 1
            after_body = depth == 0
        elif depth > 0:
            item.inner.append(token)
        elif token == ";":
            yield item
            item = Item()
        else:
            item.outer.append((match.start(), token))
    if item.outer:
        yield item


QUALIFIERS = {"__extension__", "static", "inline", "const", "extern", "MLRT_INLINE", "MLRT_NOINLINE", "MLRT_API"}


ATTRIBUTE = re.compile(r"\b(?:MLRT_ALIGNED|__attribute__) \( (?:[^()]|\( [^()]* \))*\)")


def stripped(words):
    """Without qualifiers and attributes."""
    return [word for word in ATTRIBUTE.sub(" ", " ".join(words)).split() if word not in QUALIFIERS]


def is_function(words):
    words = stripped(words)
    return bool(words) and words[0] != "typedef" and "(" in words and not {"=", "["} & set(words[: words.index("(")])


# Functions and objects; typedefs and constants of enumerations; what follows struct, union or enum.
Names = collections.namedtuple("Names", "ordinary types tags")

TAGGED = ("struct", "union", "enum")


def names_of(text):
    """The names that a text gives at file scope."""
    names = Names(set(), set(), set())
    for item in items_of(text):
        words = stripped(item.words())
        for i, word in enumerate(words[:-2]):
            if word in TAGGED and words[i + 2] == "{}":
                names.tags.add(words[i + 1])
        if words and words[0] == "enum" and "{}" in words[1:3]:
            names.types.update(enum_constants(item.inner))
        if not words or (words[0] in TAGGED and len([word for word in words if word != "{}"]) <= 2):
            continue  # a type without a declarator
        if words[0] == "typedef":
            words = words[: words.index("[")] if "[" in words else words
            pointer = re.search(r"\( \* (\w+) \)", " ".join(words))
            names.types.add(pointer[1] if pointer else words[words.index("(") - 1] if "(" in words else words[-1])
        elif is_function(item.words()):
            names.ordinary.add(words[words.index("(") - 1])
        else:
            names.ordinary.update(object_names(words))
    return names


def enum_constants(tokens):
    expects = True
    for token in tokens:
        if expects:
            yield token
        expects = token == ","


def object_names(words):
    """The declarators of `type a = {}, b[2], *c`; initializers hold no comma outside of braces."""
    name, is_done = None, False
    for word in words + [","]:
        if word in (",", "=", "["):
            if name and not is_done:
                yield name
            is_done = word != ","  # what follows is a size or an initializer
        elif re.match(r"[A-Za-z_]", word):
            name = word


def macros_of(text):
    return sorted(set(re.findall(r"^#define (\w+)", text, re.M)))


# ---- rewriting -------------------------------------------------------------------------------------------------------


def made_static(text):
    """Gives everything at file scope internal linkage, but for the functions of the interface."""
    edits = []
    for item in items_of(text):
        words = item.words()
        bare = stripped(words)
        if not bare or bare[0] == "typedef" or {"static", "MLRT_INLINE", "MLRT_API"} & set(words):
            continue
        is_object = not is_function(words) and names_of(text_of(item)).ordinary
        if "extern" in words:
            edits.append((item.outer[words.index("extern")][0], "extern", "static"))
        elif is_function(words) or is_object:
            edits.append((item.outer[0][0], "", "static "))
    for start, old, new in sorted(edits, reverse=True):
        assert text.startswith(old, start)
        text = text[:start] + new + text[start + len(old) :]
    return text


def text_of(item):
    return " ".join(item.words()).replace("{}", "{ }") + ";"


def renamed(text, names, suffix):
    """
    The text with the section's name at the names given. Fields keep theirs: after a dot or an arrow, and where a struct
    declares them.
    """
    result, position, previous = [], 0, ""
    depth, struct_depths, before = 0, [], []  # before: the last two tokens
    for match in TOKEN.finditer(text):
        if match.lastgroup == "skip":
            continue
        token = match[0]
        if match.lastgroup == "directive":
            head = re.match(r"\s*#\s*define\s+\w+", token)
            if head:
                body = renamed(token[head.end() :], names, suffix)
                result += [text[position : match.start()], head[0], body]
                position = match.end()
            continue
        if token == "{":
            depth += 1
            if {"struct", "union"} & set(before):
                struct_depths.append(depth)
        elif token == "}":
            if struct_depths and struct_depths[-1] == depth:
                struct_depths.pop()
            depth -= 1
        elif match.lastgroup == "name" and previous not in (".", "->"):
            in_struct = struct_depths and struct_depths[-1] == depth
            if previous in TAGGED:
                is_ours = token in names.tags
            else:
                is_ours = token in names.types or (token in names.ordinary and not in_struct)
            if is_ours:
                result += [text[position : match.start()], token + "_" + suffix]
                position = match.end()
        previous = token
        before = before[-1:] + [token]
    return "".join(result) + text[position:]


def system_includes(names):
    lines = []
    for name in sorted(set(names)):
        if name in CONDITIONS:
            lines.append(f"#if {CONDITIONS[name]}\n#include <{name}>\n#endif\n")
        else:
            lines.append(f"#include <{name}>\n")
    return "".join(lines)


def kernel_section(kernel, text):
    before = [f"#undef {macro}\n" for macro in COUNTING_MACROS]
    gcc, clang, clang_end = "", "", ""
    if kernel.target:
        gcc = f'#pragma GCC target("{kernel.target}")\n'
        clang = f'#pragma clang attribute push(__attribute__((target("{kernel.target}"))), apply_to = function)\n'
        clang_end = "#pragma clang attribute pop\n"
    text = BEFORE_KERNELS.format(clang=clang, gcc=gcc) + "".join(before) + text
    text += AFTER_KERNELS.format(clang=clang_end)
    if kernel.condition:
        text = f"\n#if {kernel.condition}\n{text}\n#endif /* {kernel.condition} */\n"
    return text


def field_names(text):
    """Words after a dot or an arrow, and names that structs declare: all that may be a field."""
    fields = set(re.findall(r"(?:(?:\.|->)\s*|\(\*)([A-Za-z_]\w*)", text))
    for body in re.findall(r"\b(?:struct|union)\b[^;{}()]*\{([^{}]*)\}", text):
        fields.update(re.findall(r"([A-Za-z_]\w*)\s*(?:\[[^\]]*\]\s*)*[;,]", body))
    return fields


BEFORE_PASSES = """
/* ---- the kernels, once for each instruction set: this file includes itself ---- */

#define MLRT_OWN(name)          MLRT_OWN_IN(name, MLRT_PASS)
#define MLRT_OWN_IN(name, pass) MLRT_PASTE(name, pass)
#define MLRT_PASTE(name, pass)  name##_##pass
"""


def passes(parts):
    """The kernels: what is before them, for each instruction set, and their one text."""
    is_own = lambda path: uses_words(path) or path.endswith(COUNTING)
    vocabularies, seen, ends = {}, set(), {}
    for kernel in KERNELS:
        unit = read(os.path.join(SOURCE, kernel.file))
        header = re.search(r'#include "(simd/\w+\.h)"', unit)[1]
        own = set()
        text = parts.paste(os.path.join(SOURCE, header), is_own, own)
        defines = re.findall(r"^#define .*\n", unit, re.M)
        vocabularies[kernel.name] = made_static("".join(defines) + text)
        ends[kernel.name] = macros_of(vocabularies[kernel.name])
        seen |= own | {os.path.join(SOURCE, header)}
    # Every vocabulary has its words of four floats already.
    seen.update(os.path.join(SOURCE, "simd", name) for name in ("simd.h", "quad.h", "quad_sse.h", "quad_neon.h", "quad_scalar.h"))
    kernels = made_static(parts.paste(os.path.join(SOURCE, KERNEL_TEXT), is_own, seen))
    everything = "".join(vocabularies.values()) + kernels
    macros = set(macros_of(everything))
    found = names_of(everything)
    names = sorted({name for kind in found for name in kind if not name.startswith("mlrt_")} - macros)
    clashes = set(names) & field_names(parts.text_of_shared())
    # A macro would rename fields of shared structs, too: such names are given another one first.
    for name in clashes:
        only = Names(*({name} & kind for kind in found))
        kernels = renamed(kernels, only, "of_kernels")
        for key in vocabularies:
            vocabularies[key] = renamed(vocabularies[key], only, "of_kernels")
    names = sorted(name + "_of_kernels" if name in clashes else name for name in names)

    before = BEFORE_PASSES + "".join(f"#define {name} MLRT_OWN({name})\n" for name in names)
    for kernel in KERNELS:
        text = f"#define MLRT_PASS {kernel.name}\n" + vocabularies[kernel.name]
        text += '#include "mlrt.c"\n#undef MLRT_PASS\n' + "".join(f"#undef {macro}\n" for macro in ends[kernel.name])
        before += kernel_section(kernel, text)
    return before, kernels + "".join(f"#undef {macro}\n" for macro in macros_of(kernels))


def amalgamate():
    parts = Text()
    sections = []  # name, text
    for folder in LAYERS:
        for file in sorted(os.listdir(os.path.join(SOURCE, folder))):
            path = f"{folder}/{file}"
            if not file.endswith(".c"):
                continue
            sections.append((f"{folder}_{file[:-2]}", parts.paste(os.path.join(SOURCE, path), lambda path: False, set())))

    before_passes, kernels = passes(parts)
    result = [HEAD, "#ifndef MLRT_PASS\n\n", system_includes(parts.system), BEFORE_ALL, made_static(parts.text_of_shared())]
    for name, text in sections:
        macros = macros_of(text)
        names = Names(*({n for n in found if not n.startswith("mlrt_") and n not in macros} for found in names_of(text)))
        text = renamed(made_static(text), names, name)
        text += "".join(f"#undef {macro}\n" for macro in macros)
        result.append(text)
    result += [before_passes, AFTER_ALL, "\n#else /* MLRT_PASS */\n", kernels, "\n#endif /* MLRT_PASS */\n"]
    return "".join(result)


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: amalgamate.py FOLDER")
    os.makedirs(sys.argv[1], exist_ok=True)
    with open(os.path.join(sys.argv[1], "mlrt.c"), "w", encoding="utf-8") as file:
        file.write(amalgamate())
    with open(os.path.join(sys.argv[1], "mlrt.h"), "w", encoding="utf-8") as file:
        file.write(read(os.path.join(INCLUDE, "mlrt.h")))


if __name__ == "__main__":
    main()
