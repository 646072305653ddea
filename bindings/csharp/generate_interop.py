#!/usr/bin/env python3
"""Writes the C# side of the public C headers: structs, callbacks, constants and functions (P/Invoke).

    generate_interop.py --headers DIR --out NativeInterop.cs [--layout-program LAYOUT.c]

DIR holds facebaker.h and facebaker_character.h. Structs are blittable: sequential, with pointers as pointers and functions
as IntPtr, so that nothing is converted or allocated in a call. LAYOUT.c is a program that prints the size and the offsets of
every struct as the C compiler has them, to compare with. What this script does not understand in a header is an error.
Standard library only."""

from __future__ import annotations

import argparse
import os
import pathlib
import re
import sys
from typing import Dict, List, NamedTuple, Optional, Tuple

HEADERS = ("facebaker.h", "facebaker_character.h")
# C type -> C# type and size; pointers are 8 bytes, as on every platform but WebAssembly and 32-bit ones.
SCALARS: Dict[str, Tuple[str, int]] = {
    "int8_t": ("sbyte", 1), "uint8_t": ("byte", 1), "uint16_t": ("ushort", 2), "int32_t": ("int", 4), "uint32_t": ("uint", 4),
    "int64_t": ("long", 8), "uint64_t": ("ulong", 8), "float": ("float", 4), "double": ("double", 8),
    "size_t": ("UIntPtr", 8), "fb_status": ("int", 4), "char": ("byte", 1), "void": ("void", 0),
}
HANDLES = {"fb_model": "ModelHandle", "fb_scratch": "ScratchHandle"}
RAW_HANDLES = ("fb_retain", "fb_release", "fb_scratch_destroy")  # called with the pointer itself, by the handles
KEYWORDS = {"object", "in", "out", "ref", "params", "fixed", "base", "event", "lock", "string", "to_"}


class HeaderError(ValueError):
    """Something in a header that this script does not know how to write in C#."""


class Field(NamedTuple):
    """A member of a struct or a parameter: its C type without the name, and how many there are (0: no array)."""

    type: str
    name: str
    length: int
    function: bool


class Struct(NamedTuple):
    name: str
    fields: List[Field]


class Function(NamedTuple):
    name: str
    result: str
    parameters: List[Field]


class Header(NamedTuple):
    """What the headers declare, in their order."""

    constants: List[Tuple[str, str]]
    structs: List[Struct]
    callbacks: List[Function]
    functions: List[Function]


def without_comments(text: str) -> str:
    return re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.S)


def read_declaration(text: str, constants: Dict[str, str]) -> Field:
    """A member or parameter such as `const float* values` or `float rest[FB_FRAME_FLOATS]`."""
    text = " ".join(text.split())
    function = re.fullmatch(r"[\w ]+\*? ?\(\*(\w+)\)\(.*\)", text)
    if function:
        return Field("", function[1], 0, True)
    plain = re.fullmatch(r"((?:const )?\w+(?: ?\*(?: ?const)?)*\*?) ?(?<![\w])(\w+)(?:\[(\w+)\])?", text)
    if not plain:
        raise HeaderError(f"cannot read the declaration \"{text}\"")
    count = constants.get(plain[3], plain[3]) if plain[3] else "0"
    return Field(plain[1].replace(" *", "*").strip(), plain[2], int(count.rstrip("u"), 0), False)


def read_parameters(text: str, constants: Dict[str, str]) -> List[Field]:
    parts = [part.strip() for part in text.split(",")]
    return [] if parts in ([""], ["void"]) else [read_declaration(part, constants) for part in parts]


def read_headers(folder: pathlib.Path) -> Header:
    """Raises HeaderError on what it does not understand, OSError on a header that cannot be read."""
    text = "\n".join(without_comments((folder / name).read_text(encoding="utf-8")) for name in HEADERS)
    constants = re.findall(r"^[ \t]*#define (FB_[A-Z0-9_]+)[ \t]+(-?(?:0x[0-9a-fA-F]+|\d+)u?)[ \t]*$", text, flags=re.M)
    known = dict(constants)
    structs = []
    for name, body, again in re.findall(r"typedef struct (\w+) \{(.*?)\} (\w+);", text, flags=re.S):
        if name != again:
            raise HeaderError(f"struct {name} is called {again}, too")
        members = [member for member in (part.strip() for part in body.split(";")) if member]
        structs.append(Struct(name, [read_declaration(member, known) for member in members]))
    callbacks = [Function(name, result.strip(), read_parameters(parameters, known)) for result, name, parameters in
                 re.findall(r"typedef ([\w ]+?) ?\(\*(\w+)\)\((.*?)\);", text, flags=re.S)]
    functions = [Function(name, result.replace(" *", "*").strip(), read_parameters(parameters, known))
                 for result, name, parameters in re.findall(r"^FB_API ([\w \*]+?)[ ]?(\bfb_\w+)\((.*?)\);", text,
                                                            flags=re.S | re.M)]
    return Header(constants, structs, callbacks, functions)


