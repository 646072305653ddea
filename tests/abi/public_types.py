#!/usr/bin/env python3
"""Cuts a dump of abidw down to the C interface: the exported functions, the types they reach, and of structs only the
members that the public headers show. What is C++ behind it is no business of programs.

    public_types.py HEADERS <DUMP >SMALLER"""

from __future__ import annotations

import pathlib
import re
import sys
import xml.etree.ElementTree as xml
from typing import Dict, List, Set


def shown_structs(headers: pathlib.Path) -> Set[str]:
    """The structs whose members are in the headers."""
    texts = [file.read_text(encoding="utf-8") for file in sorted(headers.glob("*.h"))]
    return {name for text in texts for name in re.findall(r"typedef struct (\w+) \{", text)}


def cut(root: xml.Element, shown: Set[str]) -> xml.Element:
    types: Dict[str, xml.Element] = {}
    for one in root.iter():
        name = one.get("id")
        # The definition of a struct counts, not a declaration that another source has of it.
        if name and (name not in types or types[name].get("is-declaration-only")):
            types[name] = one
    functions = [one for one in root.iter("function-decl") if one.get("elf-symbol-id")]
    functions.sort(key=lambda one: one.get("name", ""))
    reached: Dict[str, xml.Element] = {}

    def reach(element: xml.Element) -> None:
        for one in element.iter():
            name = one.get("type-id")
            if name in types and name not in reached:
                found = types[name]
                if found.tag in ("class-decl", "union-decl") and found.get("name") not in shown:
                    attributes = {"name": found.get("name", ""), "is-struct": "yes", "visibility": "default"}
                    found = xml.Element("class-decl", {**attributes, "is-declaration-only": "yes", "id": name})
                reached[name] = found
                reach(found)

    for function in functions:
        reach(function)
    smaller = xml.Element("abi-corpus", {key: root.get(key, "") for key in ("version", "architecture", "soname")})
    for symbols in root.findall("elf-function-symbols"):
        smaller.append(symbols)
    source = xml.SubElement(smaller, "abi-instr", {"address-size": "64", "language": "LANG_C99"})
    source.extend(list(reached.values()) + functions)
    for one in smaller.iter():
        for attribute in ("path", "comp-dir-path", "filepath", "line", "column"):
            one.attrib.pop(attribute, None)
    return renumbered(smaller)


def renumbered(root: xml.Element) -> xml.Element:
    """The same with short identifiers in the order of the file."""
    names = {one.get("id", ""): f"t{number}" for number, one in enumerate(x for x in root.iter() if x.get("id"))}
    for one in root.iter():
        for attribute in ("id", "type-id", "naming-typedef-id", "def-of-decl-id"):
            if attribute in one.attrib:
                if one.attrib[attribute] in names:
                    one.attrib[attribute] = names[one.attrib[attribute]]
                elif attribute != "type-id":
                    del one.attrib[attribute]
    return root


def main(arguments: List[str]) -> int:
    root = cut(xml.parse(sys.stdin).getroot(), shown_structs(pathlib.Path(arguments[0])))
    for one in root.iter():
        one.text = one.tail = None
    xml.indent(root, " ")
    sys.stdout.write(xml.tostring(root, encoding="unicode") + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
