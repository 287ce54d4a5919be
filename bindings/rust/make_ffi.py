#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes src/ffi.rs from include/mlrt.h: make_ffi.py [--check]. With --check, fails if the file is another."""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import interface  # noqa: E402

HEAD = """\
// SPDX-License-Identifier: MIT
//! The C interface, as in `mlrt.h`. `Default` of a struct sets its `struct_size`; all else is 0.
//!
//! Written by make_ffi.py: change the header instead.

use std::ffi::{c_char, c_void};
use std::marker::{PhantomData, PhantomPinned};

/// The stride of an input array whose one element serves all rays.
pub const MLRT_STRIDE_ALL: usize = usize::MAX;
"""

SCALARS = {"int32_t": "i32", "uint32_t": "u32", "uint64_t": "u64", "uint8_t": "u8", "size_t": "usize", "float": "f32", "double": "f64",
           "char": "c_char", "void": "c_void"}

# Constants by the type of the field or result that holds them: those of signed fields, the rest being u32.
SIGNED = r"MLRT_(OK|ERROR|TREE|KDTREE|METHOD|ISA|QUERY|CULLING|PROJECTION|LIGHT|LOG)(_|$)"


def rust_type(c: str, count: str = "", callbacks: frozenset = frozenset()) -> str:
    if c in callbacks:
        return f"Option<{c}>" if c != "mlrt_task_function" else c
    match = re.fullmatch(r"(const )?(\w+)\s*(\**)", c)
    constant, base, stars = match.groups()
    text = SCALARS.get(base, base)
    for _ in stars:
        text = ("*const " if constant else "*mut ") + text
        constant = None
    return f"[{text}; {count}]" if count else text


def document(text: str, indent: str = "") -> str:
    """Texts of the header are no Markdown: those of several lines stay as they are, others have their marks escaped."""
    if "\n" in text:
        return "".join(f"{indent}/// {line}".rstrip() + "\n" for line in ["```text", *text.split("\n"), "```"])
    return f"{indent}/// " + re.sub(r"([\[\]<>*\\])", r"\\\1", text) + "\n"


def constant_type(name: str) -> str:
    if re.match(SIGNED, name):
        return "i32"
    return "usize" if name.startswith("MLRT_STRUCT_") else "u64" if name.startswith("MLRT_CAN_") else "u32"


def parameter_list(function: interface.Function, callbacks: frozenset) -> str:
    return ", ".join(
        f"{p.name}: " + (f"*mut {SCALARS[p.type]}" if p.count else rust_type(p.type, "", callbacks)) for p in function.parameters
    )


def write() -> str:
    header = interface.read()
    callbacks = frozenset(callback.name for callback in header.callbacks)
    text = HEAD
    for c in header.constants:
        if c.name.startswith("MLRT_STRUCT_") and c.name == "MLRT_STRUCT_COUNT":
            continue
        text += "\n" + document(c.text) + f"pub const {c.name}: {constant_type(c.name)} = {c.value};\n"
    for handle in header.handles:
        text += f"\n/// A handle: `{handle}` of the header.\n#[repr(C)]\npub struct {handle} {{\n"
        text += "    _data: [u8; 0],\n    _marker: PhantomData<(*mut u8, PhantomPinned)>,\n}\n"
    for f in header.callbacks:
        result = "" if f.result == "void" else f" -> {rust_type(f.result)}"
        text += "\n" + document(f.text) + f"pub type {f.name} = unsafe extern \"C\" fn({parameter_list(f, callbacks)}){result};\n"
    for s in header.structs:
        text += "\n" + document(s.text) + f"#[repr(C)]\n#[derive(Clone, Copy, Debug)]\npub struct {s.name} {{\n"
        for field in s.fields:
            text += document(field.text, "    ") + f"    pub {field.name}: {rust_type(field.type, field.count, callbacks)},\n"
        size = "struct_size: std::mem::size_of::<Self>() as u32, " if s.fields[0].name == "struct_size" else ""
        text += f"}}\n\nimpl Default for {s.name} {{\n    fn default() -> Self {{\n"
        text += "        // SAFETY: numbers, pointers and optional functions: all may be 0.\n"
        text += f"        let zero: Self = unsafe {{ std::mem::zeroed() }};\n"
        text += f"        Self {{ {size}..zero }}\n" if size else "        zero\n"
        text += "    }\n}\n"
    text += '\nextern "C" {\n'
    for f in header.functions:
        result = "" if f.result == "void" else f" -> {rust_type(f.result)}"
        text += "\n" + document(f.text, "    ") + f"    pub fn {f.name}({parameter_list(f, callbacks)}){result};\n"
    text += "}\n\n/// The places of all fields and the sizes of all structs: (struct, field, offset), (struct, \"sizeof\", size).\n"
    text += "#[doc(hidden)]\npub fn layouts() -> Vec<(&'static str, &'static str, usize)> {\n    use std::mem::{offset_of, size_of};\n    vec![\n"
    for s in header.structs:
        for field in s.fields:
            text += f'        ("{s.name}", "{field.name}", offset_of!({s.name}, {field.name})),\n'
        text += f'        ("{s.name}", "sizeof", size_of::<{s.name}>()),\n'
    return text + "    ]\n}\n"


def main() -> int:
    file = HERE / "src" / "ffi.rs"
    if "--check" in sys.argv[1:]:
        if file.read_text() != write():
            print(f"{file.name} is not that of mlrt.h: python3 bindings/rust/make_ffi.py writes it anew")
            return 1
        return 0
    file.write_text(write())
    return 0


if __name__ == "__main__":
    sys.exit(main())