class Writer:
    """Writes C# of a header's declarations."""

    def __init__(self, header: Header) -> None:
        self.header = header
        self.structs = {struct.name: struct for struct in header.structs}
        self.callbacks = {callback.name for callback in header.callbacks}

    def type_of(self, c_type: str) -> str:
        """Raises HeaderError on a type that is neither a scalar nor of the headers."""
        base = c_type.replace("const", "").replace(" ", "")
        stars = base.count("*")
        base = base.rstrip("*")
        if base in self.callbacks and stars == 0:
            return "IntPtr"
        if base in HANDLES and stars > 0:
            return "IntPtr" + "*" * (stars - 1)
        if base in self.structs:
            return base + "*" * stars
        if base in SCALARS:
            return SCALARS[base][0] + "*" * stars
        raise HeaderError(f"cannot write the type \"{c_type}\" in C#")

    def parameter(self, field: Field, function: str) -> str:
        handle = HANDLES.get(field.type.replace("const ", "").rstrip("*"))
        name = "@" + field.name if field.name in KEYWORDS else field.name
        if handle and function not in RAW_HANDLES:
            return f"{'out ' if field.type.endswith('**') else ''}{handle} {name}"
        return f"{self.type_of(field.type)} {name}"

    def struct_lines(self, struct: Struct) -> List[str]:
        lines = [f"    /// <summary>{struct.name} of the C headers.</summary>",
                 "    [StructLayout(LayoutKind.Sequential)]", f"    internal unsafe struct {struct.name}", "    {"]
        for field in struct.fields:
            kind = "IntPtr" if field.function else self.type_of(field.type)
            lines.append(f"        public fixed {kind} {field.name}[{field.length}];" if field.length else
                         f"        public {kind} {field.name};")
        if any(function.name == struct.name + "_fill" for function in self.header.functions):
            lines += ["", "        /// <summary>With the library's defaults.</summary>",
                      f"        public static {struct.name} Filled()", "        {", f"            {struct.name} made;",
                      f"            Native.{struct.name}_fill(&made, (uint)sizeof({struct.name}));",
                      "            return made;", "        }"]
        return lines + ["    }", ""]

    def lines(self) -> List[str]:
        lines = ["// Generated from the public headers by generate_interop.py.", "// <auto-generated/>",
                 "#pragma warning disable 649", "using System;", "using System.Runtime.InteropServices;", "", "namespace FaceBaker", "{"]
        for struct in self.header.structs:
            lines += self.struct_lines(struct)
        for callback in self.header.callbacks:
            parameters = ", ".join(self.parameter(field, callback.name) for field in callback.parameters)
            lines += ["    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]",
                      f"    internal unsafe delegate {self.type_of(callback.result)} {callback.name}({parameters});", ""]
        lines += ["    internal static unsafe partial class Native", "    {"]
        for name, value in self.header.constants:
            kind = "uint" if value.endswith("u") else "int"
            lines.append(f"        public const {kind} {name} = {value};")
        for function in self.header.functions:
            parameters = ", ".join(self.parameter(field, function.name) for field in function.parameters)
            lines += ["", "        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]",
                      f"        public static extern {self.type_of(function.result)} {function.name}({parameters});"]
        return lines + ["    }", "}"]

    def size_and_alignment(self, field: Field) -> Tuple[int, int]:
        """Of a member as sequential layout has it."""
        if field.function or field.type in self.callbacks or "*" in field.type:
            size = alignment = 8
        elif field.type in self.structs:
            layout = self.layout(self.structs[field.type])
            size, alignment = layout[0][1], max(self.size_and_alignment(f)[1] for f in self.structs[field.type].fields)
        else:
            size = alignment = SCALARS[field.type][1]
        return size * max(field.length, 1), alignment

    def layout(self, struct: Struct) -> List[Tuple[str, int]]:
        """(struct, size), then (struct.field, offset) of each, with pointers of 8 bytes."""
        offset, largest, fields = 0, 1, []
        for field in struct.fields:
            size, alignment = self.size_and_alignment(field)
            offset = -(-offset // alignment) * alignment
            fields.append((f"{struct.name}.{field.name}", offset))
            offset, largest = offset + size, max(largest, alignment)
        return [(struct.name, -(-offset // largest) * largest)] + fields

    def layout_program(self) -> str:
        """A C program that prints every layout, a line each: name, number."""
        lines = ["#include <facebaker/facebaker_character.h>", "#include <stddef.h>", "#include <stdio.h>", "int main(void) {"]
        for struct in self.header.structs:
            lines.append(f'  printf("{struct.name} %zu\\n", sizeof({struct.name}));')
            lines += [f'  printf("{struct.name}.{f.name} %zu\\n", offsetof({struct.name}, {f.name}));' for f in struct.fields]
        return "\n".join(lines + ["  return 0;", "}", ""])


def write_file(path: pathlib.Path, text: str) -> None:
    """Complete or not at all."""
    beside = path.with_name(path.name + ".part")
    beside.write_text(text, encoding="utf-8")
    os.replace(beside, path)


def main(arguments: Optional[List[str]] = None) -> int:
    parser = argparse.ArgumentParser(description="Writes the C# side of the public C headers.")
    parser.add_argument("--headers", type=pathlib.Path, required=True, help="the folder of facebaker.h")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="the C# file to write")
    parser.add_argument("--layout-program", type=pathlib.Path, help="a C program that prints the layouts")
    options = parser.parse_args(arguments)
    try:
        writer = Writer(read_headers(options.headers))
        write_file(options.out, "\n".join(writer.lines()) + "\n")
        if options.layout_program:
            write_file(options.layout_program, writer.layout_program())
    except (HeaderError, OSError) as error:
        print(f"generate_interop.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
